"""Sizes of one obstacle as numbers; for a mesh, its scale and the unit of its file."""

from __future__ import annotations

from typing import Any

import viser

from app.panels.widgets import DIGITS, Wake, label_of

_FIELDS = ("size", "radius", "height", "scale", "unit")
_UNITS: dict[str, str | None] = {"its own unit": None, "m": "m", "cm": "cm", "mm": "mm"}


class ObstacleSizes:
    """One widget for each size that a shape can have; those of other shapes are hidden."""

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

    def fit(self, unit: str, step: float) -> None:
        """Name the unit of the scene's lengths in the labels; one press adds ``step``, [unit]."""
        for name in ("size", "radius", "height"):
            getattr(self, name).label = f"{name} [{unit}]"
            getattr(self, name).step = step

    def choose_unit(self, unit: str) -> None:
        """Choose the unit of a mesh file."""
        self.unit.value = label_of(_UNITS, unit)

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
