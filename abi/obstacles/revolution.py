"""Surfaces of revolution around z, as triangles."""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray, IntArray


def revolved(profile: FloatArray, sides: int) -> tuple[FloatArray, IntArray]:
    """Turn a profile around z.

    Args:
        profile: points (radius, z), shape (k, 2), from a lower end on the axis to an upper one; the
            others are off the axis.
        sides: of the polygon that stands for a circle.

    Returns:
        Vertices (v, 3) and triangles (m, 3), anticlockwise seen from outside.
    """
    angle = 2 * np.pi / sides * np.arange(sides)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rings, heights = profile[1:-1, :1, None] * circle, profile[1:-1, 1]
    heights = np.broadcast_to(heights[:, None, None], (len(heights), sides, 1))
    around = np.concatenate([rings, heights], axis=2).reshape(-1, 3)
    ends = np.array([(0.0, 0.0, profile[0, 1]), (0.0, 0.0, profile[-1, 1])])
    vertices = np.concatenate([ends, around])
    a = 2 + np.arange(sides)
    b = np.roll(a, -1)
    low, high = np.zeros_like(a), np.ones_like(a)
    last = (len(profile) - 3) * sides
    first_ring = [np.stack([low, b, a], axis=1), np.stack([high, a + last, b + last], axis=1)]
    bands = [
        np.stack(corners, axis=1) + k * sides
        for k in range(len(profile) - 3)
        for corners in ((a, b, b + sides), (a, b + sides, a + sides))
    ]
    return vertices, np.concatenate([*first_ring, *bands])


def quarter_circles(radius: float, height: float, sides: int) -> FloatArray:
    """Profile of a ball cut in two, its halves' centres at z = ``height`` and its negative.

    Both ends are on the axis, and each quarter has a quarter of ``sides``.
    """
    steps = max(sides // 4, 1)
    angle = np.pi / 2 / steps * np.arange(steps + 1)
    upper = np.stack([radius * np.cos(angle), height + radius * np.sin(angle)], axis=1)
    upper[-1, 0] = 0.0
    lower = upper[::-1] * (1, -1)
    return np.concatenate([lower, upper[1:] if height == 0 else upper])
