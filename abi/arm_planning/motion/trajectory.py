"""Stage 6, the motion of the arm: a curve, the timing along it, and the joint positions.

q1, q2 and q3 come from the inverse kinematics of the tool's position; q4, q5 and q6 from the
constant generalised forces of their drives.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from abi.arm_planning.arm_errors import out_of_reach
from abi.arm_planning.certificates.paper_arm_certificate import slide_bounds
from abi.arm_planning.certificates.separate_paper_arm_kernels import Slide
from abi.arm_planning.motion.tool_motion import tool_samples
from abi.arm_planning.wrist_drives import wrist_positions
from abi.arrays import FloatArray, ShortRepr, read_only
from abi.curves.cubic_profile import PathProfile
from abi.curves.curve import ArcLength, Curve
from abi.errors import StageError
from abi.obstacles.pose import Vec3
from abi.robot.paper_arm.inverse_kinematics import solve
from abi.robot.paper_arm.paper_arm import JOINTS, SLIDES, PaperArm, forward
from abi.scene.arm_settings import ArmSettings

Quantity = Literal["position", "speed", "acceleration", "torque"]
"""A quantity of a joint that is limited."""


class Violation(NamedTuple):
    """A joint past one of its limits, in the unit of that quantity.

    Attributes:
        joint: name of the joint.
        time: time at which it is farthest past the limit, [s].
        value: its value then; of a position [rad], or [unit] if the joint slides.
        limit: the limit, on the side that is passed.
        since: time at which it passes the limit, [s]; of a motion that was planned elsewhere
            ``time``.
        quantity: what is limited.
    """

    joint: str
    time: float
    value: float
    limit: float
    since: float
    quantity: Quantity = "position"


@dataclass(frozen=True, eq=False, repr=False)
class ArmMotion(ShortRepr):
    """The arm's motion, sampled uniformly in time.

    Attributes:
        curve: the path of the tool.
        elbow: branch of the inverse kinematics.
        slide: bounds of q5 along the path.
        time: shape (m,), [s].
        positions: joint positions, shape (m, 6), [rad], q5 [unit].
        target: point of the curve, shape (m, 3), [unit], world.
        tool: position of the tool, shape (m, 3), [unit], world; off the target only out of reach.
        tool_velocity: velocity of the target, shape (m, 3), [unit/s], world.
        shortfall: distance by which each sample is out of reach, shape (m,), [unit]: > 0 too far, <
            0 too near to the shoulder.
        limit_violations: one for each joint whose position passes a limit, where it is farthest
            past it.
        peak_joint_speed: largest mean speed between two samples, shape (6,), [rad/s], q5 [unit/s].
        joints: names of the joints.
        slides: which of them slide, so that their positions are lengths.
        rates: speeds and accelerations of the joints at the samples, (m, n) each, where they are
            known better than by differences; else None.
    """

    curve: Curve
    elbow: Literal["up", "down"]
    slide: Slide
    time: FloatArray
    positions: FloatArray
    target: FloatArray
    tool: FloatArray
    tool_velocity: FloatArray
    shortfall: FloatArray
    limit_violations: tuple[Violation, ...]
    peak_joint_speed: FloatArray
    joints: tuple[str, ...] = JOINTS
    slides: tuple[bool, ...] = SLIDES
    rates: tuple[FloatArray, FloatArray] | None = None

    @property
    def reachable(self) -> bool:
        """Whether every sample is within reach."""
        return not self.shortfall.any()

    @cached_property
    def joint_velocities(self) -> FloatArray:
        """Velocities of the joints, (m, n), [rad/s] or [unit/s].

        Where they are not known better, by differences, and 0 at both ends.
        """
        if self.rates is not None:
            return self.rates[0]
        if not self.time[-1] > 0:
            return read_only(np.zeros_like(self.positions))
        velocities = np.gradient(self.positions, self.time, axis=0, edge_order=2)
        velocities[[0, -1]] = 0.0
        return read_only(velocities)

    @cached_property
    def joint_accelerations(self) -> FloatArray:
        """Accelerations of the joints, (m, n), [rad/s²] or [unit/s²].

        Where they are not known better, by differences.
        """
        if self.rates is not None:
            return self.rates[1]
        if not self.time[-1] > 0:
            return read_only(np.zeros_like(self.positions))
        velocities = np.gradient(self.positions, self.time, axis=0, edge_order=2)
        return read_only(np.gradient(velocities, self.time, axis=0, edge_order=2))

    @property
    def within_limits(self) -> bool:
        """Whether no joint's position passes a limit."""
        return not self.limit_violations

    @property
    def slide_at_fault(self) -> Violation | None:
        """Where q5 passes its limit before the worst stretch out of reach ends; None if nowhere."""
        if self.reachable or self.joints != JOINTS:
            return None
        last = float(self.time[self._worst_samples][-1])
        slides = (one for one in self.limit_violations if one.joint == "q5")
        return next((one for one in slides if one.since <= last), None)

    @cached_property
    def _worst_samples(self) -> slice:
        """Samples around the one that is farthest out of reach, all out of reach on its side."""
        worst, side = int(np.abs(self.shortfall).argmax()), np.sign(self.shortfall)
        others = np.flatnonzero(side != side[worst])
        first = int(others[others < worst].max(initial=-1)) + 1
        return slice(first, int(others[others > worst].min(initial=len(side))))

    @property
    def error(self) -> StageError | None:
        """Error for the worst stretch out of reach; None if there is none."""
        if self.reachable:
            return None
        first, last = self.time[self._worst_samples][[0, -1]].tolist()
        worst, past = float(max(self.shortfall, key=abs)), self.slide_at_fault
        if self.joints != JOINTS:
            return out_of_reach(first, last, worst, None)
        slide = None if past is None else (past.value, past.limit)
        return out_of_reach(first, last, abs(worst), worst < 0, slide)


def follow(
    curve: Curve,
    arc: ArcLength,
    profile: PathProfile,
    arm: PaperArm,
    settings: ArmSettings,
    samples: int = 200,
) -> ArmMotion:
    """Move the arm's tool along a curve.

    Args:
        curve: the path of the tool, [unit], world.
        arc: the curve's arc length.
        profile: the motion along it.
        arm: the arm.
        settings: elbow branch, for ``auto`` the upper one, and drives of the arm.
        samples: number of samples m, at least 2.

    Returns:
        The motion. It records what is out of reach or past a limit; nothing is raised.
    """
    time = np.linspace(0.0, profile.duration, samples)
    target, tangent, velocity = tool_samples(curve, arc, profile, time)
    wrist, elbow = wrist_positions(settings, time), settings.branches[0]
    solved, shortfall = solve(arm, target, wrist[:, 1], elbow, tangent)
    positions = np.concatenate([solved, wrist], axis=1)
    step = profile.duration / (samples - 1)
    largest = np.abs(np.diff(positions, axis=0)).max(axis=0)
    return ArmMotion(
        curve=curve,
        elbow=elbow,
        slide=slide_bounds(curve, arc, profile, settings),
        time=read_only(time),
        positions=read_only(positions),
        target=read_only(target),
        tool=read_only(forward(arm, positions)),
        tool_velocity=read_only(velocity),
        shortfall=read_only(shortfall),
        limit_violations=_violations(time, positions.T, arm.limits),
        peak_joint_speed=read_only(largest / step if step > 0 else np.zeros(6)),
    )


def rest_pose(arm: PaperArm, settings: ArmSettings, point: Vec3) -> FloatArray:
    """Joint positions with the tool at ``point``, or as near as it can be.

    Returns:
        Shape (6,), [rad], q5 [unit].
    """
    q5 = np.array([settings.q5])
    joints, _ = solve(arm, np.array([point]), q5, settings.branches[0], np.zeros((1, 3)))
    return read_only(np.array([*joints[0], 0.0, settings.q5, 0.0]))


def _violations(time: FloatArray, joints: FloatArray, limits: FloatArray) -> tuple[Violation, ...]:
    """Violation of each of the ``joints`` (6, m) that passes a limit, where it is worst."""
    tolerance = 1e-9 * (1 + np.abs(limits).max(axis=1))
    low, high = limits[:, 0] - joints.min(axis=1), joints.max(axis=1) - limits[:, 1]
    violations = []
    for joint in np.flatnonzero(np.maximum(low, high) > tolerance):
        side = 0 if low[joint] > high[joint] else 1
        beyond = (joints[joint] - limits[joint, side]) * (-1 if side == 0 else 1)
        worst, first = int(beyond.argmax()), int((beyond > tolerance[joint]).argmax())
        value, limit = float(joints[joint, worst]), float(limits[joint, side])
        at, since = float(time[worst]), float(time[first])
        violations.append(Violation(JOINTS[joint], at, value, limit, since))
    return tuple(violations)
