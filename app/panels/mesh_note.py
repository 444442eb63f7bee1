"""Note on the chosen mesh: its size, its repairs, and a better unit where it is out of scale."""

from __future__ import annotations

import html

import viser

from abi.obstacles.mesh_shape import MeshShape, suggest_unit
from abi.scene.scene import Scene
from app.numbers import format_setting
from app.panels.widgets import Wake


class MeshNote:
    """A paragraph, and a button that takes over the suggested unit."""

    def __init__(self, gui: viser.GuiApi, wake: Wake) -> None:
        self._text = gui.add_html("", visible=False)
        self._button = gui.add_button("", visible=False)
        self._button.on_click(wake)
        self._suggested = ""

    def accepted(self) -> str | None:
        """The suggested unit if the button was pressed since the last call."""
        if not self._button.value:
            return None
        self._button.value = False
        return self._suggested or None

    def write(self, mesh: MeshShape | None, scene: Scene) -> None:
        """Describe ``mesh``, an obstacle of ``scene``; None hides the note."""
        self._suggested, notes = "", []
        if mesh is not None:
            extent = mesh.surface.extent * mesh.factor
            unit = mesh.unit or scene.unit
            self._suggested = suggest_unit(extent, scene.workspace.size, unit) or ""
            width = f"{format_setting(extent)} {scene.unit}"
            notes = [f"{len(mesh.surface.faces):,} triangles, {width} wide."]
            notes += mesh.surface.notes
        if self._suggested:
            notes.append(
                f"That is far from the workspace's size: is the file in {self._suggested}?"
            )
            self._button.label = f"Yes, read it in {self._suggested}"
        self._button.visible = bool(self._suggested)
        self._text.visible = bool(notes)
        text = html.escape(" ".join(notes))
        self._text.content = f'<div style="margin:0 10px;font-size:12.5px">{text}</div>'
