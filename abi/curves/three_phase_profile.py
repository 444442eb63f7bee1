"""Stage 5, the motion: three phases of constant acceleration along a length, and Theorem 1."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from abi import arguments
from abi.arrays import FloatArray, clip
from abi.errors import SceneError


@dataclass(frozen=True, eq=False)
class ThreePhaseProfile:
    """Motion from rest to rest: speeding up, cruising, slowing down.

    The distance travelled is the area of a trapezoid (paper, stage 5), or of a triangle if the
    length is too short to reach the speed.

    Attributes:
        length: distance to travel, [unit].
        speed: largest allowed, V, [unit/s].
        acceleration: of the first phase, a1 > 0, [unit/s²].
        deceleration: magnitude in the third phase, abs(a3) > 0, [unit/s²].
        t1, t2, t3: durations of the phases, [s].
        peak_speed: the speed reached, at most ``speed``, [unit/s].
        triangular: whether the cruise is missing because ``speed`` is not reached.
    """

    length: float
    speed: float
    acceleration: float
    deceleration: float
    t1: float
    t2: float
    t3: float
    peak_speed: float
    triangular: bool

    @property
    def duration(self) -> float:
        """Time of the whole motion, [s]."""
        return self.t1 + self.t2 + self.t3

    @property
    def jumps(self) -> FloatArray:
        """Times at which the acceleration jumps, [s]."""
        return np.array([0.0, self.t1, self.t1 + self.t2, self.duration])

    @property
    def theorem_residual(self) -> float:
        """Theorem 1 of the paper, t1 = t3·abs(a3 / a1): left side minus right, [s]."""
        return self.t1 - self.t3 * abs(self.deceleration / self.acceleration)

    def __call__(self, time: ArrayLike, order: int = 0) -> FloatArray:
        """Distance travelled, or its derivative by time.

        Args:
            time: [s], a number or any shape; before 0 and after the duration the motion rests.
            order: 0 distance, 1 speed, 2 acceleration (where it jumps, that of the later phase,
                at the duration -abs(a3)), 3 and above 0.

        Returns:
            [unit/s**order], in the shape given.
        """
        given = arguments.number_or_numbers("time", time)
        t = clip(given, 0.0, self.duration)
        left = self.duration - t
        speeding, cruising = t < self.t1, left > self.t3
        if order == 0:
            first = self.acceleration / 2 * t**2
            middle = self.peak_speed * (t - self.t1 / 2)
            last = self.length - self.deceleration / 2 * left**2
            travelled = np.where(speeding, first, np.where(cruising, middle, last))
            return clip(travelled, 0.0, self.length)
        if order == 1:
            slowing = self.deceleration * left
            speed = np.where(cruising, self.peak_speed, slowing)
            speed = np.where(speeding, self.acceleration * t, speed)
            return np.asarray(np.minimum(speed, self.peak_speed))
        if order == 2:
            value = np.where(cruising, 0.0, -self.deceleration)
            value = np.where(speeding, self.acceleration, value)
            return np.where(given == t, value, 0.0)
        return np.zeros_like(t)

    def time_at(self, distance: ArrayLike) -> FloatArray:
        """Time at which a distance has been travelled, [s].

        Args:
            distance: [unit], a number or any shape; clamped to the length.
        """
        travelled = np.clip(arguments.number_or_numbers("distance", distance), 0.0, self.length)
        left = self.length - travelled
        first, last = self.peak_speed * self.t1 / 2, self.peak_speed * self.t3 / 2
        speeding = np.sqrt(2 * travelled / self.acceleration)
        slowing = self.duration - np.sqrt(2 * left / self.deceleration)
        speed = self.peak_speed or 1.0
        cruising = self.t1 + (travelled - first) / speed
        return np.asarray(
            np.where(travelled < first, speeding, np.where(left > last, cruising, slowing))
        )


# one object for equal motions: what follows from it need not be made again
@lru_cache(maxsize=64)
def three_phase(
    length: float, speed: float, acceleration: float, deceleration: float
) -> ThreePhaseProfile:
    """Fastest motion from rest to rest along a length under a speed and two accelerations.

    With V = a1·t1 = a3·t3 the trapezoid's area is (t1 + 2·t2 + t3)·V / 2 = length (paper, stage 5);
    t2 would be negative when V² (1/a1 + 1/a3) / 2 > length. Then t2 = 0 and the peak speed is
    sqrt(2·length·a1·a3 / (a1 + a3)).

    Args:
        length: distance to travel, [unit], at least 0.
        speed: largest speed, V, [unit/s], above 0.
        acceleration: a1, [unit/s²], above 0.
        deceleration: abs(a3), [unit/s²], above 0.

    Raises:
        SceneError: a number is not finite or not in its range.
    """
    if not (math.isfinite(length) and length >= 0):
        raise SceneError("length", length, "a number from 0 up")
    rates = {"speed": speed, "acceleration": acceleration, "deceleration": deceleration}
    for name, value in rates.items():
        if not (math.isfinite(value) and value > 0):
            raise SceneError(f"motion.{name}", value, "a number above 0")
    mean_slowness = (1 / acceleration + 1 / deceleration) / 2
    triangular = speed * speed * mean_slowness > length
    peak = min(speed, math.sqrt(length / mean_slowness)) if triangular else speed
    return ThreePhaseProfile(
        length=length,
        speed=speed,
        acceleration=acceleration,
        deceleration=deceleration,
        t1=peak / acceleration,
        t2=0.0 if triangular else (length - speed * speed * mean_slowness) / speed,
        t3=peak / deceleration,
        peak_speed=peak,
        triangular=triangular,
    )
