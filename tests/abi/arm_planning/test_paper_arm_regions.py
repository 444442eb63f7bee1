"""The surfaces of the arm's shadow and reach part the places as the arm's own tests do."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from abi.arm_planning.branch.elbow_branch import ElbowBranch
from abi.arm_planning.exclusion.paper_arm_mask_kernels import reached_places
from abi.arm_planning.exclusion.paper_arm_region_kernels import arm_gaps
from abi.arm_planning.exclusion.paper_arm_regions import reachable, shadow
from abi.arm_planning.paper_arm_model import paper_arm
from abi.arm_planning.world.arm_worlds import paper_arm_world
from abi.arrays import FloatArray, flat, read_only
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.obstacle_set_kernels import distance_to_segment
from abi.robot.paper_arm.pose_kernels import CAPSULE, capsule_ends, pose_of
from abi.scene.arm_settings import Elbow
from abi.scene.scene import Scene
from tests.random_arms import arm_scene


def solid(triangles: FloatArray) -> trimesh.Trimesh:
    corners = triangles.reshape(-1, 3)
    return trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=True)


@pytest.mark.slow
@pytest.mark.parametrize("elbow", ["up", "down"])
def test_the_shadow_is_where_the_arm_touches_an_obstacle(elbow: Elbow) -> None:
    box = {"shape": "box", "size": [1.5, 1, 1], "position": [3, 2, 3.5]}
    ball = {"shape": "sphere", "radius": 0.6, "position": [1.5, 4, 2]}
    scene = Scene.from_dict({"version": 1, "obstacles": [box, ball]})
    arm, obstacles = paper_arm(scene.arm), ObstacleSet(scene.obstacles)
    collision_world = paper_arm_world(arm, obstacles, 0.0)
    triangles = shadow(arm, elbow, 0.0, collision_world, (scene.workspace.min, scene.workspace.max))
    assert len(triangles) > 100
    mesh = solid(triangles)
    assert mesh.is_watertight
    free = collision_world.only(collision_world.numbers >= 0)
    branch = ElbowBranch(arm, elbow, free, (0.0, 0.0), 0.0, 0.0)
    points = np.random.default_rng(0).uniform(0.1, 5.9, (300, 3))
    touching = np.zeros(len(points), dtype=bool)
    for number in range(len(obstacles)):
        touching |= branch.touching(points, number, np.ones(len(points), dtype=bool))
    reached = branch.reached(points)
    near = np.abs(mesh.nearest.on_surface(points)[1]) < 0.12
    inside = _winding(triangles, points) > 0.5
    compared = reached & ~near
    assert compared.sum() > 80
    assert (inside == touching)[compared].mean() > 0.98


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_gaps_are_the_least_distances_of_all_pairs(seed: int) -> None:
    scene = arm_scene(seed)
    arm, most = paper_arm(scene.arm), 0.3
    elbow: Elbow = "up" if seed % 2 else "down"
    collision_world = paper_arm_world(arm, ObstacleSet(scene.obstacles), 0.0)
    solids = collision_world.only(collision_world.numbers >= 0).beyond(0.0)
    points = np.random.default_rng(seed).uniform(scene.workspace.min, scene.workspace.max, (200, 3))
    table, forearm = arm.table(elbow), float(arm.forearm(scene.arm.q5))
    reached = np.zeros(len(points), dtype=np.bool_)
    reached_places(flat(points), table, forearm, 0.0, reached)
    gaps = np.empty(len(points))
    arm_gaps(flat(points), table, solids, forearm, read_only(reached), most, gaps)
    assert (gaps[~reached] == most).all()
    assert (gaps < most).any()
    kept = np.flatnonzero(
        solids.asked.reshape(-1, len(collision_world.numbers))[:, :-1].any(axis=0)
    )
    for k in np.flatnonzero(reached)[np.argsort(gaps[reached])][:80]:
        pose = pose_of(table, tuple(points[k]), forearm)
        least = most
        for c in range(len(table.capsules) // CAPSULE):
            if table.capsules[CAPSULE * c]:
                ends = capsule_ends(table, pose, c)
                radius = table.capsules[CAPSULE * c + 3]
                for row in kept.tolist():
                    away = distance_to_segment(solids.primitives, row, np.inf, *ends)
                    least = min(least, away - radius)
        assert gaps[k] == pytest.approx(least, abs=1e-9)


@pytest.mark.slow
def test_the_reach_is_where_inverse_kinematics_keeps_the_limits() -> None:
    arm = paper_arm(Scene.from_dict({"version": 1}).arm)
    triangles = reachable(arm, "up", 0.0, 0.0)
    collision_world = paper_arm_world(arm, ObstacleSet(()), -100.0)
    branch = ElbowBranch(
        arm, "up", collision_world.only(collision_world.numbers > 0), (0.0, 0.0), 0.0, 0.0
    )
    points = np.random.default_rng(1).uniform((-10, -16, 0.5), (16, 10, 15), (300, 3))
    near = np.abs(solid(triangles).nearest.on_surface(points)[1]) < 0.6
    inside = _winding(triangles, points) > 0.5
    assert (inside == branch.reached(points))[~near].mean() > 0.98


def _winding(triangles: FloatArray, points: FloatArray) -> FloatArray:
    """Number of closed triangles of any orientation that hide the way along x, modulo 2, (n,)."""
    found = np.zeros(len(points))
    for k, point in enumerate(points + np.array([0.0, 1.23e-7, 2.34e-7])):
        a, b, c = (triangles[:, i] - point for i in range(3))
        signs = [p[:, 1] * q[:, 2] - p[:, 2] * q[:, 1] for p, q in ((a, b), (b, c), (c, a))]
        hit = (signs[0] > 0) == (signs[1] > 0)
        hit &= (signs[1] > 0) == (signs[2] > 0)
        area = signs[0] + signs[1] + signs[2]
        ahead = a[:, 0] * signs[1] + b[:, 0] * signs[2] + c[:, 0] * signs[0]
        found[k] = np.count_nonzero(hit & (ahead / np.where(area == 0, 1, area) > 0)) % 2
    return found
