from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.arrays import FloatArray
from abi.kernels import solids as sight
from abi.kernels import visibility
from abi.scene import Scene
from abi.shapes import MeshShape
from abi.shortest.waypoints import Solid
from abi.solids import packed
from tests.abi.test_scene import obstacles, points


def shapes(bodies: list[dict[str, Any]]) -> tuple[Solid, ...]:
    made = Scene.from_dict({"version": 1, "obstacles": bodies}).obstacles
    return tuple(solid for solid in made if not isinstance(solid, MeshShape))


def blocked(obstacles: tuple[Solid, ...], margin: float, p: FloatArray, q: FloatArray) -> bool:
    solids: Any = packed(obstacles).tolist()
    margins: Any = [margin] * len(obstacles)
    return bool(sight.blocked(solids, margins, 0, *p.tolist(), *q.tolist()))


@settings(max_examples=300, deadline=None)
@given(obstacles, points, points, st.floats(-0.3, 1))
def test_a_line_of_sight_is_what_the_exact_distance_says(
    body: dict[str, Any], start: list[float], goal: list[float], margin: float
) -> None:
    (solid,) = solids = shapes([body])
    p, q = np.array(start), np.array(goal)
    distance = float(solid.segment_distance(p[None], q[None])[0])

    # near the distance itself both answers are right; an inch to either side only one is
    for asked in (margin, distance - 1e-8, distance + 1e-8):
        if abs(asked - distance) > 1e-9:
            assert blocked(solids, asked, p, q) == (distance < asked)


@settings(max_examples=60, deadline=None)
@given(st.lists(obstacles, max_size=3), points, points)
def test_sight_goes_both_ways_and_needs_all_obstacles_clear(
    bodies: list[dict[str, Any]], start: list[float], goal: list[float]
) -> None:
    solids = shapes(bodies)
    p, q = np.array(start), np.array(goal)
    distance = min((float(s.segment_distance(p[None], q[None])[0]) for s in solids), default=9.0)
    if abs(distance - 0.1) > 1e-9:
        assert blocked(solids, 0.1, p, q) == blocked(solids, 0.1, q, p) == (distance < 0.1)


@settings(max_examples=40, deadline=None)
@given(st.lists(obstacles, min_size=1, max_size=2), st.integers(0, 2**31))
def test_a_way_through_places_is_the_shortest_there_is(
    bodies: list[dict[str, Any]], seed: int
) -> None:
    solids: Any = packed(shapes(bodies)).tolist()
    margins: Any = [0.05] * 4 * len(bodies)
    places = np.random.default_rng(seed).uniform(0, 6, (7, 3))
    columns: list[Any] = [column.tolist() for column in places.T]

    through: Any = visibility.through
    way = through.py_func(*columns, solids, margins, 1e9)

    # Floyd and Warshall on the whole visibility graph
    n = len(places)
    cost = np.full((n, n), np.inf)
    for i in range(n):
        for j in range(n):
            if not sight.blocked(solids, margins, 0, *places[i], *places[j]):
                cost[i, j] = np.linalg.norm(places[i] - places[j])
    for k in range(n):
        cost = np.minimum(cost, cost[:, k : k + 1] + cost[k])
    if not np.isfinite(cost[0, 1]):
        assert len(way) == 0
        return
    assert way[0] == 0
    assert way[-1] == 1
    length = np.linalg.norm(np.diff(places[way], axis=0), axis=1).sum()
    np.testing.assert_allclose(length, cost[0, 1], rtol=1e-12)
    # a path must be shorter than asked
    assert len(through.py_func(*columns, solids, margins, length * (1 - 1e-9))) == 0
