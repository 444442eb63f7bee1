"""What shows where things are: the workspace box, the ground, arrows, and a line to the floor.

The arrows, beside a corner of the box, say where x, y and z lead, and in which unit. The line, with
a cross at its foot, is below what is dragged: where that is in depth.
"""

from __future__ import annotations

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.obstacles.pose import Vec3
from abi.scene.settings import Workspace
from app.drawing.box import box_edges
from app.drawing.lines import Segments, add_line
from app.layers.drop_line import moved_place, places_of, to_floor
from app.state.frame import Draw, Frame
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


def workspace_layer(layout: Layout) -> Draw:
    """Edges of the meshed box, a grid below it, and arrows in the plots' colours of the axes.

    Neither arrows nor their labels take the mouse. Below an obstacle or end that is moved there is
    a line, until another one is.
    """
    nodes = layout.client.scene
    box = add_line(nodes, "/workspace", style.WORKSPACE, 1.5)
    corner = nodes.add_frame("/axes", show_axes=False)
    arrows = [
        add_line(nodes, f"/axes/{name}", colour, 2.0)
        for name, colour in zip("xyz", style.AXES, strict=True)
    ]
    labels = [
        nodes.add_label(f"/axes/{name}/label", name, anchor="center-center") for name in "xyz"
    ]
    drop_line = add_line(nodes, "/drop_line", style.POINT, 2.5)
    drop_line.visible = False
    drawn: tuple[Workspace, float, str] | None = None
    places: tuple[Vec3, ...] = ()

    def draw(frame: Frame) -> None:
        nonlocal drawn, places
        box.visible = "workspace" in frame.shown
        corner.visible = "axes" in frame.shown
        for label in labels:
            label.font_screen_scale = round(_LETTERS * frame.label_scale, 3)
        scene, before = frame.plan.scene, places
        workspace = scene.workspace
        state = workspace, scene.arm.base[2], scene.unit
        if state != drawn:
            drawn = state
            box.points = box_edges(workspace.min, workspace.max).astype(np.float32)
            _add_ground(nodes, workspace, scene.arm.base[2])
            # nearest to the usual camera, where nothing else is
            place = np.array([workspace.max[0], workspace.min[1], workspace.min[2]])
            corner.position = place + _APART * max(workspace.size) * np.array([1.0, -1.0, 0.0])
            _set_arrows(arrows, labels, _LENGTH * max(workspace.size), scene.unit)
        places = places_of(scene)
        if places != before:
            # below what a hand moves; whatever else moves takes it away
            moved = moved_place(before, places) if frame.interactive else None
            drop_line.visible = moved is not None
            if moved is not None:
                drop_line.points = to_floor(moved, scene)

    return draw


def _add_ground(nodes: viser.SceneApi, workspace: Workspace, base: float) -> None:
    """Put a grid below the workspace and the arm's base."""
    longest = max(workspace.size)
    centre = np.add(workspace.min, workspace.max) / 2
    ground = min(workspace.min[2], base) - 0.002 * longest
    nodes.add_grid(
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


def _set_arrows(
    arrows: list[viser.LineSegmentsHandle],
    labels: list[viser.LabelHandle],
    length: float,
    unit: str,
) -> None:
    """Draw the arrows along x, y and z, ``length`` [unit] long, with their letters."""
    for axis, (arrow, label) in enumerate(zip(arrows, labels, strict=True)):
        tip = length * np.eye(3)[axis]
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
