"""Camera that shows given points in the part of its picture that nothing covers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from abi.arrays import FloatArray

_MARGIN = 0.07
"""Part of the uncovered picture that stays empty around the points, as room for labels."""

_QUARTER = math.pi / 2
_RISE, _ASIDE = math.radians(30), math.radians(15)
"""Angles of a view that shows boxes large: above the ground, and from the middle of a side."""


@dataclass(frozen=True)
class Window:
    """Shape of a picture, and how much of each edge is covered.

    Attributes:
        fov: angle from its lower to its upper edge, [rad].
        aspect: width over height.
        above: covered part of its height, from the upper edge, 0 to 1.
        below: the same from the lower edge; both together cover less than all of it.
    """

    fov: float
    aspect: float
    above: float = 0.0
    below: float = 0.0

    def slopes(self, margin: float) -> tuple[float, float, float]:
        """Slopes of the planes through the eye and its edges: the sides', the upper, the lower.

        Args:
            margin: part of the free picture to leave out at each edge.
        """
        half = (1 - margin) * math.tan(self.fov / 2)
        return half * self.aspect, half * (1 - 2 * self.above), half * (1 - 2 * self.below)


def stand(
    points: FloatArray, direction: FloatArray, window: Window
) -> tuple[FloatArray, FloatArray]:
    """Position and target, (3,) each, of the nearest camera that sees all points.

    Each edge of the window is the trace of a plane through the eye. In the camera's axes, z into
    the picture, a point is on the inner side of the right one where x − cx ≤ s·(z − cz), s the
    edge's slope. So the points bound cx − s·cz for each edge, and the bounds of opposite edges
    meet at the greatest cz.

    Args:
        points: (n, 3), [unit], world.
        direction: from the points to the camera, not upright; of any length.
        window: where they are to be seen.
    """
    right, up, forward = axes(direction)
    x, y, z = points @ right, points @ up, points @ forward
    side, top, bottom = window.slopes(_MARGIN)
    to_right, to_left = (x - side * z).max(), (-x - side * z).max()
    to_top, to_bottom = (y - top * z).max(), (-y - bottom * z).max()
    depth = min(-(to_right + to_left) / (2 * side), -(to_top + to_bottom) / (top + bottom))
    across = (to_right - to_left) / 2
    height = (to_top - to_bottom + (top - bottom) * depth) / 2
    position = across * right + height * up + depth * forward
    return position, position + (z.mean() - depth) * forward


def widest(points: FloatArray, direction: FloatArray, window: Window) -> FloatArray:
    """Whichever of two directions (3,) near a given one shows the points wider.

    Both look at a side of what is upright, a little from above and from the corner.

    Args:
        points: (n, 3), [unit].
        direction: from the points to the camera, of any length.
        window: where they are to be seen.
    """
    x, y, z = direction
    around = math.atan2(y, x)
    first = math.floor(around / _QUARTER) * _QUARTER
    length = math.hypot(x, y)
    height = math.copysign(max(abs(z), length * math.tan(_RISE)), z)
    turned = (first + _ASIDE, first + _QUARTER - _ASIDE)
    both = [np.array([length * math.cos(a), length * math.sin(a), height]) for a in turned]
    return max(both, key=lambda one: covered(points, *stand(points, one, window), window)[0])


def covered(
    points: FloatArray, position: FloatArray, target: FloatArray, window: Window
) -> tuple[float, float]:
    """Parts of the picture's width and height that the points take; arguments as for
    :func:`lift`."""
    right, up, forward = axes(position - target)
    away = points - position
    depth = 2 * math.tan(window.fov / 2) * (away @ forward)
    return float(np.ptp(away @ right / depth)) / window.aspect, float(np.ptp(away @ up / depth))


def lift(
    points: FloatArray, position: FloatArray, target: FloatArray, window: Window
) -> tuple[FloatArray, FloatArray]:
    """Position and target, (3,) each, of a camera moved down until no point is below the window.

    As far away and turned as before; not so far that a point leaves the window's upper edge.

    Args:
        points: (n, 3), [unit], world.
        position: of the camera (3,), [unit].
        target: what it looks at (3,), [unit], not straight above or below it.
        window: where they are to be seen.
    """
    _, up, forward = axes(position - target)
    away = points - position
    y, z = away @ up, away @ forward
    _, top, bottom = window.slopes(_MARGIN)
    step = max(min((-y - bottom * z).max(), (top * z - y).min()), 0.0)
    return position - step * up, target - step * up


def holds(points: FloatArray, position: FloatArray, target: FloatArray, window: Window) -> bool:
    """Check whether a camera sees all points uncovered; arguments as for :func:`lift`."""
    right, up, forward = axes(position - target)
    away = points - position
    x, y, z = away @ right, away @ up, away @ forward
    side, top, bottom = window.slopes(0.0)
    inside = (np.abs(x) <= side * z) & (y <= top * z) & (y >= -bottom * z)
    return bool(inside.all())


def axes(direction: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Axes (3,) of a camera: right, up and into the picture, with world z upwards.

    Args:
        direction: from what it looks at to the camera, not upright; of any length.
    """
    forward = -np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    return right, np.cross(right, forward), forward
