"""Motions along a curve as piecewise polynomials of time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import ArrayLike

from abi import arguments
from abi.arrays import FloatArray, ShortRepr, read_only
from abi.curves.three_phase_profile import ThreePhaseProfile
from abi.errors import ArgumentError

_TINY = 1e-12


@dataclass(frozen=True, eq=False, repr=False)
class CubicProfile(ShortRepr):
    """Motion from rest to rest that never moves backwards.

    Attributes:
        length: distance to travel, [unit].
        breaks: times between the pieces, from 0, increasing, shape (k + 1,), [s].
        coefficients: of the distance in each piece, from the third power of the time since its
            break down, shape (4, k), [unit/s³] to [unit].
    """

    length: float
    breaks: FloatArray
    coefficients: FloatArray

    def __post_init__(self) -> None:
        breaks = arguments.numbers("breaks", self.breaks, (-1,))
        if len(breaks) < 2 or (np.diff(breaks) < 0).any():
            raise ArgumentError("breaks", breaks[:6].tolist(), "two times or more that ascend")
        coefficients = arguments.numbers("coefficients", self.coefficients, (4, len(breaks) - 1))
        length = arguments.number("length", self.length, 0.0)
        arguments.keep(self, length=length, breaks=breaks, coefficients=coefficients)

    @property
    def duration(self) -> float:
        """Time of the whole motion, [s]."""
        return float(self.breaks[-1])

    @property
    def jumps(self) -> FloatArray:
        """Times at which the acceleration may jump, [s]."""
        return self.breaks

    @cached_property
    def peak_speed(self) -> float:
        """The largest speed, [unit/s]."""
        a, b, c = self.coefficients[0], self.coefficients[1], self.coefficients[2]
        # it is least or largest where pieces meet, or where the acceleration vanishes within one
        inner = np.divide(-b, 3 * a, out=np.zeros_like(b), where=np.abs(a) > _TINY)
        inner = np.clip(inner, 0, np.diff(self.breaks))
        return float(max(self(self.breaks, 1).max(), ((3 * a * inner + 2 * b) * inner + c).max()))

    def stretched(self, factor: float) -> CubicProfile:
        """Slow the motion down, so that it takes ``factor`` times as long."""
        powers = factor ** np.array([-3.0, -2.0, -1.0, 0.0])[:, None]
        slower = read_only(self.coefficients * powers)
        return CubicProfile(self.length, read_only(self.breaks * factor), slower)

    def __call__(self, time: ArrayLike, order: int = 0) -> FloatArray:
        """Distance travelled, or its derivative by time.

        Args:
            time: [s], a number or any shape; before 0 and after the duration the motion rests.
            order: of the derivative; where it jumps, that of the later piece.

        Returns:
            [unit/s**order], in the shape given.
        """
        given = arguments.number_or_numbers("time", time)
        order = arguments.integer("order", order, 0, arguments.LARGEST_ID)
        t = np.clip(given, 0.0, self.duration)
        if order > 3:
            return np.zeros_like(t)
        curve = scipy.interpolate.PPoly(self.coefficients, self.breaks)
        value = np.asarray(curve(t, order))
        if order == 0:
            return np.asarray(np.clip(value, 0.0, self.length))
        if order == 1:
            return np.asarray(np.maximum(value, 0.0))
        return np.where(given == t, value, 0.0)


PathProfile = ThreePhaseProfile | CubicProfile
"""Distance along a curve as a function of time."""


def jerk_limited(length: float, speed: float, acceleration: float, jerk: float) -> CubicProfile:
    """Fastest motion from rest to rest under a speed, an acceleration and a jerk.

    Seven pieces of constant jerk, some of which may take no time (Biagiotti and Melchiorri,
    Trajectory Planning for Automatic Machines and Robots, 2008, section 3.4).

    Args:
        length: distance to travel, [unit], above 0.
        speed: largest, [unit/s].
        acceleration: largest, of either sign, [unit/s²].
        jerk: largest, of either sign, [unit/s³].
    """
    top = _top_speed(length, speed, acceleration, jerk)
    # of the change of the acceleration, of its stay at the largest, and at the top speed
    change = min(acceleration / jerk, math.sqrt(top / jerk))
    stay = max(top / (jerk * change) - change, 0.0)
    cruise = max(length / top - 2 * change - stay, 0.0)
    durations = np.array([change, stay, change, cruise, change, stay, change])
    jerks = jerk * np.array([1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0])
    kept = durations > _TINY * (length / speed)
    durations, jerks = durations[kept], jerks[kept]
    rates = np.zeros((3, len(jerks) + 1))
    for k, (t, j) in enumerate(zip(durations, jerks, strict=True)):
        a, v, d = rates[:, k]
        rates[:, k + 1] = a + j * t, v + (a + j * t / 2) * t, d + (v + (a + j * t / 3) * t / 2) * t
    a, v, d = rates[:, :-1]
    breaks = np.concatenate([[0.0], np.cumsum(durations)])
    coefficients = np.stack([jerks / 6, a / 2, v, d])
    return CubicProfile(length, read_only(breaks), read_only(coefficients))


def _top_speed(length: float, speed: float, acceleration: float, jerk: float) -> float:
    """Largest speed that the motion reaches, [unit/s]."""
    change = acceleration / jerk
    # at half the length, the acceleration having stayed at its largest for a while
    long_way = acceleration * (math.sqrt(change**2 + 4 * length / acceleration) - change) / 2
    short_way = jerk * (length / (2 * jerk)) ** (2 / 3)
    return min(speed, long_way if long_way >= acceleration * change else short_way)


def from_squared_speeds(length: float, distances: FloatArray, squared: FloatArray) -> CubicProfile:
    """The motion with constant acceleration between given distances, from the speeds there.

    Args:
        length: distance to travel, [unit].
        distances: from 0 to the length, increasing, shape (k,), [unit].
        squared: squares of the speeds there, 0 at both ends and above between them, (k,).

    Raises:
        ArgumentError: no such distances or squares.
    """
    distances = arguments.increasing("distances", distances)
    squared = arguments.within("squared", squared, distances.shape, 0.0, math.inf)
    steps = np.diff(distances)
    speeds = np.sqrt(squared)
    both = speeds[:-1] + speeds[1:]
    if not both.all():
        raise ArgumentError("squared", squared.tolist(), "numbers above 0 between the ends")
    times = 2 * steps / both
    accelerations = np.diff(squared) / (2 * steps)
    breaks = np.concatenate([[0.0], np.cumsum(times)])
    coefficients = np.stack([np.zeros_like(steps), accelerations / 2, speeds[:-1], distances[:-1]])
    return CubicProfile(length, read_only(breaks), read_only(coefficients))
