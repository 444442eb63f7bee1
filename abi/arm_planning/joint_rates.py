"""Speeds, accelerations and torques of the joints along a motion, and their limits."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from abi.arm_planning.motion.trajectory import ArmMotion, Quantity, Violation
from abi.arm_planning.motion_law import ROUNDING, second_derivatives
from abi.arrays import FloatArray, ShortRepr, read_only
from abi.robot.any_arm import AnyArm


@dataclass(frozen=True, eq=False, repr=False)
class JointRates(ShortRepr):
    """Speeds, accelerations and torques of the n joints at the m samples of a motion.

    They are differences of the samples, and but for the paper's arm those at the ends are from rest
    and to it: of a bend that the tool passes in less than two of them they show only part of the
    acceleration.

    Attributes:
        speeds: shape (m, n), [rad/s] or [unit/s].
        accelerations: shape (m, n), [rad/s²] or [unit/s²].
        torques: shape (m, n), [N·m], of sliding joints forces [N]; None where no masses are known.
        speed_limits: (n,), inf where there is none.
        acceleration_limits: those that the scene asks for, (n,), inf where there is none.
        torque_limits: (n,), inf where there is none.
        nominal: whether these limits are assumed, and so none is passed.
    """

    speeds: FloatArray
    accelerations: FloatArray
    torques: FloatArray | None
    speed_limits: FloatArray
    acceleration_limits: FloatArray
    torque_limits: FloatArray
    nominal: bool


def joint_rates(arm: AnyArm, motion: ArmMotion, acceleration: float) -> JointRates:
    """Compute speeds and accelerations as differences of the samples, and the torques needed.

    A motion whose rates are known brings them along.

    The paper gives masses only for its arm's last three drives, so that arm has no torques; the
    speed limit of its turning joints is nominal.

    Args:
        arm: the arm.
        motion: its motion, at three samples or more.
        acceleration: largest of each joint, [rad/s²], of sliding ones [m/s²].
    """
    step = float(motion.time[1] - motion.time[0])
    if motion.rates is not None:
        speeds, growths = motion.rates
    elif step > 0:
        speeds = np.gradient(motion.positions, step, axis=0)
        # the drives of the paper's arm are pushed until the end, where they do not rest
        rests = not arm.has_nominal_rates
        growths = (_from_rest if rests else second_derivatives)(motion.positions, step)
    else:
        speeds = growths = np.zeros_like(motion.positions)
    torques = arm.torques(motion.positions, speeds, growths)
    most_speed, most_acceleration, most_torque = arm.rate_limits(acceleration)
    return JointRates(
        read_only(speeds),
        read_only(growths),
        None if torques is None else read_only(torques),
        read_only(most_speed),
        read_only(most_acceleration),
        read_only(most_torque),
        arm.has_nominal_rates,
    )


def passed_limits(motion: ArmMotion, rates: JointRates) -> tuple[Violation, ...]:
    """Find every joint that passes a limit of its speed, acceleration or torque, where it is worst.

    Its speed at a sample is that on the straight ways to those beside it where they are faster.
    The paper gives its arm no such limits, and those in ``rates`` are nominal: it passes none.

    Args:
        motion: the motion, at m samples.
        rates: the joints' rates there.
    """
    found: list[Violation] = []
    if rates.nominal:
        return ()
    limited: tuple[tuple[Quantity, FloatArray | None, FloatArray], ...] = (
        ("speed", _with_steps(motion, rates.speeds), rates.speed_limits),
        ("acceleration", rates.accelerations, rates.acceleration_limits),
        ("torque", rates.torques, rates.torque_limits),
    )
    for quantity, values, limits in limited:
        if values is None:
            continue
        past = np.abs(values) > limits * ROUNDING
        for joint in np.flatnonzero(past.any(axis=0)).tolist():
            worst, first = int(np.abs(values[:, joint]).argmax()), int(past[:, joint].argmax())
            value = float(values[worst, joint])
            limit = math.copysign(float(limits[joint]), value)
            times = float(motion.time[worst]), float(motion.time[first])
            name = motion.joints[joint]
            found.append(Violation(name, times[0], value, limit, times[1], quantity))
    return tuple(found)


def _with_steps(motion: ArmMotion, speeds: FloatArray) -> FloatArray:
    """Speeds (m, n), or those to the next sample or from the last one where these are larger."""
    times = np.diff(motion.time)[:, None]
    if not (times > 0).all():
        return speeds
    between = np.diff(motion.positions, axis=0) / times
    for beside in ([between[:1], between], [between, between[-1:]]):
        steps = np.concatenate(beside)
        speeds = np.where(np.abs(steps) > np.abs(speeds), steps, speeds)
    return speeds


def _from_rest(positions: FloatArray, step: float) -> FloatArray:
    """Accelerations (m, n) of positions in equal steps, at both ends as from rest where larger.

    Whoever goes so far from rest in a step has that acceleration somewhere on it.
    """
    growths = second_derivatives(positions, step)
    for end, beside in ((0, 1), (-1, -2)):
        needed = 2 * (positions[beside] - positions[end]) / step**2
        growths[end] = np.where(np.abs(needed) > np.abs(growths[end]), needed, growths[end])
    return growths
