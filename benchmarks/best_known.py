"""Shortest length known in a scene of boxes: edge sequences of a dense visibility graph."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numba
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from abi.arrays import BoolArray, FloatArray, IntArray, read_only
from abi.compilation.helpers import declare_helpers
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.packing import pack
from abi.obstacles.primitive_tree_kernels import blocked
from abi.obstacles.primitives import Box
from abi.obstacles.vector_kernels import vec3_at
from abi.scene.scene import Scene
from abi.search.taut.tighten_kernels import FreeSpace, tighten

declare_helpers()

SAMPLES = 21  # points on each edge
SEQUENCES = 40  # that are refined
LEAST_GAIN = 1e-8  # part of the length that cutting a corner must save


def best_known(scene: Scene) -> float:
    """Length of the shortest clear path found with much effort, [unit]; no proof of optimality.

    Points along the edges of the widened boxes and the visibility between all of them give the
    shortest path by each point. The first distinct sequences of edges, in order of length, are
    tightened until the corners are round; the shortest that is clear by the exact test counts.

    Args:
        scene: its obstacles are axis-parallel boxes.
    """
    margin = scene.spline.clearance
    ends = np.array([scene.start, scene.goal])
    points, edge = _edge_points(scene, margin)
    points, edge = np.concatenate([ends, points]), np.concatenate([[-2, -1], edge])
    boxes = tuple(obstacle for obstacle in scene.obstacles if isinstance(obstacle, Box))
    primitives = pack(boxes)
    i, j = np.nonzero(_visibility(points, primitives, np.full(len(boxes), margin)))
    lengths = np.linalg.norm(points[i] - points[j], axis=1)
    graph = csr_array((lengths, (i, j)), shape=(len(points), len(points)))
    cost, parent = dijkstra(graph, directed=False, indices=[0, 1], return_predecessors=True)
    margins = read_only(np.full(4 * len(boxes), margin * (1 + 1e-12)))
    space = FreeSpace(primitives, margins, scene.workspace.min, scene.workspace.max)
    best = np.inf
    for route in itertools.islice(_sequences(cost, parent, edge), SEQUENCES):
        path = _tightened(points[route], space)
        length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
        clear = not ObstacleSet(scene.obstacles).blocked(path[:-1], path[1:], margin).any()
        best = min(best, length if clear else np.inf)
    return best


def _edge_points(scene: Scene, margin: float) -> tuple[FloatArray, IntArray]:
    """Points (n, 3) on the widened boxes' edges that keep the margin, and edge numbers (n,)."""
    points, edges = [], []
    shares = np.linspace(-1, 1, SAMPLES)
    for k, box in enumerate(scene.obstacles):
        assert isinstance(box, Box)
        half = np.array(box.size) / 2
        for number, (axis, u, v) in enumerate(itertools.product(range(3), (-1, 1), (-1, 1))):
            corner = np.zeros(3)
            corner[[axis - 1, axis - 2]] = u, v
            along = shares[:, None] * np.eye(3)[axis] * half[axis]
            points.append(box.position + corner * (half + margin * (1 + 1e-9)) + along)
            edges.append(np.full(SAMPLES, 12 * k + number))
    candidates = np.concatenate(points)
    low, high = scene.workspace.min, scene.workspace.max
    kept = (ObstacleSet(scene.obstacles).nearest(candidates)[0] >= margin) & (
        candidates >= low
    ).all(axis=1)
    kept &= (candidates <= high).all(axis=1)
    return candidates[kept], np.concatenate(edges)[kept]


@numba.njit(cache=True)
def _tightened(points: FloatArray, space: FreeSpace) -> FloatArray:
    """The path (m, 3) with corners as round as can be, from points (n, 3), [unit], world."""
    path = [vec3_at(points[i], 0) for i in range(len(points))]
    return np.array(tighten(path, space, LEAST_GAIN))


@numba.njit(cache=True)
def _visibility(points: FloatArray, primitives: FloatArray, margins: FloatArray) -> BoolArray:
    """Flags (n, n) of the points (n, 3) that see each other, each pair once."""
    n = len(points)
    visible = np.zeros((n, n), np.bool_)
    for i in range(n):
        a = vec3_at(points[i], 0)
        for j in range(i + 1, n):
            visible[i, j] = not blocked(primitives, margins, 0, a, vec3_at(points[j], 0))
    return visible


def _sequences(cost: FloatArray, parent: IntArray, edge: IntArray) -> Iterator[list[int]]:
    """Shortest paths by each point, as numbers of points; only those over new edge sequences."""
    known = set()
    total = cost.sum(axis=0)
    for point in np.argsort(total, kind="stable")[: np.isfinite(total).sum()].tolist():
        route = _ancestors(parent[0], point)[::-1] + _ancestors(parent[1], point)[1:]
        sequence = tuple(label for label, _ in itertools.groupby(edge[route].tolist()))
        if sequence not in known:
            known.add(sequence)
            yield route


def _ancestors(parent: IntArray, point: int) -> list[int]:
    """The point and those before it, back to the root."""
    route = [point]
    while parent[route[-1]] >= 0:
        route.append(int(parent[route[-1]]))
    return route
