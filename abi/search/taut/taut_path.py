"""Stage 3½: the path pulled taut, free of the mesh's directions.

A path along edges stays too long however fine the mesh, because its edges have only a few
directions. So it is tightened together with an any-angle path and with short paths along the
obstacles' edges, and the shortest result counts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, ShortRepr, flat, read_only
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.obstacle_set_kernels import near_polyline
from abi.obstacles.primitives import Primitive
from abi.search.build_graph import REACH
from abi.search.graph import Graph
from abi.search.search import SearchResult
from abi.search.taut.obstacle_edges import obstacle_edges
from abi.search.taut.taut_kernels import taut_paths
from abi.search.taut.theta_star_kernels import any_angle
from abi.search.taut.tighten_kernels import FreeSpace
from abi.search.taut.tighten_near_meshes import tighten_near_meshes

_ROUNDING = 1e-9
"""Distance by which segments from start and goal may keep less, [unit]: their own distance less
this."""

_PAD = 1e-13
"""Relative distance, over the largest coordinate, that the kernels keep in addition, for their
rounding."""

_FEW = 32
"""Number of convex obstacles above which work is bounded instead of the path's excess.

In 60 crowds of 50 to 400 that fill up to half of the workspace, paths were longer by 0.1 % in the
mean than without these bounds, and by 1.7 % in one.
"""

_MOST_NEAR = 64
"""Most convex obstacles of a crowd around whose edges paths may bend: those nearest to the path."""

_FIRST_REACH = 1 / 64
"""Distance from the path, over its length, within which these are first looked for."""

_SEARCHED_NODES = 4_000
"""Approximate number of lattice nodes that the any-angle search uses."""

_MOST_NODES = 30_000
"""Number of nodes of an irregular mesh above which there is no any-angle search.

None of these can be passed over, and uncompiled, in a first plan, so many take a tenth of a second.
"""


@dataclass(frozen=True, eq=False, repr=False)
class TautPath(ShortRepr):
    """A short polyline from start to goal, whose inner vertices need not be nodes.

    Attributes:
        points: (k, 3), k >= 2, [unit], world.
        length: [unit].
        clearance: least distance to the obstacles, exact up to rounding, [unit]; inf without.
    """

    points: FloatArray
    length: float
    clearance: float


def taut(graph: Graph, obstacles: ObstacleSet, margin: float, path: SearchResult) -> TautPath:
    """Pull ``path`` and other paths taut, and return the shortest.

    ``path`` may go round an obstacle on its longer side. One of the others is an any-angle path,
    by Lazy Theta* (Nash, Koenig and Tovey, 2010) over the nodes of the mesh: every few of them in a
    fine lattice, and none in a fine mesh of another kind. The rest are short paths in a visibility
    graph of points on the obstacles' edges, no two along the same edges
    (:mod:`abi.search.taut.obstacle_edges`); in a crowd, only of the obstacles nearest to the path.

    Each is tightened: vertices that are not needed are dropped, the others moved towards the chord
    of their neighbours and along the surfaces that their legs touch, until the length stops
    improving. The corners of the shortest, and of one nearly as short, are also cut if that
    shortens it. The result is a local optimum. A triangle mesh is first replaced by its bounding
    box; then ``path`` and the best path so far are tightened by the mesh's own distance
    (:mod:`abi.search.taut.tighten_near_meshes`).

    Args:
        graph: the graph of the path.
        obstacles: those that the graph was built with.
        margin: distance that segments keep from them, like the graph's edges, [unit]. A segment
            from the start or to the goal keeps that point's own distance if it is less.
        path: a path of the graph from start to goal.

    Returns:
        The path, never longer than the one given. Each segment is an edge of it or keeps the margin
        by the exact distance, ``ObstacleSet.segment_clearances``.
    """
    margin = arguments.number("margin", margin)
    ends = path.points[[0, -1]]
    boxed = obstacles.boxed
    margins = _margins(boxed.distances_up_to(margin, ends), margin)
    candidates = _past_primitives(graph, path, boxed, margins)
    limits = margins.min(axis=1, initial=margin)
    if boxed is not obstacles:
        margins = _margins(obstacles.distances_up_to(margin, ends), margin)
        limits = margins.min(axis=1, initial=margin)
        best, _ = _shortest_clear(path.points, candidates, obstacles, limits)
        candidates = [
            tighten_near_meshes(points, obstacles, limits) for points in (path.points, best)
        ]
        candidates.sort(key=polyline_length)
    points, clearance = _shortest_clear(path.points, candidates, obstacles, limits)
    return TautPath(read_only(points), polyline_length(points), clearance)


def _margins(ends: FloatArray, margin: float) -> FloatArray:
    """Margins of segments from each obstacle (4, k): in general, from start, to goal, from and to.

    Args:
        ends: (2, k) signed distances of start and goal, [unit]; larger ones than the margin may be
            any.
        margin: the general one, [unit].
    """
    first, last = np.minimum(ends - _ROUNDING, margin)
    return np.stack([np.full(len(first), margin), first, last, np.minimum(first, last)])


def _past_primitives(
    graph: Graph, path: SearchResult, obstacles: ObstacleSet, margins: FloatArray
) -> list[FloatArray]:
    """All paths (m, 3) past convex obstacles, tightened, the shortest first."""
    low, high = graph.mesh.box
    pad = _PAD * max(float(np.abs(low).max()), float(np.abs(high).max()))
    packed_margins = read_only((margins + pad).ravel())
    given = [path.points, _any_angle_path(graph, path, obstacles.packed, packed_margins)]
    begins = np.cumsum([0, *(len(points) for points in given if len(points))], dtype=np.int32)

    x, y, z = (path.points[-1] - path.points[0]).tolist()
    crowd = len(obstacles) > _FEW
    near = obstacles.primitives
    if crowd:
        near = _nearest(
            obstacles, min((points for points in given if len(points)), key=polyline_length)
        )
    edges = obstacle_edges(near, float(margins[0].max(initial=0)), (x, y, z))
    corners = tuple(low.tolist()), tuple(high.tolist())
    space = FreeSpace(obstacles.packed, packed_margins, *corners)
    samples, paths, weight, sights = (3, 3, 1.02, 5_000) if crowd else (5, 6, 1.0, 100_000)
    points, ends, lengths = taut_paths(
        *(flat(np.concatenate(given)), read_only(begins), edges, space),
        *(samples, paths, weight, sights),
    )
    return [points[ends[k] : ends[k + 1]] for k in np.argsort(lengths)]


def _nearest(obstacles: ObstacleSet, path: FloatArray) -> tuple[Primitive, ...]:
    """The convex obstacles that are nearest to a path, at most ``_MOST_NEAR``."""
    primitives = obstacles.primitives
    reach = _FIRST_REACH * polyline_length(path)
    found, most = 0, min(_MOST_NEAR, len(primitives))
    while found < most:
        distances = near_polyline(flat(path), obstacles.packed, reach)
        found = int(np.isfinite(distances).sum())
        reach *= 2
    return tuple(primitives[k] for k in distances.argsort(kind="stable")[:most].tolist())


def _any_angle_path(
    graph: Graph, path: SearchResult, packed: FloatArray, margins: FloatArray
) -> FloatArray:
    """Any-angle path (m, 3), [unit], world, shorter than the given one; m = 0 if there is none.

    None, too, where the nodes are no lattice and too many.

    Args:
        graph: the graph.
        path: a path of it.
        packed: the convex obstacles.
        margins: (4k,) see :class:`abi.search.taut.tighten_kernels.FreeSpace`.
    """
    mesh = graph.mesh
    nodes = len(mesh.points)
    if mesh.stencil is None and nodes > _MOST_NODES:
        return np.empty((0, 3))
    stride = 1 if mesh.stencil is None else max(1, round((nodes / _SEARCHED_NODES) ** (1 / 3)))
    (a, b, c), (x, y, z) = path.points[[0, -1]].tolist()
    points = any_angle(
        *(mesh.adjacency, graph.excluded, stride, stride * REACH * mesh.longest_edge),
        *(((a, b, c), (x, y, z)), (packed, margins), path.length),
    )
    return np.asarray(points).reshape(-1, 3)


def _shortest_clear(
    path: FloatArray, candidates: list[FloatArray], obstacles: ObstacleSet, limits: FloatArray
) -> tuple[FloatArray, float]:
    """The first candidate that is clear, or the path, which needs no test; and its clearance.

    Args:
        path: (k, 3) a path of the graph, [unit], world.
        candidates: (m, 3) each, between the same ends, the shortest first.
        obstacles: the solids.
        limits: (4,) distance that a segment keeps, [unit]: in general, from the first point, to the
            last, from the first to the last.
    """
    most = polyline_length(path)
    for points in candidates:
        if polyline_length(points) > most:
            break
        distance = obstacles.segment_clearances(points, float(limits.max()))
        kind = np.zeros(len(distance), dtype=int)
        kind[0] += 1
        kind[-1] += 2
        if (distance >= limits[kind]).all():
            return points, float(distance.min())
    return path, obstacles.polyline_clearance(path)


def polyline_length(points: FloatArray) -> float:
    """Length of the line through points (n, 3)."""
    # as a path of the graph is measured: to the last bit the same for the same points
    points = arguments.points("points", points)
    legs = points[1:] - points[:-1]
    return float(np.sqrt((legs * legs).sum(axis=1)).sum())
