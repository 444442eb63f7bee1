"""Triangles of a link's shapes, in floating point: what its pieces hold, and what it touches."""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray
from abi.robot.urdf.link import LinkShape

_SIDES = 192


def shape_triangles(shape: LinkShape, around: bool = False) -> FloatArray:
    """Triangles (n, 3, 3) of a shape in its own frame, [m]; those of a cylinder in or around it."""
    a, b, c = shape.size
    if shape.kind == "mesh":
        return np.asarray(shape.vertices[shape.faces])
    if shape.kind == "sphere":
        return np.zeros((1, 3, 3))
    if shape.kind == "box":
        return prism(rectangle(a / 2, b / 2), c / 2)
    return prism(circle(a, around), b / 2)


def rectangle(x: float, y: float) -> FloatArray:
    """Corners (4, 2) of a rectangle of half sides x and y."""
    return np.array([[x, y], [-x, y], [-x, -y], [x, -y]])


def circle(radius: float, around: bool) -> FloatArray:
    """Corners (n, 2) on a circle, or of the regular polygon around it."""
    angles = 2 * np.pi * np.arange(_SIDES) / _SIDES
    far = radius / np.cos(np.pi / _SIDES) if around else radius
    return np.asarray(far * np.column_stack([np.cos(angles), np.sin(angles)]))


def prism(rim: FloatArray, half: float) -> FloatArray:
    """Triangles (n, 3, 3) of a prism over a rim (m, 2): two for each side, and its ends."""
    low, high = (np.column_stack([rim, np.full(len(rim), z)]) for z in (-half, half))
    after = np.roll(np.arange(len(rim)), -1)
    fan = np.array([[0, k, k + 1] for k in range(1, len(rim) - 1)])
    sides = np.stack([low, low[after], high[after]], axis=1)
    others = np.stack([low, high[after], high], axis=1)
    return np.concatenate([sides, others, low[fan[:, ::-1]], high[fan]])
