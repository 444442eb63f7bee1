"""What shows where things are: the workspace box, the ground, arrows, and a line to the floor.

The arrows, beside a corner of the box, say where x, y and z lead, and in which unit. The line, with
a cross at its foot, is below what is dragged: where that is in depth.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.obstacles.pose import Vec3
from abi.scene.scene import Scene
from abi.scene.settings import Workspace
from app.drawing.box import box_edges
from app.drawing.lines import Segments, add_line
from app.layers.drop_line import moved_place, places_of, to_floor
from app.state.frame import Frame, Layer, Switch
from app.ui import style
from app.ui.layout import Layout

_LENGTH = 0.2
"""Of an arrow, as a part of the workspace's longest side."""
_HEAD = (0.72, 0.1)
"""Where an arrow's head begins, and its half width, as parts of the arrow's length."""
_APART = 0.09
"""Distance to the workspace's corner, along x and y, as a part of its longest side."""
_LETTERS = 0.85
"""Scale of the labels beside that of all others."""


class WorkspaceLayer(Layer):
    """Edges of the meshed box, a grid below it, and arrows in the plots' colours of the axes.

    Neither arrows nor their labels take the mouse. Below an obstacle or end that is moved there is
    a line, until another one is.
    """

    switches: ClassVar[tuple[Switch, ...]] = (
        Switch("workspace", "workspace box", style.WORKSPACE),
        Switch("axes", "axes x, y, z", None),
    )

    def __init__(self, layout: Layout) -> None:
        self._scene = layout.client.scene
        self._box = add_line(self._scene, "/workspace", style.WORKSPACE, 1.5)
        self._grid: viser.GridHandle | None = None
        self._corner = self._scene.add_frame("/axes", show_axes=False)
        self._arrows = [
            add_line(self._scene, f"/axes/{name}", colour, 2.0)
            for name, colour in zip("xyz", style.AXES, strict=True)
        ]
        self._labels = [
            self._scene.add_label(f"/axes/{name}/label", name, anchor="center-center")
            for name in "xyz"
        ]
        self._drawn: tuple[Workspace, float, str] | None = None
        self._drop_line = add_line(self._scene, "/drop_line", style.POINT, 2.5)
        self._drop_line.visible = False
        self._places: tuple[Vec3, ...] = ()

    def draw(self, frame: Frame) -> None:
        """Draw the box, the ground below it and the arm's base, and the arrows."""
        self._box.visible = "workspace" in frame.shown
        self._corner.visible = "axes" in frame.shown
        for label in self._labels:
            label.font_screen_scale = round(_LETTERS * frame.label_scale, 3)
        scene = frame.plan.scene
        state = scene.workspace, scene.arm.base[2], scene.unit
        if state != self._drawn:
            self._drawn = state
            self._draw_box(scene.workspace, scene.arm.base[2])
            self._place_axes(scene.workspace, scene.unit)
        self._draw_drop_line(scene, frame.interactive)

    def _draw_drop_line(self, scene: Scene, interactive: bool) -> None:
        """Draw the line below what a hand moves; whatever else moves takes it away."""
        places = places_of(scene)
        if places == self._places:
            return
        place = moved_place(self._places, places) if interactive else None
        self._places = places
        self._drop_line.visible = place is not None
        if place is not None:
            self._drop_line.points = to_floor(place, scene)

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

    def _place_axes(self, workspace: Workspace, unit: str) -> None:
        longest = max(workspace.size)
        # nearest to the usual camera, where nothing else is
        corner = np.array([workspace.max[0], workspace.min[1], workspace.min[2]])
        self._corner.position = corner + _APART * longest * np.array([1.0, -1.0, 0.0])
        for axis, (arrow, label) in enumerate(zip(self._arrows, self._labels, strict=True)):
            tip = _LENGTH * longest * np.eye(3)[axis]
            arrow.points = _arrow(tip, np.eye(3)[axis - 1 if axis else 1])
            # one unit for all: three would crowd so small a place
            label.text = f"z [{unit}]" if axis == 2 else "xyz"[axis]
            label.position = 1.2 * tip


def _arrow(tip: FloatArray, side: FloatArray) -> Segments:
    """Segments (3, 2, 3) of an arrow from the origin to a tip (3,), its head along ``side``."""
    begin, width = _HEAD
    across = width * np.linalg.norm(tip) * side
    barbs = [begin * tip + across, begin * tip - across]
    return np.array([[np.zeros(3), tip], *([barb, tip] for barb in barbs)], np.float32)
