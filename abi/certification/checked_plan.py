"""A motion from elsewhere as a plan with stage 6 only, to be shown like other plans."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from abi.arm_planning.certificates.separate_paper_arm_kernels import Slide
from abi.arm_planning.motion.arm_clearance import ArmClearance
from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arrays import FloatArray, read_only
from abi.certification.clearance_proof import nearest
from abi.certification.verdict import MotionVerdict
from abi.curves.bspline import clamped
from abi.curves.cubic_profile import CubicProfile
from abi.planner.plan import Plan
from abi.robot.bodies.finer_links import fitted_capsules
from abi.robot.urdf_arm import UrdfArm, urdf_arm
from abi.scene.scene import Scene

SAMPLES = 401
"""Number of poses at which the motion is shown."""
_MEASURED = 5
"""Samples between two at which distances are measured."""


def checked_plan(verdict: MotionVerdict) -> Plan:
    """The plan of a motion that was checked: the arm, its motion and its clearance alone.

    Args:
        verdict: on the motion, whose first waypoint is at 0 s.
    """
    arm = _arm(verdict)
    motion = _motion(verdict, arm)
    duration = float(motion.time[-1])
    # the time itself is the distance: nothing else is known of how it was timed
    pace = read_only(np.array([[0.0], [0.0], [1.0], [0.0]]))
    profile = CubicProfile(duration, read_only(np.array([0.0, duration])), pace)
    clearance = _clearance(verdict, motion)
    return Plan(verdict.scene, profile=profile, arm=arm, motion=motion, arm_clearance=clearance)


def _arm(verdict: MotionVerdict) -> UrdfArm:
    """The scene's arm with all joints that the motion moves, including a second arm's."""
    scene: Scene = verdict.scene
    settings, chain = scene.arm, verdict.problem.motion.chain
    stands = settings.base, settings.exact_axis, scene.unit, settings.base_wxyz
    arm = urdf_arm(settings.robot, settings.tool, *stands, settings.gripper, settings.allowed)
    if {*chain.names} <= {*arm.joints}:
        return arm
    scales = np.where(np.array(chain.slides), 1 / arm.metres, 1.0)
    return replace(
        arm,
        chain=chain,
        limits=read_only(chain.limits * scales[:, None]),
        capsules=fitted_capsules(chain),
        held=chain.held,
    )


def _motion(verdict: MotionVerdict, arm: UrdfArm) -> ArmMotion:
    """The motion at equal times."""
    moved = verdict.problem.motion
    times = moved.motion.times
    time = np.linspace(0.0, float(times[-1]), SAMPLES)
    at = np.interp(time, times, np.arange(float(len(times))))
    values = [_of_arm(values, verdict, arm) for values in moved.rates_at(at)]
    positions, speeds, growths = values
    tool = _tool(verdict, positions, arm)
    points, nothing = read_only(tool), read_only(np.zeros(2))
    limits = [
        one
        for one in verdict.limits.passed
        if one.quantity == "position" and one.joint in arm.joints
    ]
    return ArmMotion(
        curve=clamped(points, 1),
        elbow="up",
        slide=Slide(nothing, nothing, nothing),
        time=read_only(time),
        positions=read_only(positions),
        target=points,
        tool=points,
        tool_velocity=read_only(np.gradient(tool, time, axis=0)),
        shortfall=read_only(np.zeros(len(time))),
        limit_violations=tuple(limits),
        peak_joint_speed=read_only(np.abs(speeds).max(axis=0)),
        joints=arm.joints,
        slides=arm.chain.slides,
        rates=(read_only(speeds), read_only(growths)),
    )


def _of_arm(values: FloatArray, verdict: MotionVerdict, arm: UrdfArm) -> FloatArray:
    """Columns (k, n) of the joints of an arm, in its unit; 0 of those that are not named."""
    names = verdict.problem.motion.chain.names
    found = np.zeros((len(values), len(arm.joints)))
    for column, name in enumerate(arm.joints):
        if name in names:
            found[:, column] = values[:, names.index(name)]
    return np.asarray(found * arm.scales)


def _tool(verdict: MotionVerdict, positions: FloatArray, arm: UrdfArm) -> FloatArray:
    """Positions of the tip (k, 3), [unit], world."""
    chain = arm.chain
    frame, origin = chain.frames[arm.tip], chain.places[arm.tip][:3, 3]
    if frame < 0:
        return np.tile(origin / arm.metres, (len(positions), 1))
    frames = chain.poses(positions / arm.scales)[:, frame]
    places = frames[:, :, :3] @ origin + frames[:, :, 3]
    return np.asarray(places / arm.metres)


def _clearance(verdict: MotionVerdict, motion: ArmMotion) -> ArmClearance:
    """What the verdict says of the distance, and distances at samples."""
    times = verdict.problem.motion.motion.times
    at = np.interp(motion.time[::_MEASURED], times, np.arange(float(len(times))))
    few = [nearest(verdict.problem, at[k : k + 1])[0] for k in range(len(at))]
    distances = np.interp(motion.time, motion.time[::_MEASURED], few)
    link, obstacle, time = verdict.nearest or ("", -1, 0.0)
    return ArmClearance(
        distances=read_only(distances),
        required=0.0,
        distance=verdict.clearance,
        time=time,
        link=link,
        obstacle=obstacle,
        contacts=tuple(sorted(verdict.touches, key=lambda one: -one.depth)),
        certificate=None,
        has_verdict=verdict.state == "clear",
    )
