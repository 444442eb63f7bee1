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
    """The line and a cross at its foot, from when one obstacle or end is moved until another is."""

    def __init__(self, layout: Layout) -> None:
        self._line = add_line(layout.client.scene, "/drop_line", style.POINT, 2.5)
        self._line.visible = False
        self._places: tuple[Vec3, ...] = ()

    def draw(self, frame: Frame) -> None:
        """Draw the line below what a hand moves; whatever else moves takes it away."""
        scene = frame.plan.scene
        places = (scene.start, scene.goal, *(one.position for one in scene.obstacles))
        if places == self._places:
            return
        place = moved_place(self._places, places) if frame.interactive else None
        self._places = places
        self._line.visible = place is not None
        if place is not None:
            self._line.points = _to_floor(place, scene)


def moved_place(before: tuple[Vec3, ...], now: tuple[Vec3, ...]) -> Vec3 | None:
    """The one place that is another than before; None unless it is one, of as many."""
    if len(before) != len(now):
        return None
    moved = [place for old, place in zip(before, now, strict=True) if old != place]
    return moved[0] if len(moved) == 1 else None


def _to_floor(place: Vec3, scene: Scene) -> Segments:
    """Segments (3, 2, 3) from a place straight down, and of the cross there."""
    foot = np.array([place[0], place[1], scene.workspace.min[2]])
    arm = _MARK * max(scene.workspace.size)
    sides = [(foot - step, foot + step) for step in arm * np.eye(3)[:2]]
    return np.array([(place, foot), *sides], np.float32)
