"""Distances of a URDF arm's links over a motion, against those of all capsules one by one."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import scipy
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.arm_planning.world.chain_distances import Poses, obstacle_distances, own_distances
from abi.arrays import FloatArray
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.obstacles.primitives import Box
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.obstacles.triangle_mesh.repair import clean
from abi.robot.bodies.chain_capsules import segment_distances
from abi.robot.urdf.robot_files import SHIPPED, load_robot
from abi.robot.urdf_arm import UrdfArm, urdf_arm
from tests.abi import meshes
from tests.abi.shape_distances import segment_distance
from tests.random_geometry import random_obstacle

seeds = st.integers(0, 2**31)


@cache
def some_arm(name: str, grasping: bool = False) -> UrdfArm:
    robot = load_robot(name, MeshSource())
    return urdf_arm(robot, SHIPPED[name], (3.0, 3.0, 0.0), grasping=grasping)


def around(one: UrdfArm, random: np.random.Generator) -> ObstacleSet:
    """One to a hundred obstacles within reach, with none, some or only meshes among them."""
    share, count = random.choice([0.0, 0.3, 1.0]), random.choice([1, 7, 40, 100])
    spread, size = random.choice([0.5, 1.0, 5.0]), random.uniform(0.02, 0.4)
    shapes: list[Obstacle] = []
    for _ in range(count):
        place = tuple((one.base + random.normal(0, spread, 3)).tolist())
        if random.random() < share:
            shapes.append(MeshShape.of(clean(*meshes.box((size, size, 0.2))), position=place))
        elif size < 0.2:
            shapes.append(Box(size=(size, 0.1, size), position=place))
        else:
            shapes.append(random_obstacle(random).model_copy(update={"position": place}))
    return ObstacleSet(tuple(shapes))


@pytest.mark.slow
@settings(max_examples=12, deadline=None)
@given(st.sampled_from(list(SHIPPED)), st.booleans(), seeds)
def test_the_least_of_each_pose_and_what_touches_are_those_of_all_one_by_one(
    name: str, grasping: bool, seed: int
) -> None:
    one, random = some_arm(name, grasping), np.random.default_rng(seed)
    obstacles = around(one, random)
    ends = random.uniform(one.limits[:, 0], one.limits[:, 1], (2, len(one.limits)))
    ends[1] = ends[0] + random.choice([0.02, 0.3, 1.0]) * (ends[1] - ends[0])
    positions = ends[0] + np.linspace(0, 1, 50)[:, None] * (ends[1] - ends[0])
    enough = random.choice([0.05, np.inf])
    placed = one.place(positions)
    distance, number = obstacle_distances(one, obstacles, placed, enough)
    lengths = np.linalg.norm(placed[:, :, 1] - placed[:, :, 0], axis=2)
    p, q = placed[:, :, 0].reshape(-1, 3), placed[:, :, 1].reshape(-1, 3)
    of_each = [segment_distance(shape, p, q).reshape(distance.shape) for shape in obstacles]
    each = np.stack(of_each) - one.radii
    least = each.min(axis=0)
    found = np.isfinite(distance)
    assert np.array_equal(found, number >= 0)
    picked = np.take_along_axis(each, np.maximum(number, 0)[None], axis=0)[0]
    assert distance[found] == pytest.approx(picked[found], abs=1e-9)
    # of a mesh that is entered it is a bound
    assert (np.abs(distance - least) <= lengths / 64 + 1e-9)[found].all()
    outside = found & (least > -one.radii)
    assert distance[outside] == pytest.approx(least[outside], abs=1e-9)
    assert found[least < -1e-9].all()
    # with an object in the hand, the arm without both has a nearest link, too
    assert one.touchable.any() == grasping
    for links in (slice(None), ~one.touchable):
        nearest = least[:, links].min(axis=1)
        told = nearest < enough - 1e-9
        assert distance[:, links].min(axis=1)[told] == pytest.approx(nearest[told], abs=1e-9)


def test_without_obstacles_nothing_is_near() -> None:
    one = some_arm("ur5e")
    distance, number = obstacle_distances(one, ObstacleSet(), one.place(one.limits.T))
    assert np.isinf(distance).all()
    assert (number == -1).all()


@settings(max_examples=30, deadline=None)
@given(st.sampled_from(list(SHIPPED)), seeds)
def test_links_are_as_far_from_each_other_as_their_segments(name: str, seed: int) -> None:
    one, random = some_arm(name), np.random.default_rng(seed)
    low, high = one.limits.T
    poses = Poses.of(one, random.uniform(low, high, (7, len(low))))
    ends = poses.ends
    first, second = (ends[:, one.pairs[:, side]].reshape(-1, 2, 3) for side in (0, 1))
    apart = segment_distances(first, second).reshape(7, -1) - one.radii[one.pairs].sum(axis=1)
    found = own_distances(one, poses)
    clear = apart > 0
    assert found[clear] == pytest.approx(apart[clear], abs=1e-9 / one.metres)
    for pose, pair in np.argwhere(~clear).tolist():
        hulls = [corners(one, poses.positions[pose], k) for k in one.pairs[pair].tolist()]
        rounding = sum(one.capsules[k].rounding for k in one.pairs[pair].tolist()) / one.metres
        distance = hull_distance(*hulls) - rounding
        if distance > 1e-6 / one.metres:
            assert found[pose, pair] == pytest.approx(distance, abs=1e-5 / one.metres)
        elif distance < -1e-6 / one.metres:
            assert found[pose, pair] <= 0


@settings(max_examples=10, deadline=None)
@given(st.sampled_from(list(SHIPPED)), seeds)
def test_distances_of_links_that_are_far_apart_may_be_passed_over(name: str, seed: int) -> None:
    one, random = some_arm(name), np.random.default_rng(seed)
    low, high = one.limits.T
    ends, share = random.uniform(low, high, (2, len(low))), np.linspace(0, 1, 40)[:, None]
    poses = Poses.of(one, ends[0] + share * (ends[1] - ends[0]))
    found, enough = own_distances(one, poses), 0.05 * one.reach
    near, shortly = own_distances(one, poses, enough), own_distances(one, poses, enough, 20)
    counts = found <= enough
    assert near[counts] == pytest.approx(found[counts], abs=1e-9 / one.metres)
    assert (near[~counts] > enough).all()
    least, told = (each.reshape(2, -1).min(axis=1) for each in (found, shortly))
    assert np.minimum(told, enough) == pytest.approx(
        np.minimum(least, enough), abs=1e-9 / one.metres
    )


def corners(one: UrdfArm, pose: FloatArray, body: int) -> FloatArray:
    """Corners (k, 3) of a body's hull, world."""
    frames, capsule = one.chain.poses(pose[None] / one.scales)[0], one.capsules[body]
    if capsule.frame < 0:
        return capsule.points / one.metres
    turn, origin = frames[capsule.frame, :, :3], frames[capsule.frame, :, 3]
    return np.asarray((capsule.points @ turn.T + origin) / one.metres)


def hull_distance(first: FloatArray, second: FloatArray) -> float:
    """Distance between the hulls of points, as a sum of least squares in parts of one."""
    middle, size = first.mean(axis=0), 1.0 + float(np.abs(first - second.mean(axis=0)).max())
    sums = np.zeros((5, len(first) + len(second)))
    sums[:3] = np.concatenate([first - middle, middle - second]).T / size
    sums[3, : len(first)], sums[4, len(first) :] = 1e4, 1e4
    parts, _ = scipy.optimize.nnls(sums, np.array([0, 0, 0, 1e4, 1e4]), maxiter=10_000)
    a, b = parts[: len(first)], parts[len(first) :]
    return float(np.linalg.norm(a @ first / a.sum() - b @ second / b.sum()))
