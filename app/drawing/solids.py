"""Surfaces of simple solids as triangles for drawing."""

from __future__ import annotations

import numpy as np

from abi.arrays import FloatArray, IntArray

_SECTIONS = 32
"""Number of sides that approximate a circle."""

Triangles = tuple[FloatArray, IntArray]
"""Vertices (n, 3) and faces (m, 3), which are counterclockwise seen from outside."""


def box() -> Triangles:
    """Cube with edges of 1 around the origin."""
    vertices = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    squares = np.array(
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]],
        np.int32,
    )
    return vertices, _halved(squares)


def cylinder() -> Triangles:
    """Cylinder about the z axis, of radius 1 and height 1, around the origin."""
    return _revolved(np.array([[1.0, -0.5], [1.0, 0.5]]), (-0.5, 0.5))


def sphere() -> Triangles:
    """Sphere of radius 1 around the origin, with vertices on it."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, _SECTIONS // 2 + 1)[1:-1]
    return _revolved(np.column_stack((np.cos(angles), np.sin(angles))), (-1.0, 1.0))


def _revolved(profile: FloatArray, poles: tuple[float, float]) -> Triangles:
    """Surface of revolution about the z axis.

    Args:
        profile: radius and z of its points from below, (k, 2); not those on the axis.
        poles: z of its first and of its last point, which are on the axis.
    """
    rings, count = len(profile), _SECTIONS
    angles = np.arange(count) * (2 * np.pi / count)
    circle = np.column_stack((np.cos(angles), np.sin(angles)))
    places = profile[:, None, :1] * circle
    heights = np.broadcast_to(profile[:, None, 1:], (rings, count, 1))
    around = np.concatenate((places, heights), axis=2).reshape(-1, 3)
    vertices = np.concatenate((around, [[0.0, 0.0, z] for z in poles]))
    ids = np.arange(rings * count, dtype=np.int32).reshape(rings, count)
    after = np.roll(ids, -1, axis=1)
    squares = np.stack((ids[:-1], after[:-1], after[1:], ids[1:]), axis=2).reshape(-1, 4)
    low, high = (np.full(count, rings * count + k) for k in range(2))
    below = np.column_stack((low, after[0], ids[0]))
    above = np.column_stack((high, ids[-1], after[-1]))
    return vertices, np.concatenate((below, _halved(squares), above)).astype(np.int32)


def _halved(squares: IntArray) -> IntArray:
    """Split quadrilaterals (m, 4) into triangles (2 m, 3)."""
    return squares[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
