"""Motion along a curve by the law that a scene chooses, and the table of laws.

A new law is a function in a file here or, where
it knows nothing of joints, beside :mod:`abi.curves.three_phase_profile`; and an entry in the table.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

import numpy as np

from abi import arguments
from abi.arm_planning.branch.arm_branch import JointPath
from abi.arrays import FloatArray, flat, read_only
from abi.curves.cubic_profile import (
    CubicProfile,
    PathProfile,
    from_squared_speeds,
    jerk_limited,
)
from abi.curves.three_phase_profile import three_phase
from abi.curves.time_optimal_kernels import fastest_speeds
from abi.errors import ArgumentError
from abi.scene.settings import Law, MotionSettings

_GRID = 3201
"""Points of the curve at which the joints are computed."""
ROUNDING = 1.001
"""Factor by which differences of samples may be too large or too small."""
_ROUNDS, _SETTLED = 5, 1e-6
"""Most times that a motion is slowed down, as q5 then slides farther, and the excess that counts as
none."""


Slowed = Callable[[float], PathProfile]
"""Function that makes a law's motion a factor >= 1 slower than the fastest one."""


@dataclass(frozen=True)
class MotionLaw:
    """A law of motion along a curve, from rest to rest.

    Attributes:
        name: in scene files.
        label: its name on the page.
        meaning: what it does, in the words of the documentation.
        slowed: the motions along a path under the settings, by how many times as long they take.
        uses: the settings of the motion that it reads.
        keeps_limits: whether it keeps the limits of the joints that the inverse kinematics moves.
    """

    name: Law
    label: str
    meaning: str
    slowed: Callable[[JointPath, MotionSettings], Slowed]
    uses: frozenset[str]
    keeps_limits: bool = True


def motion_law(path: JointPath, settings: MotionSettings) -> PathProfile:
    """Motion from rest to rest along a curve.

    All laws but the paper's three phases limit the speeds and accelerations of the joints that the
    inverse kinematics moves; for the paper's arm these are q1 to q3, while q5 slides.

    Args:
        path: joints along the curve.
        settings: law, speeds and accelerations.
    """
    law = LAWS[settings.law]
    slowed = law.slowed(path, settings)
    limits = path.rate_limits(settings.joint_acceleration)
    factor = _slowing(slowed, path, *limits) if law.keeps_limits else 1.0
    if settings.time_step is None:
        return slowed(factor)
    return slowed(factor * _to_whole_steps(slowed(factor).duration, settings.time_step))


def _slowing(
    slowed: Slowed, path: JointPath, speeds: FloatArray, accelerations: FloatArray
) -> float:
    """Factor, at least 1, by which a motion takes longer so that the joints' limits hold."""
    factor = 1.0
    for _ in range(_ROUNDS if path.is_timed else 1):
        excess = _excess(slowed(factor), path, speeds, accelerations)
        factor *= excess
        if excess <= 1 + _SETTLED:
            break
    return factor


def _to_whole_steps(duration: float, step: float) -> float:
    """Factor, at least 1, by which a motion takes longer so that it ends with a time step."""
    steps = max(math.ceil(duration / step - 1e-9), 2)
    return steps * step / duration if duration > 0 else 1.0


def _three_phases(path: JointPath, settings: MotionSettings) -> Slowed:
    rates = settings.speed, settings.acceleration, settings.deceleration
    return partial(_slowed, path.length, rates)


def _smooth(path: JointPath, settings: MotionSettings) -> Slowed:
    gentle = min(settings.acceleration, settings.deceleration)
    return jerk_limited(path.length, settings.speed, gentle, settings.jerk).stretched


def _fastest(path: JointPath, settings: MotionSettings) -> Slowed:
    return _time_optimal(path, *path.rate_limits(settings.joint_acceleration)).stretched


def _slowed(length: float, rates: tuple[float, float, float], factor: float) -> PathProfile:
    """Three phases slowed down by ``factor``."""
    # a triangle's peak scales by itself: its speed is not reached
    return three_phase(length, rates[0] / factor, rates[1] / factor**2, rates[2] / factor**2)


def second_derivatives(positions: FloatArray, step: float) -> FloatArray:
    """Second differences of positions (k, n) in equal steps, k >= 3; at the ends as beside them."""
    positions = arguments.numbers("positions", positions, (-1, -1))
    if len(positions) < 3:
        raise ArgumentError("number of positions", len(positions), "3 or more")
    inner = np.diff(positions, 2, axis=0) / step**2
    return np.concatenate([inner[:1], inner, inner[-1:]])


def _excess(
    profile: PathProfile, path: JointPath, speeds: FloatArray, accelerations: FloatArray
) -> float:
    """Factor, at least 1, by which a motion is to be slowed so that the limits hold.

    The speeds and accelerations are differences of many samples.
    """
    times = np.linspace(0.0, profile.duration, 2 * _GRID)
    positions = path.at(profile(times), times)
    step = float(times[1])
    faster = float((np.abs(np.diff(positions, axis=0)) / step / speeds).max())
    rates = np.abs(second_derivatives(positions, step))
    harder = float((rates / accelerations).max())
    return max(1.0, faster * ROUNDING, math.sqrt(harder * ROUNDING))


def _time_optimal(path: JointPath, speeds: FloatArray, accelerations: FloatArray) -> CubicProfile:
    """Fastest motion along the curve under the joints' limits."""
    length = path.length
    distances = np.linspace(0.0, length, _GRID)
    joints = path.at(distances)
    squared, sets = np.zeros(len(joints)), np.zeros(2 * len(joints))
    step = float(distances[1])
    first = np.gradient(joints, step, axis=0, edge_order=2)
    rates = flat(first), flat(second_derivatives(joints, step))
    bounds = flat(speeds), flat(accelerations)
    failed = fastest_speeds(*rates, step, *bounds, sets, squared)
    assert failed < 0, "standing still is always possible"
    # rest within the path would take for ever: such points are passed slowly
    slowest = 1e-6 * float(squared.max())
    squared[1:-1] = np.maximum(squared[1:-1], slowest)
    return from_squared_speeds(length, read_only(distances), squared)


_OF_THE_TOOL = frozenset({"speed", "acceleration", "deceleration"})
LAWS: Mapping[str, MotionLaw] = MappingProxyType(
    {
        one.name: one
        for one in (
            MotionLaw(
                "three_phase",
                "three phases",
                "the paper's, which considers the tool tip alone",
                _three_phases,
                _OF_THE_TOOL,
                keeps_limits=False,
            ),
            MotionLaw(
                "slowed",
                "three phases, joints in limits",
                "the same, slowed down until the joints' limits hold",
                _three_phases,
                _OF_THE_TOOL | {"joint_acceleration"},
            ),
            MotionLaw(
                "time_optimal",
                "as fast as joints allow",
                "the fastest within these limits",
                _fastest,
                frozenset({"joint_acceleration"}),
            ),
            MotionLaw(
                "jerk_limited",
                "smooth (limited jerk)",
                "with limited jerk, too",
                _smooth,
                _OF_THE_TOOL | {"joint_acceleration", "jerk"},
            ),
        )
    }
)
"""The laws by name, in the order in which the page and the documentation list them."""
