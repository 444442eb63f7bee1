"""A line from what is dragged down to the floor: where it is in depth."""

from __future__ import annotations

import numpy as np

from abi.obstacles.pose import Vec3
from abi.scene.scene import Scene
from app.drawing.lines import Segments, add_line
from app.state.frame import Frame, Layer
from app.ui import style
from app.ui.layout import Layout

_MARK = 0.06
"""Half width of the cross on the floor, as a part of the workspace's longest side."""


class DropLineLayer(Layer):
    """The line and a cross at its foot, while one obstacle or end moves."""

    def __init__(self, layout: Layout) -> None:
        self._line = add_line(layout.client.scene, "/drop_line", style.POINT, 2.5)
        self._line.visible = False
        self._before: Scene | None = None

    def draw(self, frame: Frame) -> None:
        """Draw the line below what has moved since the input rested."""
        scene = frame.plan.scene
        if not frame.interactive or self._before is None:
            self._before = scene
        place = moved_place(self._before, scene)
        self._line.visible = place is not None
        if place is not None:
            self._line.points = _to_floor(place, scene)


def moved_place(before: Scene, now: Scene) -> Vec3 | None:
    """Place of the one obstacle or end that has moved, [unit], world; None unless it is one."""
    if len(before.obstacles) != len(now.obstacles) or before.unit != now.unit:
        return None
    old, new = (
        (scene.start, scene.goal, *(one.position for one in scene.obstacles))
        for scene in (before, now)
    )
    moved = [place for earlier, place in zip(old, new, strict=True) if earlier != place]
    return moved[0] if len(moved) == 1 else None


def _to_floor(place: Vec3, scene: Scene) -> Segments:
    """Segments (3, 2, 3) from a place straight down, and of the cross there."""
    foot = np.array([place[0], place[1], scene.workspace.min[2]])
    arm = _MARK * max(scene.workspace.size)
    sides = [(foot - step, foot + step) for step in arm * np.eye(3)[:2]]
    return np.array([(place, foot), *sides], np.float32)
