"""Check of what an arm stands on: a plumb line through its base meets it, from outside.

In floating point, and by other formulas than planning: it decides only which obstacle links that
stand still may touch.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from abi.arrays import FloatArray
from abi.verify.exact.mesh import ExactMesh
from abi.verify.exact.solids import ExactSolid, in_body, vector

_ABOVE, _BELOW = 0.02, 0.2
"""Ends of the line: distances from the base's origin, along its z axis and against, [m]."""
_STEPS = 100
_NEAR = 1e-9
"""Distance up to which the line touches, [m]."""
_ALONG = 1e-12
"""Sine of the angle between a plane and a line that lies along it, at most."""


def is_beneath(
    obstacle: ExactSolid | ExactMesh, base: FloatArray, wxyz: Sequence[float], metre: float
) -> bool:
    """Check whether an arm stands on an obstacle.

    Args:
        obstacle: the obstacle.
        base: position of the arm's base (3,), [unit], world.
        wxyz: its orientation, as a quaternion.
        metre: one metre in [unit].
    """
    axes = np.array([in_body(axis, wxyz) for axis in _AXES], dtype=float)
    up = axes[:, 2] * metre
    ends = np.stack([base + _ABOVE * up, base - _BELOW * up])
    turn = np.array([in_body(axis, obstacle.wxyz) for axis in _AXES], dtype=float)
    body = (ends - np.array(obstacle.position, dtype=float)) @ turn
    if isinstance(obstacle, ExactMesh):
        outside = not obstacle.inside(vector(ends[0].tolist()))
        return outside and _crosses(obstacle, body / obstacle.factor)
    away = [_distance(obstacle, body[0] + share * (body[1] - body[0])) for share in (0.0, 1.0)]
    if away[0] <= 0:
        return False
    low, high = 0.0, 1.0
    for _ in range(_STEPS):  # the distance is convex along the line
        a, b = low + (high - low) / 3, high - (high - low) / 3
        near, far = (_distance(obstacle, body[0] + s * (body[1] - body[0])) for s in (a, b))
        low, high = (low, b) if near <= far else (a, high)
        away.append(min(near, far))
    return min(away) <= _NEAR * metre


_AXES = (vector((1.0, 0.0, 0.0)), vector((0.0, 1.0, 0.0)), vector((0.0, 0.0, 1.0)))


def _distance(solid: ExactSolid, point: FloatArray) -> float:
    """Distance of a point (3,) in the body's frame from a convex solid, 0 or less inside."""
    x, y, z = np.maximum(np.abs(point) - np.array(solid.half, dtype=float), 0.0).tolist()
    across = max(math.hypot(x, y) - float(solid.disc), 0.0)
    return math.hypot(across, z) - float(solid.ball)


def _crosses(mesh: ExactMesh, ends: FloatArray) -> bool:
    """Check whether a segment (2, 3) in the body's frame crosses a triangle.

    Signs of volumes: the ends are on both sides, and the edges wind around the line. A triangle in
    a plane along it is none that it crosses: where it enters a solid there, it meets others.
    """
    a, b, c = (mesh.vertices[mesh.faces[:, k]] - ends[0] for k in range(3))
    way = ends[1] - ends[0]
    normal = np.cross(b - a, c - a)
    first, last = (normal * a).sum(axis=1), (normal * (a - way)).sum(axis=1)
    edges = np.stack([np.cross(one, other) @ way for one, other in ((a, b), (b, c), (c, a))])
    around = (edges >= 0).all(axis=0) | (edges <= 0).all(axis=0)
    far = np.linalg.norm(normal, axis=1) * np.linalg.norm(way)
    return bool((around & (first * last <= 0) & (np.abs(first - last) > _ALONG * far)).any())
