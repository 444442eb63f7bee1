"""Intervals of rational numbers, rounded outwards so that they stay short, for the arm's check."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from abi.verify.exact.solids import Vec3, sqrt_bounds

_ONE = 1 << 90


class Interval(NamedTuple):
    """All numbers from ``low`` to ``high``."""

    low: Fraction
    high: Fraction

    def plus(self, other: Interval) -> Interval:
        """Sum."""
        return enclose(self.low + other.low, self.high + other.high)

    def minus(self, other: Interval) -> Interval:
        """Difference."""
        return enclose(self.low - other.high, self.high - other.low)

    def times(self, other: Interval) -> Interval:
        """Product."""
        if self.low.numerator >= 0 and other.low.numerator >= 0:  # most are
            return enclose(self.low * other.low, self.high * other.high)
        ends = [a * b for a in self for b in other]
        return enclose(min(ends), max(ends))

    def over(self, other: Interval) -> Interval:
        """Quotient by an interval above 0."""
        assert other.low > 0
        return self.times(Interval(1 / other.high, 1 / other.low))

    def sqrt(self) -> Interval:
        """Square root of an interval that is not below 0."""
        low, high = max(self.low, Fraction(0)), max(self.high, Fraction(0))
        return enclose(sqrt_bounds(low)[0] if low else low, sqrt_bounds(high)[1] if high else high)

    @property
    def magnitude(self) -> Fraction:
        """Largest absolute value."""
        return max(abs(self.low), abs(self.high))


def enclose(low: Fraction, high: Fraction | None = None) -> Interval:
    """The interval, rounded outwards to a multiple of 2^-90."""
    top = low if high is None else high
    # with whole numbers, as products of fractions would be reduced first
    first = low.numerator * _ONE // low.denominator
    last = -(-top.numerator * _ONE // top.denominator)
    return Interval(Fraction(first, _ONE), Fraction(last, _ONE))


def rounded(point: Vec3) -> Vec3:
    """A point with short coordinates next to it."""
    x, y, z = (Fraction(round(value * (1 << 60)), 1 << 60) for value in point)
    return x, y, z
