from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.arrays import FloatArray
from abi.obstacles import primitive_tree_kernels as sight
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.packing import pack
from abi.obstacles.primitives import Primitive
from abi.scene.scene import Scene
from abi.search.taut import taut_kernels as visibility
from abi.search.taut.tighten_kernels import FreeSpace
from tests.abi.scene.test_scene import obstacles, points
from tests.abi.shape_distances import segment_distance
from tests.thorough import examples


def shapes(bodies: list[dict[str, Any]]) -> tuple[Primitive, ...]:
    made = Scene.from_dict({"version": 1, "obstacles": bodies}).obstacles
    return tuple(solid for solid in made if not isinstance(solid, MeshShape))


def blocked(obstacles: tuple[Primitive, ...], margin: float, p: FloatArray, q: FloatArray) -> bool:
    solids: Any = pack(obstacles).tolist()
    margins: Any = [margin] * len(obstacles)
    return bool(sight.blocked(solids, margins, 0, tuple(p.tolist()), tuple(q.tolist())))


@pytest.mark.slow
@settings(max_examples=examples(40))
@given(obstacles, points, points, st.floats(-0.3, 1))
def test_a_line_of_sight_is_what_the_exact_distance_says(
    body: dict[str, Any], start: list[float], goal: list[float], margin: float
) -> None:
    (solid,) = solids = shapes([body])
    p, q = np.array(start), np.array(goal)
    distance = float(segment_distance(solid, p[None], q[None])[0])

    # near the distance itself both answers are right; an inch to either side only one is
    for asked in (margin, distance - 1e-8, distance + 1e-8):
        if abs(asked - distance) > 1e-9:
            assert blocked(solids, asked, p, q) == (distance < asked)


@settings(max_examples=examples(20))
@given(st.lists(obstacles, max_size=3), points, points)
def test_sight_goes_both_ways_and_needs_all_obstacles_clear(
    bodies: list[dict[str, Any]], start: list[float], goal: list[float]
) -> None:
    solids = shapes(bodies)
    p, q = np.array(start), np.array(goal)
    distance = min((float(segment_distance(s, p[None], q[None])[0]) for s in solids), default=9.0)
    if abs(distance - 0.1) > 1e-9:
        assert blocked(solids, 0.1, p, q) == blocked(solids, 0.1, q, p) == (distance < 0.1)


@settings(max_examples=40)
@given(st.lists(obstacles, min_size=1, max_size=2), st.integers(0, 2**31))
def test_paths_by_waypoints_are_the_shortest(bodies: list[dict[str, Any]], seed: int) -> None:
    solids: Any = pack(shapes(bodies)).tolist()
    margins: Any = [0.05] * 4 * len(bodies)
    random = np.random.default_rng(seed)
    vertices = random.uniform(0, 6, (9, 3))
    labels = [-1, -1, *random.integers(0, 4, 7).tolist()]
    space = FreeSpace(solids, margins, (0.0, 0.0, 0.0), (6.0, 6.0, 6.0))
    waypoints: Any = list(map(tuple, vertices.tolist()))

    edges: Any = [0.0] * 48  # without normals, so that every line counts
    effort = 5, 1.0, 10**9
    nodes = visibility.short_paths(waypoints, labels, edges, space, 1e9, *effort)

    # Floyd and Warshall on the whole visibility graph
    n = len(vertices)
    away = np.full((n, n), np.inf)
    for i in range(n):
        for j in range(n):
            if not sight.blocked(solids, margins, 0, tuple(vertices[i]), tuple(vertices[j])):
                away[i, j] = np.linalg.norm(vertices[i] - vertices[j])
    cost = away.copy()
    for k in [0, *range(2, n)]:  # by way of any but the second, which ends all paths
        cost = np.minimum(cost, cost[:, k : k + 1] + cost[k])
    if not np.isfinite(cost[0, 1]):
        assert len(nodes) == 0
        return
    ways = [way.tolist() for way in np.split(nodes, np.flatnonzero(np.array(nodes) == 0)[1:])]
    lengths = [sum(away[i, j] for i, j in itertools.pairwise(way)) for way in ways]
    assert all(way[0] == 0 and way[-1] == 1 for way in ways)
    np.testing.assert_allclose(lengths[0], cost[0, 1], rtol=1e-12)
    assert np.isfinite(lengths).all()
    assert (np.diff(lengths) >= -1e-12).all()
    # each is the shortest to the place before its last, and no two go by the same labels
    for way, length in zip(ways, lengths, strict=True):
        to_last = cost[0, way[-2]] if way[-2] else 0.0
        np.testing.assert_allclose(length, to_last + away[way[-2], 1], rtol=1e-12)
    sequences = [
        tuple(label for label, _ in itertools.groupby(labels[i] for i in way[1:-1])) for way in ways
    ]
    assert len(set(sequences)) == len(sequences)
    # a path must be shorter than asked
    shorter = lengths[0] * (1 - 1e-9)
    assert len(visibility.short_paths(waypoints, labels, edges, space, shorter, *effort)) == 0


@pytest.mark.slow
@settings(max_examples=40)
@given(st.lists(obstacles, max_size=4), st.lists(points, min_size=2, max_size=5))
def test_segments_are_as_near_as_the_exact_distance_says(
    bodies: list[dict[str, Any]], vertices: list[list[float]]
) -> None:
    solids = shapes(bodies)
    path = np.array(vertices)

    found = ObstacleSet(solids).segment_clearances(path)

    exact = np.full(len(path) - 1, np.inf)
    for solid in solids:
        exact = np.minimum(exact, segment_distance(solid, path[:-1], path[1:]))
    np.testing.assert_allclose(found, exact, atol=1e-12)
