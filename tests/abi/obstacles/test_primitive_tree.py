"""The tree over primitives against all of them one by one."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.arrays import FloatArray, flat
from abi.obstacles import obstacle_set_kernels, primitive_tree_kernels
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, Obstacles, ObstacleSet
from abi.obstacles.primitive_kernels import WIDTH
from abi.obstacles.primitives import Sphere
from abi.obstacles.triangle_mesh.repair import clean
from tests.abi import meshes
from tests.abi.shape_distances import segment_distance, signed_distance
from tests.kernel_forms import compiled, plain
from tests.random_geometry import random_obstacle, random_obstacles
from tests.thorough import examples

seeds = st.integers(0, 2**32 - 1)


def crowd(random: np.random.Generator) -> Obstacles:
    """Some to many: small and apart, large and across each other, alike, or on one line."""
    kind, count = int(random.integers(4)), int(random.integers(1, 80))
    if kind == 0:
        return random_obstacles(random, count, 6.0, 0.7)
    if kind == 1:
        return tuple(random_obstacle(random) for _ in range(count))
    if kind == 2:
        return (random_obstacle(random),) * count
    return tuple(Sphere(radius=0.1, position=(2.0**-k, 3.0, 3.0)) for k in range(count))


def segments(random: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
    """Short and long ones, some of no length and some along the axes."""
    starts = random.uniform(-1, 7, (count, 3))
    ends = starts + random.normal(size=(count, 3)) * random.choice([0, 0.1, 5.0], (count, 1))
    along = random.random(count) < 0.2
    ends[along, 1:] = starts[along, 1:]
    return starts, ends


@settings(max_examples=examples(20))
@given(seeds)
def test_each_primitive_is_met_once_and_lies_in_the_bounds_above_it(seed: int) -> None:
    packed: Any = ObstacleSet(crowd(np.random.default_rng(seed))).packed
    rows = packed.reshape(-1, WIDTH)
    met: list[int] = []
    above: list[tuple[int, int]] = []
    row = primitive_tree_kernels.first_row(packed)
    while row >= 0:
        above = [other for other in above if other[1] != row]
        met.append(row)
        for box in [rows[other, 23:29] for other, _ in above] + [rows[row, 23:29]]:
            assert (box[:3] <= rows[row, 17:20]).all()
            assert (rows[row, 20:23] <= box[3:]).all()
        above.append((row, primitive_tree_kernels.row_after(packed, row)))
        row = primitive_tree_kernels.row_below(packed, row)
    assert sorted(met) == list(range(len(rows)))


@pytest.mark.slow
@settings(max_examples=10)
@given(seeds, st.floats(0, 0.5))
def test_queries_find_what_the_primitives_say_one_by_one(seed: int, margin: float) -> None:
    random = np.random.default_rng(seed)
    obstacles = ObstacleSet(crowd(random))
    starts, ends = segments(random, 20)
    each = np.stack([signed_distance(one, starts) for one in obstacles], axis=1)
    along = np.stack([segment_distance(one, starts, ends) for one in obstacles], axis=1)

    distance, number = obstacles.nearest(starts)
    assert distance == pytest.approx(each.min(axis=1), abs=1e-12)
    assert np.take_along_axis(each, number[:, None], 1)[:, 0] == pytest.approx(distance, abs=1e-12)
    polylines = np.stack([starts, ends], axis=1)
    assert obstacles.polyline_clearances(polylines) == pytest.approx(along.min(axis=1), abs=1e-11)
    sure = np.abs(along.min(axis=1) - margin) > 1e-9
    blocked = obstacles.blocked(starts, ends, margin)
    assert np.array_equal(blocked[sure], along.min(axis=1)[sure] < margin)
    near = obstacle_set_kernels.near_polyline(
        flat(np.concatenate([starts[:1], ends[:1]])), obstacles.packed, margin
    )
    close = along[0] < margin
    assert near[close] == pytest.approx(along[0][close], abs=1e-11)
    assert np.isinf(near[along[0] > margin + 1e-9]).all()


def test_alike_primitives_are_found_by_their_first_number() -> None:
    ball = Sphere(radius=1, position=(3, 3, 3))
    obstacles = ObstacleSet((Sphere(radius=0.1), *[ball] * 20))
    points = np.array([[5.0, 3, 3], [3, 3, 3], [4, 3, 3]])

    assert obstacles.nearest(points)[1].tolist() == [1, 1, 1]


@settings(max_examples=10)
@given(seeds)
def test_both_forms_of_the_kernels_make_the_same_tree(seed: int) -> None:
    obstacles = crowd(np.random.default_rng(seed))
    as_python, as_machine = (
        form(lambda: ObstacleSet(obstacles).packed) for form in (plain, compiled)
    )
    assert np.array_equal(as_python, as_machine)


@settings(max_examples=8)
@given(seeds, st.booleans())
def test_many_meshes_are_found_where_they_are_near(seed: int, mixed: bool) -> None:
    random = np.random.default_rng(seed)
    few: list[Obstacle] = [
        MeshShape.of(
            clean(*meshes.box((0.5, 0.3, 0.4))),
            position=tuple(random.uniform(0, 6, 3).tolist()),
            wxyz=tuple(random.normal(size=4).tolist()),
        )
        for _ in range(8)
    ]
    others = random_obstacles(random, 5, 6.0, 1.0) if mixed else ()
    obstacles = ObstacleSet((*few, *others))
    starts, ends = segments(random, 30)
    each = np.stack([signed_distance(one, starts) for one in obstacles], axis=1)
    along = np.min([segment_distance(one, starts, ends) for one in obstacles], axis=0)

    distance, number = obstacles.nearest(starts)
    assert distance == pytest.approx(each.min(axis=1), abs=1e-9)
    assert np.take_along_axis(each, number[:, None], 1)[:, 0] == pytest.approx(distance, abs=1e-9)
    polylines = np.stack([starts, ends], axis=1)
    outside = along > 0  # within, the distance along is a bound
    clearances = obstacles.polyline_clearances(polylines)
    assert clearances[outside] == pytest.approx(along[outside], abs=1e-8)
    near = clearances < 0.5
    up_to = obstacles.polyline_clearances(polylines, 0.5)
    assert up_to[near] == pytest.approx(clearances[near], abs=1e-8)
    assert (up_to[~near] >= 0.5).all()
    assert up_to.min() == pytest.approx(clearances.min(), abs=1e-8)
    near = distance < 0.5
    up_to = obstacles.signed_distance(starts, 0.5)
    assert up_to[near] == pytest.approx(distance[near], abs=1e-9)
    assert (up_to[~near] >= 0.5).all()
    sure = np.abs(along - 0.1) > 1e-6
    assert np.array_equal(obstacles.blocked(starts, ends, 0.1)[sure], along[sure] < 0.1)
    assert math.isinf(ObstacleSet().nearest(starts)[0].max())
