"""A line from what is dragged down to the floor: where it is in depth."""

from __future__ import annotations

import numpy as np

from abi.obstacles.pose import Vec3
from abi.scene.scene import Scene
from app.drawing.lines import Segments

_MARK = 0.06
"""Half width of the cross on the floor, as a part of the workspace's longest side."""


def places_of(scene: Scene) -> tuple[Vec3, ...]:
    """Places of all that a hand can move in a scene: its ends and obstacles."""
    return (scene.start, scene.goal, *(one.position for one in scene.obstacles))


def moved_place(before: tuple[Vec3, ...], now: tuple[Vec3, ...]) -> Vec3 | None:
    """The one place that is another than before; None unless it is one, of as many."""
    if len(before) != len(now):
        return None
    moved = [place for old, place in zip(before, now, strict=True) if old != place]
    return moved[0] if len(moved) == 1 else None


def to_floor(place: Vec3, scene: Scene) -> Segments:
    """Segments (3, 2, 3) from a place straight down, and of the cross there."""
    foot = np.array([place[0], place[1], scene.workspace.min[2]])
    arm = _MARK * max(scene.workspace.size)
    sides = [(foot - step, foot + step) for step in arm * np.eye(3)[:2]]
    return np.array([(place, foot), *sides], np.float32)
