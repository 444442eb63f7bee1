"""The workspace box and the ground."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import viser

from abi.scene.settings import Workspace
from app.drawing.box import box_edges
from app.drawing.lines import add_line
from app.state.frame import Frame, Layer, Switch
from app.ui import style
from app.ui.layout import Layout


class WorkspaceLayer(Layer):
    """Edges of the meshed box, and a grid below it."""

    switches: ClassVar[tuple[Switch, ...]] = (
        Switch("workspace", "workspace box", style.WORKSPACE),
    )

    def __init__(self, layout: Layout) -> None:
        self._scene = layout.client.scene
        self._box = add_line(self._scene, "/workspace", style.WORKSPACE, 1.5)
        self._grid: viser.GridHandle | None = None
        self._drawn: tuple[Workspace, float] | None = None

    def draw(self, frame: Frame) -> None:
        """Draw the box, and the ground below it and the arm's base."""
        self._box.visible = "workspace" in frame.shown
        scene = frame.plan.scene
        state = scene.workspace, scene.arm.base[2]
        if state != self._drawn:
            self._drawn = state
            self._draw_box(*state)

    def _draw_box(self, workspace: Workspace, base: float) -> None:
        self._box.points = box_edges(workspace.min, workspace.max).astype(np.float32)
        longest = max(workspace.size)
        centre = np.add(workspace.min, workspace.max) / 2
        ground = min(workspace.min[2], base) - 0.002 * longest
        self._grid = self._scene.add_grid(
            "/ground",
            width=4 * longest,
            height=4 * longest,
            cell_size=longest / 6,
            section_size=longest,
            cell_color=style.WORKSPACE,
            section_color=style.WORKSPACE,
            cell_thickness=0.6,
            section_thickness=1.0,
            fade_distance=3.2 * longest,
            fade_strength=1.5,
            fade_from="origin",
            shadow_opacity=0.1,
            position=(centre[0], centre[1], ground),
        )
