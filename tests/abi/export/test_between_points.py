"""What a controller makes of an exported motion between its points."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy

import abi
from abi.certification.certify_motion import certify_motion
from abi.certification.joint_limits import joint_limits
from abi.certification.read_motion import own_joints, read_motion
from abi.certification.robot_motion import robot_motion
from abi.export import between_points, joint_trajectory, ros_trajectory
from abi.export.formats import FORMATS
from abi.planner.plan import Plan

GANTRY = """<robot name="gantry"><link name="base"/><link name="lx"/>
<link name="tool"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
<joint name="jx" type="prismatic"><parent link="base"/><child link="lx"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="3" velocity="100" effort="1"/></joint>
<joint name="jz" type="prismatic"><parent link="lx"/><child link="tool"/><axis xyz="0 0 1"/>
<limit lower="0" upper="9" velocity="100" effort="1"/></joint></robot>"""
WALL = {"shape": "box", "size": [0.02, 2.0, 8.8], "position": [1.08, 0.0, 4.4]}


def planned(folder: Path, samples: int) -> Plan:
    """A gantry that goes to a wall, and up along it as closely as the clearance lets it."""
    (folder / "gantry.urdf").write_text(GANTRY, encoding="utf-8")
    scene = abi.Scene.from_dict(
        {
            "version": 1,
            "unit": "m",
            "workspace": {"min": [-1, -1, 0], "max": [3, 1, 9]},
            "start": {"joints": [0.0, 0.2]},
            "obstacles": [WALL],
            "tasks": [{"goal": {"joints": [1.0, 0.2]}}, {"goal": {"joints": [1.0, 8.5]}}],
            "motion": {"samples": samples, "speed": 100, "acceleration": 50, "deceleration": 0.5},
            "spline": {"clearance": 0},
            "arm": {"model": "urdf", "urdf": "gantry.urdf", "base": [0, 0, 0], "search": "joints"},
        },
        folder=folder,
    )
    return abi.plan_tasks(scene).joined


@pytest.mark.slow
@pytest.mark.parametrize("samples", [3, 101])
def test_a_message_that_says_clear_is_clear_as_controllers_read_it(
    tmp_path: Path, samples: int
) -> None:
    plan = planned(tmp_path, samples)
    for name in ("a.ros.json", "a.ros.yaml"):
        text = ros_trajectory.write(plan, name)
        motion = read_motion(name, text, own_joints(plan.scene.arm.robot))
        assert motion.interpolation == "quintic"
        assert certify_motion(motion, plan.scene.replace(tasks=())).state == "clear"
        assert b"straight ways" not in text


LIFT = """<robot name="lift"><link name="base"><collision><origin xyz="{2} 0 0.5"/>
<geometry><box size="0.1 0.1 1"/></geometry></collision></link><link name="between"/>
<link name="hand"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<joint name="near" type="prismatic"><parent link="base"/><child link="between"/>
<origin xyz="0 0 {1}"/><axis xyz="0 0 -1"/><limit lower="0" upper="{0}" velocity="{3}" effort="1"/>
</joint><joint name="aside" type="prismatic"><parent link="between"/><child link="hand"/>
<axis xyz="0 1 0"/><limit lower="0" upper="1" velocity="5" effort="1"/></joint></robot>"""


@pytest.mark.parametrize("samples", [3, 101])
@pytest.mark.parametrize(
    ("limit", "height", "post", "obstacles", "speed"),
    [
        (0.949, 1.0, 0.4, [], 5.0),
        (2.0, 1.0, 0.4, [], 5.0),
        (2.0, 1.0, 0.4, [], 0.5),
        (2.0, 2.0, 0.0, [], 5.0),
        (2.0, 2.0, 0.4, [{"shape": "box", "size": [0.4, 1, 1], "position": [0, 0, 0.5]}], 5.0),
    ],
    ids=["limit", "floor", "floor, too fast", "link", "obstacle"],
)
def test_velocities_are_left_out_where_with_them_a_joint_would_pass_what_it_nearly_reaches(
    tmp_path: Path,
    limit: float,
    height: float,
    post: float,
    obstacles: list[Any],
    speed: float,
    samples: int,
) -> None:
    (tmp_path / "lift.urdf").write_text(LIFT.format(limit, height, post, speed), encoding="utf-8")
    low = 0.949 if limit < 1 else 0.94995
    scene = abi.Scene.from_dict(
        {
            "version": 1,
            "unit": "m",
            "workspace": {"min": [-1, -1, 0], "max": [1, 1, 3]},
            "start": {"joints": [0.0, 0.0]},
            "goal": {"joints": [low, 0.0]},
            "obstacles": obstacles,
            "motion": {"samples": samples, "speed": 5, "acceleration": 1, "deceleration": 10},
            "spline": {"clearance": 0},
            "arm": {"model": "urdf", "urdf": "lift.urdf", "base": [0, 0, 0], "search": "joints"},
        },
        folder=tmp_path,
    )
    plan = abi.plan(scene)
    text = ros_trajectory.write(plan, "a.ros.yaml")
    motion = read_motion("a.ros.yaml", text, own_joints(scene.arm.robot))
    assert motion.interpolation == ("linear" if samples == 3 else "quintic")
    verdict = certify_motion(motion, scene)
    assert verdict.state == "clear"
    assert not [one for one in verdict.limits.passed if one.quantity == "position"]
    assert (b"straight ways" in text) == (samples == 3)
    assert (b"PASSES LIMITS" in text) == (speed < 5)
    if obstacles:  # faster than any motion that can be judged
        assert plan.motion is not None
        fast = replace(plan, motion=replace(plan.motion, time=1e-6 * plan.motion.time))
        assert b"straight ways" in ros_trajectory.write(fast, "a.ros.yaml")


@pytest.mark.parametrize("samples", [3, 101])
def test_what_a_later_leg_holds_keeps_clear_where_controllers_go_with_velocities(
    tmp_path: Path, samples: int
) -> None:
    (tmp_path / "lift.urdf").write_text(LIFT.format(2.0, 1.1, 0.4, 5), encoding="utf-8")
    scene = abi.Scene.from_dict(
        {
            "version": 1,
            "unit": "m",
            "workspace": {"min": [-1, -1, 0], "max": [1, 1, 3]},
            "start": {"joints": [0.0, 0.0]},
            "obstacles": [{"shape": "box", "size": [0.1] * 3, "position": [0, 0.1, 0.999]}],
            "tasks": [
                {"goal": {"joints": [0.0, 0.1]}, "attach": 0},
                {"goal": {"joints": [0.0, 0.5]}},
                {"goal": {"joints": [0.94895, 0.5]}},  # the box ends 0.05 mm above the floor
            ],
            "motion": {"samples": samples, "speed": 5, "acceleration": 1, "deceleration": 10},
            "spline": {"clearance": 0},
            "arm": {"model": "urdf", "urdf": "lift.urdf", "base": [0, 0, 0], "search": "joints"},
        },
        folder=tmp_path,
    )
    plan = abi.plan_tasks(scene).joined
    text = ros_trajectory.write(plan, "a.ros.json")
    motion = read_motion("a.ros.json", text, own_joints(scene.arm.robot))
    assert motion.interpolation == ("linear" if samples == 3 else "quintic")
    rows = slice(2 * (samples - 1), None)
    rates = [
        None if one is None else one[rows] for one in (motion.velocities, motion.accelerations)
    ]
    last = replace(
        motion,
        times=motion.times[rows],
        positions=motion.positions[rows],
        velocities=rates[0],
        accelerations=rates[1],
    )
    assert certify_motion(last, plan.legs[2].scene).state == "clear"


@pytest.mark.parametrize(
    ("law", "samples"), [("time_optimal", 8), ("time_optimal", 401), ("jerk_limited", 51)]
)
def test_limits_of_rates_that_samples_keep_are_kept_or_told_as_controllers_read_them(
    tmp_path: Path, law: str, samples: int
) -> None:
    (tmp_path / "lift.urdf").write_text(LIFT.format(2.0, 2.0, 0.4, 1.0), encoding="utf-8")
    scene = abi.Scene.from_dict(
        {
            "version": 1,
            "unit": "m",
            "workspace": {"min": [-1, -1, 0], "max": [1, 1, 3]},
            "start": {"joints": [0.0, 0.0]},
            "goal": {"joints": [0.9, 0.0]},
            "motion": {"law": law, "samples": samples},
            "arm": {"model": "urdf", "urdf": "lift.urdf", "base": [0, 0, 0], "search": "joints"},
        },
        folder=tmp_path,
    )
    plan = abi.plan(scene)
    assert not plan.limits_passed
    message = ros_trajectory.write(plan, "a.ros.json")
    assert {*json.loads(message)} == {"header", "joint_names", "points"}
    text = ros_trajectory.write(plan, "a.ros.yaml")
    motion = read_motion("a.ros.json", message, own_joints(scene.arm.robot))
    passed = joint_limits(robot_motion(motion, scene), 8.0).passed
    assert not [one for one in passed if one.quantity == "speed" and one.value > 1.001 * one.limit]
    told = any(one.quantity == "acceleration" for one in passed)
    assert (motion.interpolation == "linear") == (samples == 8)
    assert told == (samples == 401)
    assert (b"acceleration limit of 8 m/s" in text) == told
    assert (FORMATS["rosbag"].limits_warning(plan) != "") == told
    assert not FORMATS["csv"].limits_warning(plan)


def test_the_bound_of_the_departure_holds_for_the_polynomials() -> None:
    plan = abi.plan(abi.load_scene("kitchen-ur5e"))
    motion, arm = plan.motion, plan.arm
    assert motion is not None
    assert arm is not None
    few = slice(None, None, 20)
    coarse = replace(
        motion,
        time=motion.time[few],
        positions=motion.positions[few],
        rates=(motion.joint_velocities[few], motion.joint_accelerations[few]),
    )
    values = np.stack([coarse.positions, coarse.joint_velocities, coarse.joint_accelerations], 1)
    polynomial = scipy.interpolate.BPoly.from_derivatives(coarse.time, values)
    coarse_plan = replace(plan, motion=coarse)
    times = np.linspace(0.0, float(coarse.time[-1]), 500)
    straight = scipy.interpolate.make_interp_spline(coarse.time, coarse.positions, 1)
    away = [arm.chain.poses(positions(times))[..., 3] for positions in (polynomial, straight)]
    farthest = float(np.linalg.norm(away[0] - away[1], axis=-1).max())
    bound = between_points._departure(
        arm, between_points._polynomials(coarse_plan, coarse_plan, slice(None))
    )
    assert 1e-4 < farthest <= bound < 0.2


@pytest.mark.parametrize("samples", [3, 11, None])
def test_poses_of_the_papers_arm_are_marked_where_straight_ways_between_them_leave_its_curve(
    samples: int | None,
) -> None:
    scene = abi.load_scene("arm-in-the-way")
    motion = scene.motion.model_copy(update={"samples": samples})
    plan = abi.plan(scene.model_copy(update={"motion": motion}))
    fine = abi.plan(scene)
    assert plan.arm is not None
    assert plan.motion is not None
    assert fine.motion is not None
    assert plan.arm_clearance is not None
    assert plan.arm_clearance.certified
    straight = np.stack(
        [np.interp(fine.motion.time, plan.motion.time, q) for q in plan.motion.positions.T], axis=1
    )
    apart = plan.arm.place(straight) - plan.arm.place(fine.motion.positions)
    away = np.linalg.norm(apart, axis=-1).max()
    marked = joint_trajectory.is_marked(plan)
    assert marked == (samples is not None)
    assert marked or away < plan.arm_clearance.distance
    assert ("NOT proven clear" in joint_trajectory.motion_state(plan)) == marked


@pytest.mark.parametrize(("samples", "enough"), [(5, False), (101, True)])
def test_of_the_papers_arm_what_is_left_out_between_poses_counts_too(
    samples: int, enough: bool
) -> None:
    scene = abi.load_scene("drag-a-box")
    plan, dense = (
        abi.plan(scene.replace(motion={"samples": count})) for count in (samples, 16 * samples)
    )
    motion, true, arm, clearance = plan.motion, dense.motion, plan.arm, plan.arm_clearance
    assert motion is not None
    assert true is not None
    assert arm is not None
    assert clearance is not None
    assert clearance.certified
    assert (between_points.rows_warning(plan) == "") == enough
    assert between_points.polynomials_are_clear(plan) == enough

    values = np.stack([motion.positions, motion.joint_velocities, motion.joint_accelerations], 1)
    ways = (
        scipy.interpolate.BPoly.from_derivatives(motion.time, values),
        scipy.interpolate.make_interp_spline(motion.time, motion.positions, 1),
    )
    there = arm.place(true.positions)
    moves = between_points._polynomials(plan, plan, slice(None))
    bound = between_points._from_curve(plan) + between_points._departure(arm, moves)
    for way in ways:
        away = float(np.linalg.norm(there - arm.place(way(true.time)), axis=-1).max())
        assert 0 < away <= bound
