"""Sizes of one obstacle as numbers; for a mesh, its scale, its file's unit, and a note on both."""

from __future__ import annotations

from typing import Any

import viser

from abi.obstacles.mesh_shape import MeshShape
from abi.scene.scene import Scene
from app.panels.obstacles.mesh_note import mesh_note, other_scale, suggested_unit
from app.panels.widgets import DIGITS, Wake, label_of, pressed

_FIELDS = ("size", "radius", "height", "scale", "unit")
_UNITS: dict[str, str | None] = {"its own unit": None, "m": "m", "cm": "cm", "mm": "mm"}


class ObstacleSizes:
    """One widget for each size that a shape can have; those of other shapes are hidden.

    Below them is a note on a mesh, and buttons for the size of its file, a size that fits, and a
    likely unit.
    """

    def __init__(self, gui: viser.GuiApi, wake: Wake) -> None:
        self.size = gui.add_vector3(
            "size", (1.0, 1.0, 1.0), step=0.1, hint="Edge lengths, all above 0."
        )
        self.radius = gui.add_number("radius", 1.0, step=0.1, hint="Above 0.")
        self.height = gui.add_number(
            "height",
            1.0,
            step=0.1,
            hint="Above 0. Of a capsule, from the centre of one cap to the other's.",
        )
        self.scale = gui.add_number(
            "scale", 1.0, step=0.1, hint="Factor for the lengths in the file. Above 0."
        )
        self.unit = gui.add_dropdown(
            "file's unit",
            tuple(_UNITS),
            hint="The unit of the file. Its own is the one that it gives, or else the scene's.",
        )
        for box in (self.size, self.radius, self.height, self.scale):
            box.precision = DIGITS
            box.on_update(wake)
        self.unit.on_update(wake)
        self._note = gui.add_html("", visible=False)
        self._resize = gui.add_button("Original size", visible=False)
        self._take_unit = gui.add_button("", visible=False)
        self._edges = gui.add_checkbox("show edges", False, visible=False)
        self._edges.on_update(wake)
        for button in (self._resize, self._take_unit):
            button.on_click(wake)
        self._other_scale, self._suggested = 1.0, ""

    @property
    def shows_edges(self) -> bool:
        """Whether the edges of meshes are to be seen."""
        return self._edges.value is True

    def fit(self, unit: str, step: float) -> None:
        """Name the unit of the scene's lengths in the labels; one press adds ``step``, [unit]."""
        for name in ("size", "radius", "height"):
            getattr(self, name).label = f"{name} [{unit}]"
            getattr(self, name).step = step

    def take_offers(self) -> None:
        """Set the scale or unit whose button was pressed since the last call."""
        if pressed(self._resize):
            self.scale.value = self._other_scale
        if pressed(self._take_unit) and self._suggested:
            self.unit.value = label_of(_UNITS, self._suggested)

    def describe(self, mesh: MeshShape | None, scene: Scene) -> None:
        """Describe ``mesh``, an obstacle of ``scene``, and offer other sizes; None hides that."""
        self._suggested = "" if mesh is None else suggested_unit(mesh, scene)
        offered = None if mesh is None else other_scale(mesh, scene)
        self._note.visible = self._edges.visible = mesh is not None
        self._take_unit.visible, self._resize.visible = bool(self._suggested), offered is not None
        if mesh is not None:
            self._note.content = mesh_note(mesh, scene)
        if offered is not None:
            self._resize.label, self._other_scale = offered
        if self._suggested:
            self._take_unit.label = f"Yes, read it in {self._suggested}"

    def read(self, data: dict[str, Any]) -> dict[str, Any]:
        """Read the sizes that ``data`` has, an obstacle as in a scene file."""
        sizes = {name: getattr(self, name).value for name in _FIELDS if name in data}
        if "unit" in sizes:
            sizes["unit"] = _UNITS[sizes["unit"]]
        if "size" in sizes:
            sizes["size"] = list(sizes["size"])
        return sizes

    def write(self, data: dict[str, Any]) -> None:
        """Show the sizes that ``data`` has, and no others."""
        for name in _FIELDS:
            handle = getattr(self, name)
            handle.visible = name in data
            if name == "unit" and name in data:
                handle.value = label_of(_UNITS, data[name])
            elif name in data:
                handle.value = tuple(data[name]) if name == "size" else data[name]
