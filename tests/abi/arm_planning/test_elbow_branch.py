"""Places at which the arm touches something, beside distances measured singly."""

from __future__ import annotations

import numpy as np
import pytest

from abi.arm_planning.branch.elbow_branch import ElbowBranch
from abi.arm_planning.paper_arm_model import paper_arm
from abi.arm_planning.world.arm_worlds import paper_arm_world
from abi.errors import format_length
from abi.obstacles.obstacle_set import ObstacleSet
from abi.robot.paper_arm.inverse_kinematics import solve
from abi.robot.paper_arm.link_capsules import COLUMN
from abi.scene.arm_settings import Elbow
from tests.random_arms import arm_scene

_SLACK = 0.006
_ROUNDING = 1e-6
_SAMPLES = 60
"""Along each capsule, at most 0.1 apart."""


@pytest.mark.parametrize("elbow", ["up", "down"])
@pytest.mark.parametrize("seed", range(4))
def test_places_touch_an_obstacle_where_the_capsules_do(seed: int, elbow: Elbow) -> None:
    scene = arm_scene(seed)
    arm, obstacles = paper_arm(scene.arm), ObstacleSet(scene.obstacles)
    collision_world = paper_arm_world(arm, obstacles, scene.workspace.min[2])
    branch = ElbowBranch(arm, elbow, collision_world, (0.0, 0.0), 0.0, _SLACK)
    points = np.random.default_rng(seed).uniform(0, 6, (300, 3))
    points = points[branch.reached(points)]
    joints = np.zeros((len(points), 6))
    joints[:, :3], _ = solve(arm, points, np.zeros(len(points)), elbow, np.zeros_like(points))
    ends = arm.place(joints)
    moving = [k for k, capsule in enumerate(arm.capsules) if capsule.body != COLUMN]
    shares = np.linspace(0, 1, _SAMPLES)
    for number, obstacle in enumerate(obstacles):
        touching = branch.touching(points, number, np.ones(len(points), dtype=bool))
        away = np.full(len(points), np.inf)
        for k in moving:
            low, high = ends[:, k, 0], ends[:, k, 1]
            rows = low[None] + shares[:, None, None] * (high - low)[None]
            distances = ObstacleSet((obstacle,)).signed_distance(rows.reshape(-1, 3))
            nearest = distances.reshape(_SAMPLES, -1).min(axis=0) - arm.capsules[k].radius
            away = np.minimum(away, nearest)
        assert touching[away < _SLACK - _ROUNDING].all()
        assert not touching[away > _SLACK + 0.05 + _ROUNDING].any()


@pytest.mark.parametrize("elbow", ["up", "down"])
def test_a_place_that_is_not_reached_has_a_distance_or_a_limit(elbow: Elbow) -> None:
    scene = arm_scene(1)
    arm = paper_arm(scene.arm)
    collision_world = paper_arm_world(arm, ObstacleSet(()), scene.workspace.min[2])
    branch = ElbowBranch(arm, elbow, collision_world, (0.0, 0.0), 0.0, _SLACK)
    reach = arm.a3 + arm.a4 + arm.a5
    points = arm.shoulder + np.random.default_rng(3).uniform(-1.2, 1.2, (200, 3)) * reach
    reasons = set()
    for point in points:
        fault = branch.polyline_refutation(point[None])
        words = branch.unreached(point)
        if fault is not None and fault.capsule >= 0:
            continue
        assert (words == "") == (fault is None)
        if not words:
            continue
        distance = float(np.linalg.norm(point - arm.shoulder))
        if words.startswith("is out of reach by "):
            nearest = abs(arm.a3 - arm.a4 - arm.a5)
            edge = nearest if "too near" in words else reach
            assert format_length(abs(distance - edge)) in words
            assert (distance > edge) == ("too near" not in words)
            reasons.add("distance")
        else:
            ((_, q2, q3),), _ = solve(arm, point[None], np.zeros(1), elbow, np.zeros((1, 3)))
            joint = words.split()[2]
            value, part = {"q2": (q2, "shoulder"), "q3": (q3, "elbow")}[joint]
            limit = arm.limits[int(joint[1]) - 1, 1]
            assert abs(value) > limit - 0.011
            assert f"{joint} (the {part}) at {np.degrees(value):.1f}°" in words
            assert f"its limit of {np.degrees(np.copysign(limit, value)):.1f}°," in words
            reasons.add(joint)
    assert reasons >= {"distance"} | ({"q2"} if elbow == "down" else set())
