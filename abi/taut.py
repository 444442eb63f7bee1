"""Stage 3½: the path pulled taut, free of the mesh's directions.

A path along edges stays longer than it need be however fine the mesh, for an edge points only in a
few directions. Here a search for any angle finds which way round the obstacles is short, and what
it finds is tightened like a string.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.clearance import measure_polyline
from abi.graph import Graph
from abi.kernels import visibility as kernels
from abi.kernels.calling import call
from abi.mesh import COMPILE_FROM
from abi.search import SearchResult
from abi.shapes import Box, MeshShape, Obstacle, Obstacles, segments_blocked
from abi.shortest.tightening import tightened
from abi.shortest.waypoints import waypoints
from abi.solids import Solid, packed

_ROUNDING = 1e-9
"""Segments from start and goal may have less room: their own distance less this, [unit]."""

_PAD = 1e-13
"""Part of the largest coordinate that the kernels keep beyond the margin, for their rounding."""

_WORTH = 5e-6
"""Part of the length that a cut corner must win."""

_SLACK = 1.02
"""A path by the obstacles' edges may be this much longer before it is tightened."""

_SAMPLES = 3
"""Places on each edge of an obstacle."""


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


def taut(graph: Graph, obstacles: Obstacles, margin: float, path: SearchResult) -> TautPath:
    """Pull ``path`` taut, and two others beside it; the shortest is returned.

    The second is for any angle, found by Lazy Theta* (Nash, Koenig and Tovey, 2010) on the graph's
    nodes, the third by the obstacles' edges, :mod:`abi.shortest.waypoints`. Each is tightened:
    vertices that are not needed are dropped, the others moved towards the chord of their neighbours
    and along the surfaces that their legs touch, and corners are cut where that wins, until the
    length stops improving. The result is a local optimum. A triangle mesh is first taken for its
    bounding box; then ``path`` and the best found are tightened by the mesh's own distance,
    :mod:`abi.shortest.tightening`.

    Args:
        graph: the graph of the path.
        obstacles: those that the graph was built with.
        margin: distance that segments keep from them as the graph's edges do, [unit]. A segment
            from the start or to the goal keeps that point's own distance where it is less.
        path: a path of the graph from start to goal.

    Returns:
        The path, never longer than the one given. Each segment is an edge of it or keeps the margin
        by the exact test of ``abi.shapes``.
    """
    ends = path.points[[0, -1]]
    box = read_only(np.concatenate(graph.mesh.box))
    solids = tuple(_in_its_bounds(obstacle) for obstacle in obstacles)
    found = [path.points, *_pulled(graph, path, solids, _margins(solids, margin, ends), box)]
    limits = _margins(obstacles, margin, ends).min(axis=1, initial=margin)
    best = _shortest(found, obstacles, limits)
    if solids != obstacles:
        strings = [tightened(points, obstacles, limits) for points in (path.points, best)]
        best = _shortest([path.points, *strings], obstacles, limits)
    points = read_only(best)
    return TautPath(points, _length(points), measure_polyline(points, obstacles))


def _in_its_bounds(obstacle: Obstacle) -> Solid:
    """A triangle mesh's bounding box; a convex solid itself."""
    if not isinstance(obstacle, MeshShape):
        return obstacle
    low, high = obstacle.bounds()
    x, y, z = np.maximum(high - low, 1e-9).tolist()
    a, b, c = ((low + high) / 2).tolist()
    return Box(size=(x, y, z), position=(a, b, c))


def _margins(obstacles: Obstacles, margin: float, ends: FloatArray) -> FloatArray:
    """Distance to keep from each obstacle (4, k): in general, from start, to goal, from and to."""
    own = [np.minimum(solid.signed_distance(ends) - _ROUNDING, margin) for solid in obstacles]
    first, last = np.array(own).reshape(-1, 2).T
    return np.stack([np.full(len(obstacles), margin), first, last, np.minimum(first, last)])


def _pulled(
    graph: Graph,
    path: SearchResult,
    obstacles: tuple[Solid, ...],
    margins: FloatArray,
    box: FloatArray,
) -> list[FloatArray]:
    """The given path, the one for any angle and one by the obstacles' edges, all tightened."""
    if len(graph.excluded) > COMPILE_FROM and not kernels.ready.is_set():
        kernels.warm()
    rows = packed(obstacles)
    limits = read_only((margins + _PAD * float(np.abs(box).max())).ravel())
    ways = (graph.exits, graph.weights, graph.tails, graph.heads, graph.link_lengths)
    nodes = call(
        kernels.ready,
        kernels.any_angle,
        *(*graph.mesh.net, *ways, *_columns(graph.points), graph.start, graph.goal, rows, limits),
    )
    strings = [
        _tightened(points, rows, limits, box) for points in (path.points, graph.points[nodes])
    ]
    most = _SLACK * min(map(_length, strings))
    ends = path.points[[0, -1]]
    # A coarse mesh may have no node on the short side of an obstacle.
    edges = waypoints(obstacles, float(margins.max(initial=0)), ends, _SAMPLES)
    places = np.concatenate([ends, edges])
    by_ends = np.linalg.norm(places[:, None] - ends, axis=2).sum(axis=1)
    useful = (by_ends < most) & (places >= box[:3]).all(axis=1) & (places <= box[3:]).all(axis=1)
    useful[:2] = True
    places = places[useful]
    nodes = call(kernels.ready, kernels.through, *_columns(places), rows, limits, most)
    if len(nodes):
        strings.append(_tightened(places[nodes], rows, limits, box))
    return strings


def _tightened(
    points: FloatArray, rows: FloatArray, limits: FloatArray, box: FloatArray
) -> FloatArray:
    found = call(kernels.ready, kernels.tighten, *_columns(points), rows, limits, box, _WORTH)
    return np.stack(found, axis=1)


def _columns(points: FloatArray) -> tuple[FloatArray, ...]:
    """The coordinates of points (n, 3), each (n,), in the layout that kernels are compiled for."""
    x, y, z = (read_only(np.ascontiguousarray(column)) for column in points.T)
    return x, y, z


def _shortest(found: list[FloatArray], obstacles: Obstacles, limits: FloatArray) -> FloatArray:
    """The shortest that is clear; the first, a path of the graph, needs no test."""
    for points in sorted(found, key=_length):
        if points is found[0] or _clear(points, obstacles, limits):
            return points
    return found[0]


def _clear(points: FloatArray, obstacles: Obstacles, limits: FloatArray) -> bool:
    """Whether each segment of the path keeps its limit, of the four kinds."""
    kind = np.zeros(len(points) - 1, dtype=int)
    kind[0] += 1
    kind[-1] += 2
    return not segments_blocked(obstacles, points[:-1], points[1:], limits[kind]).any()


def _length(points: FloatArray) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
