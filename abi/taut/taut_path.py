"""Stage 3½: the path pulled taut, free of the mesh's directions.

A path along edges stays longer than it need be however fine the mesh, for an edge points only in a
few directions. Here a path for any angle and short ways by the obstacles' edges stand beside it,
and all are tightened like a string.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abi.arrays import FloatArray, flat, read_only
from abi.obstacles.obstacle_set import ObstacleSet
from abi.search.graph import REACH, Graph
from abi.search.search import SearchResult
from abi.taut import taut_kernels as kernels
from abi.taut import theta_star_kernels as any_angles
from abi.taut.free_space_kernels import FreeSpace
from abi.taut.obstacle_edges import edges
from abi.taut.tighten_near_meshes import tightened

_ROUNDING = 1e-9
"""Segments from start and goal may have less room: their own distance less this, [unit]."""

_PAD = 1e-13
"""Part of the largest coordinate that the kernels keep beyond the margin, for their rounding."""

_EFFORT = kernels.Effort(samples=5, slack=1.015, ways=6, worth=5e-6)
"""How much is tried by the obstacles' edges, and at corners."""

_NODES = 4_000
"""Of a lattice about so many nodes are searched for any angle."""

_MOST_NODES = 30_000
"""More nodes that are no lattice are not searched for any angle.

Of these none can be passed over, and uncompiled, in a first plan, so many take a tenth of a second.
"""


@dataclass(frozen=True, eq=False)
class TautPath:
    """A short polyline from start to goal, whose inner vertices need not be nodes.

    Attributes:
        points: (k, 3), k >= 2, [unit], world.
        length: [unit].
        clearance: exact least distance to the obstacles, [unit]; inf without obstacles.
    """

    points: FloatArray
    length: float
    clearance: float


def taut(graph: Graph, obstacles: ObstacleSet, margin: float, path: SearchResult) -> TautPath:
    """Pull ``path`` taut, and others beside it; the shortest is returned.

    ``path`` may go round an obstacle on its longer side. One of the others is found for any angle,
    by Lazy Theta* (Nash, Koenig and Tovey, 2010) over the nodes of the mesh: every few of them
    where it is a fine lattice, and none where it is a fine mesh of another kind. The rest are short
    ways in a visibility graph of places on the obstacles' edges, no two by the same edges
    (:mod:`abi.taut.obstacle_edges`).

    Each is tightened: vertices that are not needed are dropped, the others moved towards the chord
    of their neighbours and along the surfaces that their legs touch, until the length stops
    improving. Of the shortest, and of one nearly as short, the corners are cut, too, where that
    wins. The result is a local optimum. A triangle mesh is first taken for its bounding box; then
    ``path`` and the best found are tightened by the mesh's own distance,
    :mod:`abi.taut.tighten_near_meshes`.

    Args:
        graph: the graph of the path.
        obstacles: those that the graph was built with.
        margin: distance that segments keep from them as the graph's edges do, [unit]. A segment
            from the start or to the goal keeps that point's own distance where it is less.
        path: a path of the graph from start to goal.

    Returns:
        The path, never longer than the one given. Each segment is an edge of it or keeps the margin
        by the exact distance, ``abi.clearance.curve_clearance``.
    """
    ends = path.points[[0, -1]]
    boxed = obstacles.boxed
    margins = _margins(boxed.signed_distances(ends), margin)
    strings = _pulled(graph, path, boxed, margins)
    limits = margins.min(axis=1, initial=margin)
    if boxed is not obstacles:
        margins = _margins(obstacles.signed_distances(ends), margin)
        limits = margins.min(axis=1, initial=margin)
        best, _ = _shortest_clear(path.points, strings, obstacles, limits)
        strings = [tightened(points, obstacles, limits) for points in (path.points, best)]
        strings.sort(key=_length)
    points, clearance = _shortest_clear(path.points, strings, obstacles, limits)
    return TautPath(read_only(points), _length(points), clearance)


def _margins(own: FloatArray, margin: float) -> FloatArray:
    """Distance to keep from each obstacle (4, k): in general, from start, to goal, from and to.

    Args:
        own: (2, k) distances of start and goal, [unit].
        margin: the general one, [unit].
    """
    first, last = np.minimum(own - _ROUNDING, margin)
    return np.stack([np.full(len(first), margin), first, last, np.minimum(first, last)])


def _pulled(
    graph: Graph, path: SearchResult, boxed: ObstacleSet, margins: FloatArray
) -> list[FloatArray]:
    """All the paths past convex obstacles, tightened; first the best."""
    low, high = graph.mesh.box
    pad = _PAD * max(float(np.abs(low).max()), float(np.abs(high).max()))
    limits = read_only((margins + pad).ravel())
    found = [path.points, _any_angle(graph, path, boxed.packed, limits)]
    begins = np.cumsum([0, *(len(points) for points in found if len(points))], dtype=np.int32)

    x, y, z = (path.points[-1] - path.points[0]).tolist()
    by = edges(boxed.primitives, float(margins[0].max(initial=0)), (x, y, z))
    space = FreeSpace(boxed.packed, limits, tuple(low.tolist()), tuple(high.tolist()))
    points, ends, lengths = kernels.pull(
        flat(np.concatenate(found)), read_only(begins), by, space, _EFFORT
    )
    return [points[ends[k] : ends[k + 1]] for k in np.argsort(lengths)]


def _any_angle(
    graph: Graph, path: SearchResult, packed: FloatArray, limits: FloatArray
) -> FloatArray:
    """A path for any angle (m, 3), [unit], world, shorter than the one given; or none, m = 0.

    None, too, where the nodes are no lattice and too many.

    Args:
        graph, path: as above.
        packed: the convex obstacles.
        limits: distances from them that a segment keeps, see ``abi.taut.theta_star_kernels``.
    """
    whole = graph.mesh
    nodes = len(whole.points)
    if whole.stencil is None and nodes > _MOST_NODES:
        return np.empty((0, 3))
    stride = 1 if whole.stencil is None else max(1, round((nodes / _NODES) ** (1 / 3)))
    shape, _, steps, places, indptr, indices = whole.net
    start, goal = path.points[[0, -1]].tolist()
    found = any_angles.any_angle(
        *(shape, steps, places, indptr, indices, graph.excluded),
        *(stride, stride * REACH * whole.longest_edge, tuple(start), tuple(goal)),
        *(packed, limits, path.length),
    )
    return np.asarray(found).reshape(-1, 3)


def _shortest_clear(
    path: FloatArray, strings: list[FloatArray], obstacles: ObstacleSet, limits: FloatArray
) -> tuple[FloatArray, float]:
    """The first string that is clear, or the path, which needs no test; and its distance.

    Args:
        path: (k, 3) a path of the graph, [unit], world.
        strings: (m, 3) each, between the same ends, the shortest first.
        obstacles: the solids.
        limits: (4,) distance that a segment keeps, [unit]: in general, from the first point, to the
            last, from the first to the last.
    """
    most = _length(path)
    for points in strings:
        if _length(points) > most:
            break
        room = obstacles.segment_clearances(points)
        kind = np.zeros(len(room), dtype=int)
        kind[0] += 1
        kind[-1] += 2
        if (room >= limits[kind]).all():
            return points, float(room.min())
    return path, obstacles.polyline_clearance(path)


def _length(points: FloatArray) -> float:
    # as a path of the graph is measured: to the last bit the same for the same points
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
