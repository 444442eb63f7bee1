"""Contacts of solids as they are given, with edges and corners, where convex pieces may be larger.

Two solids with edges meet where an edge of one enters the other, or where one is inside the other;
so the edges of both are tested against the surface of the other. Where none enters, a corner of
each part tells whether it is inside. A ball, or the axis of a capsule, is such an edge with a
radius. A shape that is found to touch touches indeed; contacts of a cylinder's rim shallower than
that of 48 corners are not found.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from abi.arrays import FloatArray
from abi.obstacles import obstacle_set_kernels
from abi.obstacles.triangle_mesh import surface_kernels
from abi.robot.bodies.link_solids import LinkSolids

_ALONG = np.linspace(0, 1, 9)
"""Places along an edge that enters a solid at which its depth is measured, as shares of it."""
_KERNELS = (
    obstacle_set_kernels.near_boxes,
    obstacle_set_kernels.blocked_segments,
    obstacle_set_kernels.nearest,
    surface_kernels.measure,
)


_Edges = tuple[FloatArray, FloatArray, FloatArray]
"""First ends (k, 3) and last ends (k, 3) of edges, and their radii (k,)."""


def _sides(
    first: LinkSolids,
    second: LinkSolids,
    turn: FloatArray,
    origin: FloatArray,
    within: float = 0.0,
) -> Iterator[tuple[LinkSolids, _Edges]]:
    """Each of two bodies, and the edges of the other near to it, wider by ``within``, in its frame.

    The first comes first.
    """
    back = -turn.T @ origin
    pairs = (second, first, turn, origin), (first, second, turn.T, back)
    for body, other, turn, origin in pairs:
        a, b, radii = body.edges
        radii = radii + within
        a, b = a @ turn.T + origin, b @ turn.T + origin
        low, high = other.bounds
        reach = radii[:, None]
        beside = (np.minimum(a, b) - reach > high) | (np.maximum(a, b) + reach < low)
        near = ~beside.any(axis=1)
        yield other, (a[near], b[near], radii[near])


def distance(first: LinkSolids, second: LinkSolids, turn: FloatArray, origin: FloatArray) -> float:
    """Distance from the corners of each of two bodies to the other: at least their distance.

    Arguments are those of :func:`touch`.
    """
    there = first.whole.signed_distance(second.corners @ turn.T + origin)
    back = second.whole.signed_distance((first.corners - origin) @ turn)
    return float(min(there.min(initial=np.inf), back.min(initial=np.inf)))


def touch(
    first: LinkSolids,
    second: LinkSolids,
    turn: FloatArray,
    origin: FloatArray,
    within: float = 0.0,
) -> bool:
    """Decide whether two bodies touch, or come nearer than a distance.

    The surfaces of bodies that do not touch come nearest at an edge of one of them.

    Args:
        first: a body.
        second: another.
        turn: rotation (3, 3) of the second in the frame of the first.
        origin: of the second in that frame, (3,), [unit].
        within: the distance, [unit].
    """
    for other, edges in _sides(first, second, turn, origin, within):
        if len(edges[0]) and other.whole.blocked(*edges).any():
            return True
    there = first.whole.signed_distance(second.anchors @ turn.T + origin)
    back = second.whole.signed_distance((first.anchors - origin) @ turn)
    return bool((there < 0).any() or (back < 0).any())


def may_touch(first: LinkSolids, second: LinkSolids, turn: FloatArray, origin: FloatArray) -> bool:
    """Decide whether two bodies touch, or come as near as cylinders' edges are inexact.

    Arguments are those of :func:`touch`.
    """
    return touch(first, second, turn, origin, first.bulge + second.bulge)


def depth(first: LinkSolids, second: LinkSolids, turn: FloatArray, origin: FloatArray) -> float:
    """How far a corner or an edge of one of two bodies is inside the other, at least, [unit].

    It is 0 where they do not touch; arguments are those of :func:`touch`.
    """
    deepest = 0.0
    back = -turn.T @ origin
    own, others = (np.concatenate([one.corners, one.anchors]) for one in (first, second))
    placed = others @ turn.T + origin, own @ turn + back
    sides = _sides(first, second, turn, origin)
    for corners, (other, (a, b, radii)) in zip(placed, sides, strict=True):
        low, high = other.bounds
        corners = corners[((corners >= low) & (corners <= high)).all(axis=1)]
        entering = np.flatnonzero(other.whole.blocked(a, b, radii))
        along = a[entering] + _ALONG[:, None, None] * (b[entering] - a[entering])
        points = np.concatenate([corners, along.reshape(-1, 3)])
        if len(points):
            deep = -other.whole.signed_distance(points)
            deep[len(corners) :] += np.tile(radii[entering], len(_ALONG))
            deepest = max(deepest, float(deep.max()))
    return deepest


def compile_kernels() -> None:
    """Wait for what contacts are decided with: meshes of links have thousands of triangles."""
    for kernel in _KERNELS:
        kernel.compile()
