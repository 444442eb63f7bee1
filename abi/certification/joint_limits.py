"""Limits of joints that a motion passes: of position, speed, acceleration and torque."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from abi.arm_planning.motion.trajectory import Quantity, Violation
from abi.arrays import FloatArray, ShortRepr, read_only
from abi.certification.robot_motion import RobotMotion
from abi.robot.kinematics.inverse_dynamics import has_masses, joint_torques

_ROUNDING = 1 + 1e-9
_SAMPLES, _STEP = 5, 0.05
"""Least number of places between two waypoints at which torques are computed, ends included, and
largest step of a joint between two of them, [rad] or [m]."""
_MOST_ROWS = 200_000
"""Places of a motion at most, beyond those at least."""
_NO_TERM = 1e-10
"""Coefficient that counts as none, over the largest: roots of rounding are anywhere."""


@dataclass(frozen=True, eq=False, repr=False)
class LimitsKept(ShortRepr):
    """Largest values of joints along a motion, and the limits that they exceed.

    Attributes:
        peaks: largest size of each joint's speed, acceleration and torque, (n,) each; None where it
            is not known: speeds without times, accelerations and torques of straight motions, whose
            speeds jump at waypoints, torques without masses or times.
        passed: limits that are passed, positions in [rad] or [m].
        judged: what is known and what a joint has a limit of; a position always is.
    """

    peaks: dict[Quantity, FloatArray | None]
    passed: tuple[Violation, ...]
    judged: tuple[Quantity, ...]

    def to_dict(self) -> dict[str, Any]:
        """Plain data: peaks, what was not judged, and what is passed."""
        return {
            "within": not self.passed,
            "passed": [
                {
                    "quantity": one.quantity,
                    "joint": one.joint,
                    "time": one.time,
                    "value": one.value,
                    "limit": one.limit,
                }
                for one in self.passed
            ],
            "peaks": {
                name: None if peak is None else peak.tolist() for name, peak in self.peaks.items()
            },
            "not_judged": [name for name in self.peaks if name not in self.judged],
        }


def joint_limits(motion: RobotMotion, acceleration: float | None = None) -> LimitsKept:
    """Find the limits that a motion passes; a continuous joint has none of its position.

    Positions, speeds and accelerations are polynomials, whose largest values are found at the roots
    of their derivatives; torques are computed at places so near that no joint moves by more than
    0.05 rad or m between them, up to 200,000 places.

    Args:
        motion: the motion.
        acceleration: largest of each joint, [rad/s²], of sliding ones [m/s²]; None for none.
    """
    chain, passed = motion.chain, list[Violation]()
    spans = np.diff(motion.motion.times)
    low, high = chain.limits.T
    kinds = {joint.name: joint.kind for joint in chain.joints}
    turns_on = np.array([kinds[name] == "continuous" for name in chain.names])
    middle, half = (low + high) / 2, np.where(turns_on, math.inf, (high - low) / 2)
    passed += _past(motion, "position", motion.points - middle, half, middle)
    speed = growth = None
    if motion.motion.timed:
        speed = _derivative(motion.points) / spans[:, None, None]
        passed += _past(motion, "speed", speed, chain.speeds)
        if motion.degree > 1:
            growth = _derivative(speed) / spans[:, None, None]
            most = math.inf if acceleration is None else acceleration
            passed += _past(motion, "acceleration", growth, np.full(len(low), most))
    torques = None
    if speed is not None and has_masses(chain):
        torques = _torques(motion, speed, growth)
        passed += _torques_past(motion, torques)
    peaks: dict[Quantity, FloatArray | None] = {
        "position": read_only(np.abs(motion.points).max(axis=(0, 1))),
        "speed": None if speed is None else _peak(speed),
        "acceleration": None if growth is None else _peak(growth),
        # what a straight motion needs at a constant speed may be too much, but is not all
        "torque": None
        if torques is None or growth is None
        else read_only(np.abs(torques).max(axis=(0, 1))),
    }
    limited = {
        "position": True,
        "speed": bool(np.isfinite(chain.speeds).any()),
        "acceleration": acceleration is not None,
        "torque": bool(np.isfinite(chain.efforts).any()),
    }
    judged = tuple(name for name, peak in peaks.items() if peak is not None and limited[name])
    return LimitsKept(peaks, tuple(passed), judged)


def _derivative(points: FloatArray) -> FloatArray:
    """Bézier points (k, degree, n) of the derivative by the share of the time."""
    return np.asarray((points.shape[1] - 1) * np.diff(points, axis=1))


def _extremes(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Shares of time (j,) and values (j,) of a Bézier polynomial where it may be largest."""
    degree = len(points) - 1
    shares = [0.0, 1.0]
    if degree > 1:
        slopes = _monomials(np.diff(points))
        slopes[np.abs(slopes) <= _NO_TERM * np.abs(slopes).max()] = 0
        slopes = np.trim_zeros(slopes, "b")
        if len(slopes) > 1:
            roots = np.polynomial.polynomial.polyroots(slopes)
            real = roots[np.abs(roots.imag) < 1e-9].real
            shares += real[(real > 0) & (real < 1)].tolist()
    at = np.array(shares)
    return at, np.polynomial.polynomial.polyval(at, _monomials(points))


def _monomials(points: FloatArray) -> FloatArray:
    """Coefficients of a Bézier polynomial in powers of the share of time."""
    degree = len(points) - 1
    differences, found = points, []
    for power in range(degree + 1):
        found.append(math.comb(degree, power) * float(differences[0]))
        differences = np.diff(differences)
    return np.array(found)


def _peak(points: FloatArray) -> FloatArray:
    """Largest size (n,) of polynomials (k, degree + 1, n)."""
    bounds = np.abs(points).max(axis=1)
    best = np.zeros(points.shape[2])
    for joint in range(points.shape[2]):
        for piece in np.argsort(-bounds[:, joint]).tolist():
            if bounds[piece, joint] <= best[joint]:
                break
            values = _extremes(points[piece, :, joint])[1]
            best[joint] = max(best[joint], float(np.abs(values).max()))
    return read_only(best)


def _past(
    motion: RobotMotion,
    quantity: Quantity,
    points: FloatArray,
    limits: FloatArray,
    middle: FloatArray | None = None,
) -> list[Violation]:
    """The worst place of each joint whose polynomials are larger than a limit.

    Args:
        motion: the motion.
        quantity: of what.
        points: Bézier points (k, degree + 1, n), about the middle between the limits.
        limits: largest size of each, (n,).
        middle: what is added to values and limits, (n,); None for 0.
    """
    found = []
    allowed = limits * _ROUNDING + 1e-9
    bounds = np.abs(points).max(axis=1)
    for joint in np.flatnonzero((bounds > allowed).any(axis=0)).tolist():
        worst, time = float(allowed[joint]), None
        for piece in np.flatnonzero(bounds[:, joint] > allowed[joint]).tolist():
            shares, values = _extremes(points[piece, :, joint])
            k = int(np.abs(values).argmax())
            if abs(values[k]) > abs(worst) or (time is None and abs(values[k]) > worst):
                worst, time = float(values[k]), motion.time_at(piece + float(shares[k]))
        if time is not None:
            shift = 0.0 if middle is None else float(middle[joint])
            limit = math.copysign(float(limits[joint]), worst) + shift
            name = motion.chain.names[joint]
            found.append(Violation(name, time, worst + shift, limit, time, quantity))
    return found


def _torques(motion: RobotMotion, speed: FloatArray, growth: FloatArray | None) -> FloatArray:
    """Torques at places between waypoints, (k, samples, n), where straight motions keep a speed."""
    ways = np.abs(np.diff(motion.points, axis=1)).sum(axis=1)
    wanted = math.ceil(float(ways.max()) / _STEP) + 1
    count = max(_SAMPLES, min(wanted, _MOST_ROWS // len(ways)))
    shares = np.linspace(0.0, 1.0, count)
    tables = [_values(motion.points, shares), _values(speed, shares)]
    tables.append(np.zeros_like(tables[0]) if growth is None else _values(growth, shares))
    rows = [table.reshape(-1, table.shape[2]) for table in tables]
    return joint_torques(motion.chain, *rows).reshape(tables[0].shape)


def _values(points: FloatArray, shares: FloatArray) -> FloatArray:
    """Values (k, s, n) of Bézier polynomials (k, degree + 1, n) at shares (s,)."""
    degree = points.shape[1] - 1
    weights = np.stack(
        [math.comb(degree, i) * shares**i * (1 - shares) ** (degree - i) for i in range(degree + 1)]
    )
    return np.asarray(np.einsum("is,kin->ksn", weights, points))


def _torques_past(motion: RobotMotion, torques: FloatArray) -> list[Violation]:
    """The worst place of each joint whose torque is larger than its limit."""
    found, limits = [], motion.chain.efforts
    for joint in np.flatnonzero((np.abs(torques) > limits * _ROUNDING).any(axis=(0, 1))).tolist():
        values = torques[:, :, joint]
        piece, sample = np.unravel_index(int(np.abs(values).argmax()), values.shape)
        value = float(values[piece, sample])
        time = motion.time_at(int(piece) + int(sample) / (values.shape[1] - 1))
        limit = math.copysign(float(limits[joint]), value)
        name = motion.chain.names[joint]
        found.append(Violation(name, time, value, limit, time, "torque"))
    return found
