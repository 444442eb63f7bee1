"""A set of obstacles of every shape against its obstacles one by one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.obstacles import primitive_distances
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.obstacles.primitives import Box
from abi.obstacles.triangle_mesh.repair import clean
from abi.obstacles.triangle_mesh.surface import Surface
from tests.abi import meshes
from tests.abi.shape_distances import gradient, segment_distance, signed_distance
from tests.kernel_forms import compiled, plain
from tests.random_geometry import random_obstacle

seeds = st.integers(0, 2**32 - 1)


def mixed(random: np.random.Generator) -> ObstacleSet:
    """One to six obstacles in any order, with none, some or only meshes among them."""
    share = random.choice([0.0, 0.4, 1.0])
    return ObstacleSet(
        tuple(
            _mesh(random) if random.random() < share else random_obstacle(random)
            for _ in range(random.integers(1, 7))
        )
    )


def _mesh(random: np.random.Generator) -> Obstacle:
    vertices, faces = meshes.box(tuple(random.uniform(0.2, 2, 3).tolist()))
    pose = {"position": random.uniform(0, 6, 3).tolist(), "wxyz": random.normal(size=4).tolist()}
    if random.random() < 0.5:
        return MeshShape.of(clean(vertices, faces), **pose)
    two = meshes.joined((vertices, faces), (vertices + 0.2, faces))
    return MeshShape.of(Surface(*two, closed=True, layers=(len(faces),) * 2), **pose)


@pytest.mark.slow
@settings(max_examples=12)
@given(seeds)
def test_distances_are_those_of_the_obstacles_one_by_one(seed: int) -> None:
    random = np.random.default_rng(seed)
    obstacles = mixed(random)
    points = random.uniform(-1, 7, (40, 3))
    each = np.stack([signed_distance(one, points) for one in obstacles], axis=1)
    distance, number = obstacles.nearest(points)
    outward_distance, outward = obstacles.signed_distance_gradient(points)

    near = obstacles.distances_up_to(1.0, points)
    assert near[each < 1] == pytest.approx(each[each < 1], abs=1e-12)
    assert (near[each >= 1] >= 1 - 1e-12).all()
    for found in (distance, outward_distance, obstacles.signed_distance(points)):
        assert found == pytest.approx(each.min(axis=1), abs=1e-12)
    assert np.array_equal(number, each.argmin(axis=1))
    expected = [gradient(obstacles[k], p[None])[0] for k, p in zip(number, points, strict=True)]
    assert np.abs(outward - expected).max() <= 1e-9


@pytest.mark.slow
@settings(max_examples=12)
@given(seeds, st.floats(0, 1))
def test_a_segment_is_blocked_where_its_distance_is_below_the_margin(
    seed: int, margin: float
) -> None:
    random = np.random.default_rng(seed)
    obstacles = mixed(random)
    starts = random.uniform(-1, 7, (40, 3))
    ends = starts + random.normal(size=(40, 3))
    least = np.min([segment_distance(one, starts, ends) for one in obstacles], axis=0)
    sure = np.abs(least - margin) > 1e-9
    found = obstacles.blocked(starts, ends, margin)

    assert np.array_equal(found[sure], least[sure] < margin)
    back = obstacles.blocked(ends, starts, np.full(40, margin))
    assert np.array_equal(found[sure], back[sure])


@pytest.mark.slow
@settings(max_examples=8)
@given(seeds)
def test_bounds_and_boxes_hold_the_obstacles(seed: int) -> None:
    random = np.random.default_rng(seed)
    obstacles = mixed(random)
    low, high = obstacles.bounds
    for k, one in enumerate(obstacles):
        assert (low[k], high[k]) == (pytest.approx(one.bounds()[0]), pytest.approx(one.bounds()[1]))
    points = random.uniform(-1, 7, (40, 3))
    boxed = obstacles.boxed
    assert boxed.all_convex
    assert len(boxed) == len(obstacles)
    assert (boxed is obstacles) == obstacles.all_convex
    to_boxes = boxed.distances_up_to(20.0, points)
    assert (to_boxes <= obstacles.distances_up_to(20.0, points) + 1e-9).all()


@given(seeds)
def test_the_thinnest_primitive_tells_how_deep_its_centre_lies(seed: int) -> None:
    obstacles = mixed(np.random.default_rng(seed))
    depths = [-signed_distance(one, np.array([one.position]))[0] for one in obstacles.primitives]
    assert obstacles.least_depth == pytest.approx(min(depths, default=math.inf), abs=1e-12)


def test_primitives_and_meshes_know_their_numbers() -> None:
    ball = MeshShape.of(clean(*meshes.box((1.0, 1, 1))))
    boxes = tuple(Box(size=(1, 1, 1), position=(k, 0, 0)) for k in range(3))
    obstacles = ObstacleSet((boxes[0], ball, boxes[1], boxes[2], ball))

    assert obstacles.primitives == boxes
    assert obstacles.primitive_numbers.tolist() == [0, 2, 3]
    assert obstacles.meshes == (ball, ball)
    assert obstacles.mesh_numbers.tolist() == [1, 4]
    assert tuple(obstacles.meshes_alone) == (ball, ball)


@pytest.mark.parametrize("count", [0, 1, 5, 40])
def test_the_nearest_primitive_is_the_same_compiled_and_by_numpy(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(primitive_distances, "_AT_ONCE", 100)
    random = np.random.default_rng(count)
    some = [random_obstacle(random) for _ in range(count)]
    twice = ObstacleSet((*some, *some[:2]))  # as near as each other
    points = random.uniform(-1, 7, (60, 3))
    for point, one in zip(points, some, strict=False):
        point[:] = one.position
    points[30:40] = np.round(points[30:40])
    found = [form(lambda: twice.nearest(points)) for form in (plain, compiled)]
    for by_numpy, by_kernel in zip(*found, strict=True):
        assert by_numpy.tobytes() == by_kernel.tobytes()


def test_nothing_is_near_an_empty_set() -> None:
    nothing, points = ObstacleSet(), np.zeros((3, 3))

    assert not nothing
    assert nothing.signed_distance(points).tolist() == [math.inf] * 3
    assert nothing.distances_up_to(1.0, points).shape == (3, 0)
    assert nothing.polyline_clearance(points) == math.inf
    assert nothing.boxed is nothing
