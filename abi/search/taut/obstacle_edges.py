"""Edges of obstacles at which a short path around them may bend.

A shortest path among polyhedra bends only at their edges (Sharir and Schorr, On Shortest Paths in
Polyhedral Spaces, SIAM J. Comput. 15, 1986), wherever the nodes of the mesh are.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import product

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.obstacles.pose import Vec3, rotation
from abi.obstacles.primitive_kernels import Core
from abi.obstacles.primitives import Primitive

_SIDES = 8  # of the prism around a round solid
_WIDER = 1e-6  # part of the margin that the edges keep beyond it
_APART = 1e-9  # and [unit]
_NONE = read_only(np.zeros(0))


def obstacle_edges(primitives: tuple[Primitive, ...], margin: float, ahead: Vec3) -> FloatArray:
    """Edges of the widened primitives; a round one is replaced by a prism of 8 sides.

    Args:
        primitives: convex solids.
        margin: distance to keep, [unit].
        ahead: vector from start to goal, [unit], world, the axis of the prism around a ball.

    Returns:
        For each edge both ends, [unit], and the unit normals of the two faces that meet there, one
        after the other, (12 n,), world.
    """
    wider = margin * (1 + _WIDER) + _APART
    edges = [_edges(one, wider, ahead if _is_ball(one.core()) else None) for one in primitives]
    return read_only(np.concatenate(edges)) if edges else _NONE


@lru_cache(maxsize=1024)
def _edges(solid: Primitive, margin: float, ahead: Vec3 | None) -> FloatArray:
    axes = rotation(solid.wxyz).T if ahead is None else _axes_along(np.array(ahead))
    core = solid.core()
    if core.is_cylinder == 0 and core.x + core.y > 0:
        ends, normals = _box_edges(core, margin), _CUBE_NORMALS
    else:
        ends = _prism_edges(core, margin)
        normals = _prism_normals(_is_ball(core), core.is_cylinder == 1)
    return read_only(np.concatenate([ends @ axes + solid.position, normals @ axes], axis=1).ravel())


def _is_ball(core: Core) -> bool:
    return max(core[:3]) == 0


def _axes_along(ahead: FloatArray) -> FloatArray:
    """Axes as rows (3, 3), the last of them along ``ahead``."""
    ahead = ahead / np.linalg.norm(ahead)
    side = np.cross(ahead, np.eye(3)[np.abs(ahead).argmin()])
    side /= np.linalg.norm(side)
    return np.stack([side, np.cross(ahead, side), ahead])


_SIGNS = (-1.0, 1.0)
_CUBE = read_only(
    np.array(
        [
            [np.roll((along, v, u), axis) for along in _SIGNS]
            for axis, u, v in product(range(3), _SIGNS, _SIGNS)
        ]
    )
)
"""Ends (12, 2, 3) of the edges of a cube of half size 1, those along z last."""
_ACROSS = read_only(_CUBE.mean(axis=1, keepdims=True))
"""Midpoints (12, 1, 3) of these edges."""
_CUBE_NORMALS = read_only(np.eye(3)[_ACROSS.nonzero()[2].reshape(12, 2)] * _ACROSS)
"""Normals (12, 2, 3) of the two faces at each of them."""


def _box_edges(core: Core, margin: float) -> FloatArray:
    """Ends (12, 2, 3) of the edges of a box, moved outwards along both their faces, body."""
    return np.asarray(_CUBE * np.array(core[:3]) + _ACROSS * (core.radius + margin))


def _prism_edges(core: Core, margin: float) -> FloatArray:
    """Ends (n, 2, 3) of the edges of a prism around a widened round solid, body."""
    radius, turn, half_height = core.x + core.radius + margin, math.pi / _SIDES, core.z
    angle = 2 * turn * np.arange(_SIDES)
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(_SIDES)], axis=1) / math.cos(turn)
    up = np.array([0.0, 0.0, 1.0])
    sides = np.stack([radius * ring - half_height * up, radius * ring + half_height * up], axis=1)
    if _is_ball(core):
        return sides
    # over an end: a cylinder's rim, or the second corner of an octagon around a cap
    if core.is_cylinder:
        rim, height = radius * ring, half_height + margin
    else:
        rim, height = radius * math.tan(turn) * ring, half_height + radius
    rims = np.stack([rim - height * up, rim + height * up])
    following = np.roll(rims, -1, axis=1)
    return np.concatenate([sides, np.stack([rims, following], axis=2).reshape(-1, 2, 3)])


@lru_cache(maxsize=3)
def _prism_normals(is_ball: bool, is_cylinder: bool) -> FloatArray:
    """Normals (n, 2, 3) of the faces at the edges of that prism, in the order of the edges."""
    turn = math.pi / _SIDES
    angle = 2 * turn * np.arange(_SIDES)
    before, after = (
        np.stack([np.cos(middle), np.sin(middle), np.zeros(_SIDES)], axis=1)
        for middle in (angle - turn, angle + turn)
    )
    sides = np.stack([before, after], axis=1)
    if is_ball:
        return read_only(sides)
    rims = []
    for side in (-1.0, 1.0):
        over = np.broadcast_to([0.0, 0.0, side], after.shape)
        # a capsule's rim lies between an end and the bevel around it
        beside = after if is_cylinder else (after + over) / math.sqrt(2)
        rims.append(np.stack([beside, over], axis=1))
    return read_only(np.concatenate([sides, np.stack(rims).reshape(-1, 2, 3)]))
