"""The shortest length known in a scene of boxes: edge sequences of a dense visibility graph."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numba
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from abi.arrays import BoolArray, FloatArray, IntArray, read_only
from abi.obstacles import primitive_kernels as sight
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.packing import pack
from abi.obstacles.primitives import Box
from abi.obstacles.vector_kernels import vec3_at
from abi.scene.scene import Scene
from abi.taut.free_space_kernels import FreeSpace
from abi.taut.tighten_kernels import tighten

SAMPLES = 21  # places on each edge
SEQUENCES = 40  # that are refined
WORTH = 1e-8  # part of the length that a cut corner must win


def best_known(scene: Scene) -> float:
    """Length of the shortest clear path found with much effort, [unit]; no proof of optimality.

    Places along the edges of the widened boxes and the visibility between all of them give the
    shortest way by each place. The first distinct sequences of edges, in order of length, are
    tightened until the corners are round; the shortest that is clear by the exact test counts.

    Args:
        scene: its obstacles are axis-parallel boxes.
    """
    margin = scene.spline.clearance
    ends = np.array([scene.start, scene.goal])
    places, edge = _places(scene, margin)
    places, edge = np.concatenate([ends, places]), np.concatenate([[-2, -1], edge])
    boxes = tuple(solid for solid in scene.obstacles if isinstance(solid, Box))
    solids = pack(boxes)
    seen = _sight(places, solids, np.full(len(boxes), margin))
    i, j = np.nonzero(seen)
    lengths = np.linalg.norm(places[i] - places[j], axis=1)
    graph = csr_array((lengths, (i, j)), shape=(len(places), len(places)))
    cost, parent = dijkstra(graph, directed=False, indices=[0, 1], return_predecessors=True)
    margins = read_only(np.full(4 * len(boxes), margin * (1 + 1e-12)))
    space = FreeSpace(solids, margins, scene.workspace.min, scene.workspace.max)
    best = np.inf
    for way in itertools.islice(_sequences(cost, parent, edge), SEQUENCES):
        path = _tightened(places[way], space)
        length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
        clear = not ObstacleSet(scene.obstacles).blocked(path[:-1], path[1:], margin).any()
        best = min(best, length if clear else np.inf)
    return best


def _places(scene: Scene, margin: float) -> tuple[FloatArray, IntArray]:
    """Places that keep the margin on the edges of the widened boxes, and the edge's number."""
    places, edges = [], []
    shares = np.linspace(-1, 1, SAMPLES)
    for k, solid in enumerate(scene.obstacles):
        assert isinstance(solid, Box)
        half = np.array(solid.size) / 2
        for number, (axis, u, v) in enumerate(itertools.product(range(3), (-1, 1), (-1, 1))):
            corner = np.zeros(3)
            corner[[axis - 1, axis - 2]] = u, v
            along = shares[:, None] * np.eye(3)[axis] * half[axis]
            places.append(solid.position + corner * (half + margin * (1 + 1e-9)) + along)
            edges.append(np.full(SAMPLES, 12 * k + number))
    found = np.concatenate(places)
    low, high = scene.workspace.min, scene.workspace.max
    kept = (ObstacleSet(scene.obstacles).nearest(found)[0] >= margin) & (found >= low).all(axis=1)
    kept &= (found <= high).all(axis=1)
    return found[kept], np.concatenate(edges)[kept]


@numba.njit(cache=True)
def _tightened(points: FloatArray, space: FreeSpace) -> FloatArray:
    """The path (m, 3) with corners as round as can be, from points (n, 3), [unit], world."""
    path = [vec3_at(points[i], 0) for i in range(len(points))]
    return np.array(tighten(path, space, WORTH))


@numba.njit(cache=True)
def _sight(places: FloatArray, solids: FloatArray, margins: FloatArray) -> BoolArray:
    """Which places see each other (n, n), each pair once."""
    n = len(places)
    seen = np.zeros((n, n), np.bool_)
    for i in range(n):
        a = vec3_at(places[i], 0)
        for j in range(i + 1, n):
            seen[i, j] = not sight.blocked(solids, margins, 0, a, vec3_at(places[j], 0))
    return seen


def _sequences(cost: FloatArray, parent: IntArray, edge: IntArray) -> Iterator[list[int]]:
    """The shortest ways by each place, those over new sequences of edges only."""
    known = set()
    total = cost.sum(axis=0)
    for place in np.argsort(total, kind="stable")[: np.isfinite(total).sum()].tolist():
        before, after = _back(parent[0], place), _back(parent[1], place)
        way = before[::-1] + after[1:]
        sequence = tuple(label for label, _ in itertools.groupby(edge[way].tolist()))
        if sequence not in known:
            known.add(sequence)
            yield way


def _back(parent: IntArray, place: int) -> list[int]:
    way = [place]
    while parent[way[-1]] >= 0:
        way.append(int(parent[way[-1]]))
    return way
