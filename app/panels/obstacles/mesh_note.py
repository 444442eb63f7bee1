"""Note on the chosen mesh: its file, size and repairs, and buttons for another size."""

from __future__ import annotations

import html

import viser

from abi.obstacles.mesh_shape import MeshShape, file_factor, suggest_unit
from abi.obstacles.pose import METRES
from abi.obstacles.triangle_mesh.surface import Surface
from abi.scene.scene import Scene
from app.drawing.mesh_picture import MOST_DRAWN
from app.panels.widgets import Wake, pressed
from app.ui.numbers import format_setting

_FITTED = 1 / 3
_LEAST, _MOST = 1 / 12, 3 / 4
"""Sizes, as parts of the workspace's longest side: when fitted, and between which none is."""


def fitted_scale(surface: Surface, scene: Scene, unit: str | None = None) -> float:
    """Scale that makes a mesh a third of the workspace; 1 where its size will do as it is.

    Args:
        surface: of the mesh.
        scene: whose workspace it is to fit.
        unit: of the file; None for the one that the file gives, or else the scene's.
    """
    largest, extent = max(scene.workspace.size), _own_extent(surface, scene, unit)
    if _LEAST <= extent / largest <= _MOST:
        return 1.0
    return max(float(f"{_FITTED * largest / extent:.3g}"), 1e-6)


def _own_extent(surface: Surface, scene: Scene, unit: str | None) -> float:
    """Longest side of a file's bounds at scale 1, [unit]."""
    return surface.extent * file_factor(surface, unit, scene.unit)


class MeshNote:
    """A paragraph, and buttons for the size of the file, a size that fits and a likely unit."""

    def __init__(self, gui: viser.GuiApi, wake: Wake) -> None:
        self._text = gui.add_html("", visible=False)
        self._resize = gui.add_button("Original size", visible=False)
        self._button = gui.add_button("", visible=False)
        self._edges = gui.add_checkbox("show edges", False, visible=False)
        self._edges.on_update(wake)
        self._resize.on_click(wake)
        self._button.on_click(wake)
        self._suggested = ""
        self._other_scale = 1.0

    def accepted(self) -> str | None:
        """The suggested unit if the button was pressed since the last call."""
        return (self._suggested or None) if pressed(self._button) else None

    def resized(self) -> float | None:
        """The scale that the button beside the size stands for, if it was pressed."""
        return self._other_scale if pressed(self._resize) else None

    @property
    def edges(self) -> bool:
        """Whether the edges of meshes are to be seen."""
        return self._edges.value is True

    def write(self, mesh: MeshShape | None, scene: Scene) -> None:
        """Describe ``mesh``, an obstacle of ``scene``; None hides the note."""
        self._suggested, notes = "", []
        self._resize.visible = False
        self._edges.visible = mesh is not None
        if mesh is not None:
            extent = mesh.surface.extent * mesh.factor
            metres = METRES[scene.unit] * file_factor(mesh.surface, mesh.unit, scene.unit)
            self._suggested = suggest_unit(extent, scene.workspace.size, metres) or ""
            count = len(mesh.surface.faces)
            notes = [f"{mesh.file}: {count:,} triangles, {_length(extent, scene)} wide."]
            notes += mesh.notes
            if count > MOST_DRAWN:
                notes.append("Planning uses all of them; the picture shows fewer.")
            notes += self._offer_size(mesh, scene)
        if self._suggested:
            notes.append(
                f"That is far from the workspace's size: is the file in {self._suggested}?"
            )
            self._button.label = f"Yes, read it in {self._suggested}"
        self._button.visible = bool(self._suggested)
        self._text.visible = bool(notes)
        text = html.escape(" ".join(notes))
        self._text.content = f'<div style="margin:0 10px;font-size:12.5px">{text}</div>'

    def _offer_size(self, mesh: MeshShape, scene: Scene) -> list[str]:
        """Offer the size of the file where the mesh was fitted, and one that fits elsewhere."""
        own = _own_extent(mesh.surface, scene, mesh.unit)
        fitting = fitted_scale(mesh.surface, scene, mesh.unit)
        if mesh.scale == fitting != 1:
            self._other_scale = 1.0
            self._resize.label = f"Original size: {_length(own, scene)}"
            self._resize.visible = True
            return ["It was scaled to fit the workspace."]
        largest = max(scene.workspace.size)
        if not _LEAST <= mesh.surface.extent * mesh.factor / largest <= _MOST:
            self._other_scale = float(f"{_FITTED * largest / own:.3g}")
            self._resize.label = "Fit to the workspace"
            self._resize.visible = True
        return []


def _length(length: float, scene: Scene) -> str:
    digits = f"{length:,.0f}" if length >= 1000 else format_setting(length)
    return f"{digits} {scene.unit}"
