"""Proofs of an arm's motion between samples, against dense sampling."""

from __future__ import annotations

from dataclasses import asdict
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.arm_planning.certificates.chain_certificate import certify_chain, chain_refutation
from abi.arm_planning.world.arm_worlds import chain_world
from abi.arm_planning.world.chain_distances import (
    Poses,
    floor_distances,
    hull_distances_to,
    obstacle_distances,
    own_distances,
)
from abi.arm_planning.world.collision_world import FLOOR
from abi.arrays import FloatArray
from abi.curves.clearance.certificate import Certificate
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.obstacles.primitives import Sphere
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.obstacles.triangle_mesh.repair import clean
from abi.robot.bodies.chain_capsules import segment_distances
from abi.robot.urdf.robot_files import SHIPPED, load_robot, robot_from_archive
from abi.robot.urdf_arm import UrdfArm, urdf_arm
from tests.abi import meshes
from tests.abi.robot.robots import OWN, arm, joint, link, packed, urdf
from tests.random_geometry import random_obstacle
from tests.thorough import examples

seeds = st.integers(0, 2**31)


@cache
def some_arm(name: str) -> UrdfArm:
    if name in OWN:
        return urdf_arm(robot_from_archive(packed({"a.urdf": OWN[name]})), "d", (1.0, 2.0, 3.0))
    return urdf_arm(load_robot(name, MeshSource()), SHIPPED[name], (10.0, -20.0, 5.0), None, "cm")


ARMS = (*SHIPPED, *OWN)


def joint_path(one: UrdfArm, random: np.random.Generator, size: float = 0.3) -> FloatArray:
    low, high = one.limits[:, 0], one.limits[:, 1]
    start = random.uniform(low, high)
    steps = random.uniform(-size, size, (6, len(low))) * one.scales
    return np.clip(start + np.cumsum(steps, axis=0), low, high)


def some_obstacles(one: UrdfArm, random: np.random.Generator) -> ObstacleSet:
    """Two solids near the arm, one of them a mesh at times."""
    middle = one.tool(one.limits.mean(axis=1)[None])[0] - 3 / one.metres
    shapes: list[Obstacle] = [random_obstacle(random) for _ in range(2)]
    if random.random() < 0.3:
        shapes[0] = MeshShape.of(clean(*meshes.sphere(1)), position=shapes[0].position)
    return ObstacleSet(
        tuple(
            one_shape.model_copy(update={"position": tuple(np.array(one_shape.position) + middle)})
            for one_shape in shapes
        )
    )


def at(positions: FloatArray, parameter: float) -> FloatArray:
    """Joint positions at a parameter that counts rows."""
    rows = np.arange(len(positions))
    return np.array([np.interp(parameter, rows, column) for column in positions.T])


def between(positions: FloatArray, parts: int = 25) -> FloatArray:
    """Joint positions between the samples, many of them."""
    share = np.linspace(0, 1, parts)[:, None, None]
    return np.asarray(positions[:-1] + share * np.diff(positions, axis=0)).reshape(
        -1, positions.shape[1]
    )


@settings(max_examples=examples(20))
@given(seeds)
def test_segments_are_as_far_apart_as_the_best_of_their_points(seed: int) -> None:
    random = np.random.default_rng(seed)
    first, second = random.normal(size=(2, 5, 2, 3))
    if seed % 3 == 0:
        second[0], first[1, 1] = first[0] + 0.1, first[1, 0]  # parallel, and a point
    share = np.linspace(0, 1, 81)[:, None]
    for a, b, found in zip(first, second, segment_distances(first, second), strict=True):
        on_a, on_b = (one[0] + share * (one[1] - one[0]) for one in (a, b))
        away = np.linalg.norm(on_a[:, None] - on_b[None], axis=2).min()
        step = (np.linalg.norm(a[1] - a[0]) + np.linalg.norm(b[1] - b[0])) / 160
        assert away - step <= found <= away + 1e-12


@settings(max_examples=40)
@given(st.sampled_from(ARMS), seeds)
def test_no_point_moves_farther_than_the_levers_say(name: str, seed: int) -> None:
    one, random = some_arm(name), np.random.default_rng(seed)
    positions = joint_path(one, random)[:2]
    ends = one.place(between(positions))
    moved = np.linalg.norm(np.diff(ends, axis=0), axis=3).sum(axis=0).max(axis=1)

    allowed = one.levers @ np.abs(positions[1] - positions[0])
    assert (moved <= allowed + 1e-9).all()


@settings(max_examples=40)
@given(st.sampled_from(ARMS), seeds)
def test_no_pair_moves_farther_beside_each_other_than_its_levers_say(name: str, seed: int) -> None:
    one, random = some_arm(name), np.random.default_rng(seed)
    positions = joint_path(one, random)[:2]
    ends = one.place(between(positions))
    gaps = np.stack([segment_distances(ends[:, i], ends[:, j]) for i, j in one.pairs], axis=1)
    changed = np.abs(np.diff(gaps, axis=0)).sum(axis=0)

    assert (changed <= one.pair_levers @ np.abs(positions[1] - positions[0]) + 1e-9).all()


@pytest.mark.slow
@settings(max_examples=12)
@given(st.sampled_from(ARMS), seeds)
def test_nothing_comes_nearer_than_what_is_proven(name: str, seed: int) -> None:
    one, random = some_arm(name), np.random.default_rng(seed)
    obstacles = some_obstacles(one, random)
    collision_world = chain_world(one, obstacles, -1e3)
    positions = joint_path(one, random, 0.05)
    dense = Poses.of(one, between(positions))
    of_capsules = obstacle_distances(one, obstacles, dense.ends)
    gaps, numbers = hull_distances_to(one, dense, collision_world, of_capsules, np.inf)
    measured = float(gaps.min())
    margin = max(float(random.uniform(0, 1.2)) * measured, 0.0)
    found = certify_chain(one, positions, collision_world, margin)
    refutation = chain_refutation(one, positions, collision_world, margin)
    clear = (
        float(own_distances(one, dense).min(initial=np.inf)) > 0
        and float(floor_distances(one, collision_world.floor, dense).min(initial=np.inf)) > 0
    )
    if isinstance(found, Certificate):
        assert refutation is None
        assert clear
        if measured <= margin:
            # clear of a mesh's surface, all the time inside
            within = obstacles.obstacles[
                int(numbers[np.unravel_index(gaps.argmin(), numbers.shape)])
            ]
            assert not within.convex
            assert (gaps.min(axis=1) < 0).all()
        return
    assert refutation is not None
    nearly = 1e-6 / one.metres
    for fault in (found, refutation):  # the two look at the same stretches in another order
        if fault.obstacle >= 0 and not obstacles.obstacles[fault.obstacle].convex:
            continue  # of a mesh the rectangles around triangles count
        if not fault.decided:
            # given up only where something is nearly as near
            assert not clear or measured < margin + 1e-3 / one.metres
            continue
        place = Poses.of(one, at(positions, fault.parameter)[None])
        of_capsules = obstacle_distances(one, obstacles, place.ends)
        distances = {
            "own": own_distances(one, place),
            "floor": floor_distances(one, collision_world.floor, place),
            "solid": hull_distances_to(one, place, collision_world, of_capsules, np.inf)[0]
            - margin,
        }
        kind = "solid" if fault.obstacle >= 0 else "floor" if fault.obstacle == FLOOR else "own"
        assert float(distances[kind].min()) < nearly


@settings(max_examples=15)
@given(st.sampled_from(ARMS), seeds)
def test_what_is_far_away_leaves_as_many_tries_for_what_is_near(name: str, seed: int) -> None:
    one, random = some_arm(name), np.random.default_rng(seed)
    near, positions, tries = some_obstacles(one, random), joint_path(one, random, 0.05), 300
    x, y, z = one.base + 9 * one.reach
    far = tuple(Sphere(radius=0.1, position=(x + k, y, z)) for k in range(100))
    alone, among = (
        chain_refutation(one, positions, chain_world(one, solids, -1e3), 0.0, tries)
        for solids in (near, ObstacleSet((*near, *far)))
    )
    assert tries <= len(far) * len(one.capsules)
    if alone is None or among is None:
        assert among is alone
    else:
        assert asdict(among) == asdict(alone)


@pytest.mark.parametrize(
    ("kind", "low", "high"),
    [("revolute", 3.5, 5.5), ("revolute", -6.0, -4.0), ("prismatic", 4.0, 10.0)],
)
def test_first_poses_fill_the_range_of_a_joint_beyond_half_a_turn(
    kind: str, low: float, high: float
) -> None:
    first = '<joint name="p" type="revolute">', f'<joint name="p" type="{kind}">'
    limits = 'lower="-2" upper="2"', f'lower="{low}" upper="{high}"'
    one = urdf_arm(robot_from_archive(packed({"a.urdf": arm(first, limits)})), "d", (0, 0, 0))
    for share in (0.1, 0.5, 0.9):
        pose = np.array([low + share * (high - low), 0.7, 0.4])
        (point,) = one.tool(pose[None])
        found = np.array(one.first_poses(point))
        np.testing.assert_allclose(one.tool(found), np.tile(point, (len(found), 1)), atol=1e-5)
        assert ((found >= one.limits[:, 0]) & (found <= one.limits[:, 1])).all()
    assert one.pairs.shape == (3, 2)


@pytest.mark.parametrize("name", SHIPPED)
def test_first_poses_reach_the_point_in_different_ways(name: str) -> None:
    one = some_arm(name)
    point = one.base + np.array([35.0, 10.0, 40.0])
    poses = one.first_poses(point)

    assert len(poses) > 3
    np.testing.assert_allclose(
        one.tool(np.array(poses)), np.tile(point, (len(poses), 1)), atol=1e-5
    )
    gaps = [np.abs(a - b).max() for k, a in enumerate(poses) for b in poses[:k]]
    assert min(gaps) > 0.3
    far = one.first_poses(one.base + 1000.0)
    assert len(far) == 1
    assert np.linalg.norm(one.tool(np.array(far))[0] - one.base) > 60  # stretched out towards it


def test_further_poses_leave_a_short_slide_where_it_was_put() -> None:
    """A torso that rises little: a step of inverse kinematics would take it to its limit."""
    limits = '<limit lower="0" upper="0.2" velocity="1" effort="9"/>'
    text = urdf(
        *map(link, "abcdef"),
        joint("torso", "a", "b", "prismatic", extra=limits),
        joint("p", "b", "c"),
        joint("q", "c", "d", axis="1 0 0"),
        joint("r", "d", "e", axis="0 1 0"),
        joint("s", "e", "f", axis="1 0 0"),
    )
    one = urdf_arm(robot_from_archive(packed({"a.urdf": text})), "f", (0, 0, 0))
    point = one.tool(np.array([[0.1, 0.3, 0.4, 0.2, 0.3]]))[0]
    first, every = one.first_poses(point), one.first_poses(point, 1000)
    np.testing.assert_allclose(
        one.tool(np.array(every)), np.tile(point, (len(every), 1)), atol=1e-5
    )
    np.testing.assert_array_equal(every[: len(first)], first)
    slides = np.array(every)[:, 0]
    assert np.count_nonzero((slides > 1e-3) & (slides < 0.199)) >= 5
