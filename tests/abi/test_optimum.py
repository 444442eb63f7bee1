from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st

from abi.arrays import FloatArray, columns, read_only
from abi.clearance import segment_clearances
from abi.kernels import around, pull
from abi.scene import Scene, Workspace
from abi.shapes import MeshShape
from abi.shortest.optimum import lower_bound
from abi.shortest.waypoints import edges
from abi.solids import Solid, packed
from tests.abi.test_scene import obstacles, points

CLEARANCE = 0.1


def scene_of(bodies: list[dict[str, Any]], start: list[float], goal: list[float]) -> Scene:
    return Scene.from_dict({"version": 1, "obstacles": bodies, "start": start, "goal": goal})


def _tightened(path: FloatArray, solids: tuple[Solid, ...]) -> float:
    """Length of the path and the ways by the obstacles' edges, tightened again and again."""
    x, y, z = (path[-1] - path[0]).tolist()
    by = edges(solids, CLEARANCE, (x, y, z))
    room = read_only(np.array([-20.0] * 3 + [20.0] * 3))
    limits = read_only(np.full(4 * len(solids), CLEARANCE))
    length = math.inf
    pulled: Any = pull.pull
    for _ in range(20):
        begins = read_only(np.array([0, len(path)], dtype=np.int32))
        *found, begins, lengths = pulled(
            *columns(path), begins, by, packed(solids), limits, room, 21, 1.5, 30, 1e-7
        )
        best = int(np.argmin(lengths))
        path = np.stack(found, axis=1)[begins[best] : begins[best + 1]]
        if lengths[best] > (1 - 1e-5) * length:
            break
        length = float(lengths[best])
    return float(lengths[best])


@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@example(
    body={"shape": "sphere", "radius": 0.5, "position": [0.0, 0.75, 0.75], "wxyz": [0, 0, 0, 1]},
    start=[0.0, 0.0, 1.0],
    goal=[1.0, 3.0, 0.0],
)
@given(body=obstacles, start=points, goal=points)
def test_an_exact_bound_is_the_length_of_the_shortest_way_by_many_places(
    body: dict[str, Any], start: list[float], goal: list[float]
) -> None:
    scene = scene_of([body], start, goal)
    room = Workspace(min=(-20.0, -20.0, -20.0), max=(20.0, 20.0, 20.0))
    solids = tuple(solid for solid in scene.obstacles if not isinstance(solid, MeshShape))
    ends = np.array([start, goal])
    assume(math.dist(start, goal) > 0.1)
    assume(min(float(solid.signed_distance(ends).min()) for solid in solids) > CLEARANCE + 0.01)

    bound = lower_bound(scene.start, scene.goal, solids, CLEARANCE, room)

    # a way far round to begin with
    far = [ends + 9.0 * sign * np.eye(3)[axis] for axis in range(3) for sign in (-1, 1)]
    detours = [np.array([ends[0], *corners, ends[1]]) for corners in far]
    clear = [path for path in detours if segment_clearances(path, solids).min() > CLEARANCE]
    assume(clear)
    length = min(_tightened(path, solids) for path in clear)
    assert length >= bound.length * (1 - 1e-8)
    if bound.exact:
        assert length <= bound.length * 1.002


@settings(max_examples=60, deadline=None)
@given(bodies=st.lists(obstacles, max_size=3), start=points, goal=points)
def test_compiled_and_plain_bounds_are_the_same(
    bodies: list[dict[str, Any]], start: list[float], goal: list[float]
) -> None:
    scene = scene_of(bodies, start, goal)
    solids = tuple(solid for solid in scene.obstacles if not isinstance(solid, MeshShape))
    rows = packed(solids)
    kernel: Any = around.around

    lengths, exact = kernel(rows, CLEARANCE, *start, *goal)
    plain, plain_exact = kernel.py_func(rows.tolist(), CLEARANCE, *start, *goal)

    np.testing.assert_allclose(lengths, plain, rtol=1e-12)
    np.testing.assert_array_equal(exact, plain_exact)


def test_past_a_long_box_it_is_the_straight_way_over_the_faces() -> None:
    # over the top of a wall of no end: three sides of the section, unrolled
    box = {"shape": "box", "size": [1.0, 90.0, 2.0], "position": [3, 3, 1]}
    room = Workspace(min=(-50.0, -50.0, -50.0), max=(50.0, 50.0, 50.0))
    scene = scene_of([box], [1, 1, 1], [5, 5, 1])

    bound = lower_bound(scene.start, scene.goal, scene.obstacles, 0.0, room)

    assert bound.exact
    assert bound.length == pytest.approx(math.hypot(2 * math.hypot(1.5, 1) + 1, 4), rel=1e-9)
