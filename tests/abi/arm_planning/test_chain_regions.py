"""The surfaces of a URDF arm's shadow and reach part the places as other tests of the arm do."""

from __future__ import annotations

import numpy as np
import pytest
import scipy

from abi.arm_planning.exclusion.chain_regions import (
    chain_reach,
    chain_shadow,
    configurations_in,
    reach_box,
)
from abi.arm_planning.exclusion.node_configurations import NodeConfigurations
from abi.arm_planning.world.arm_worlds import chain_world
from abi.arm_planning.world.chain_distances import obstacle_distances
from abi.arrays import BoolArray, FloatArray
from abi.obstacles.convex_shape import ConvexShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.robot.urdf_arm import UrdfArm, urdf_arm
from abi.scene.scene import Scene, load_scene
from tests.abi.arm_planning.test_paper_arm_regions import _winding, solid


def arm_of(scene: Scene) -> UrdfArm:
    arm = scene.arm
    return urdf_arm(arm.robot, arm.tool, arm.base, arm.exact_axis, scene.unit)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("kitchen-ur5e")


@pytest.fixture(scope="module")
def arm(scene: Scene) -> UrdfArm:
    return arm_of(scene)


def stances_of(scene: Scene, arm: UrdfArm, whole: bool) -> NodeConfigurations:
    start = np.array(scene.start, dtype=float)
    box = reach_box(arm, 0.0) if whole else (scene.workspace.min, scene.workspace.max)
    return configurations_in(arm, arm.first_poses(start)[0], start, box)


def is_inside(triangles: FloatArray, points: FloatArray) -> BoolArray:
    return _winding(triangles, points) > 0.5


def gap_of(one: FloatArray, other: FloatArray) -> float:
    """Distance of the convex hulls of two sets of points, by least squares that are not below 0."""
    sums = 1e4 * np.array([[1] * len(one) + [0] * len(other), [0] * len(one) + [1] * len(other)])
    system = np.concatenate([np.concatenate([one, -other]).T, sums])
    shares, _ = scipy.optimize.nnls(system, np.array([0, 0, 0, 1e4, 1e4]))
    return float(np.linalg.norm(system[:3] @ shares))


def gaps_of(arm: UrdfArm, obstacles: ObstacleSet, positions: FloatArray) -> FloatArray:
    """Distances (k,) of the hulls of an arm's links to obstacles, below 0 where they overlap.

    Where capsules around them are clear, the distance is that of these.
    """
    ends, poses = arm.place(positions), arm.chain.poses(positions)
    gaps = np.full(len(positions), np.inf)
    for obstacle in obstacles:
        assert isinstance(obstacle, ConvexShape)
        around = np.unique(obstacle.triangles(sides=200).reshape(-1, 3), axis=0)
        away = obstacle_distances(arm, ObstacleSet((obstacle,)), ends)[0]
        for k, c in np.argwhere(away < 0).tolist():
            capsule = arm.capsules[c]
            pose = poses[k, capsule.frame] if capsule.frame >= 0 else np.eye(4)[:3]
            corners = capsule.points @ pose[:, :3].T + pose[:, 3]
            away[k, c] = gap_of(corners, around) - capsule.rounding
        gaps = np.minimum(gaps, away.min(axis=1))
    return gaps


@pytest.mark.slow
def test_the_shadow_is_where_a_link_is_in_an_obstacle(scene: Scene, arm: UrdfArm) -> None:
    configurations, obstacles = stances_of(scene, arm, whole=False), ObstacleSet(scene.obstacles)
    collision_world = chain_world(arm, obstacles, scene.workspace.min[2])
    triangles = chain_shadow(arm, configurations, collision_world)
    assert solid(triangles).is_watertight
    places = np.flatnonzero(configurations.reached)[::4]
    gaps = gaps_of(arm, obstacles, configurations.positions[places])
    clear_cut = np.abs(gaps) > 1e-5  # a cylinder is taken with 200 sides
    found = is_inside(triangles, configurations.mesh.points[places])
    assert 0.1 < found.mean() < 0.9
    assert (found == (gaps < 0))[clear_cut].all()

    nothing = chain_world(arm, ObstacleSet(()), scene.workspace.min[2])
    assert len(chain_shadow(arm, configurations, nothing)) == 0


@pytest.mark.slow
def test_the_tool_gets_to_places_inside_the_reach(scene: Scene, arm: UrdfArm) -> None:
    configurations = stances_of(scene, arm, whole=True)
    triangles = chain_reach(configurations)
    mesh = solid(triangles)
    assert mesh.is_watertight
    low, high = mesh.bounds
    points = np.random.default_rng(0).uniform(low, high, (120, 3))
    inside = is_inside(triangles, points)
    deep = inside & (np.abs(mesh.nearest.on_surface(points)[1]) > configurations.mesh.pitch)
    assert deep.sum() > 5
    for point in points[deep][:8]:
        poses = np.stack(arm.first_poses(point))
        missed = np.linalg.norm(arm.tool(poses) - point, axis=1)
        assert missed.min() < 1e-4 * arm.reach
    middle = arm.chain.table.origins[9:12] / arm.metres
    assert (
        np.linalg.norm(triangles - middle, axis=2).max() < arm.reach + 2 * configurations.mesh.pitch
    )
