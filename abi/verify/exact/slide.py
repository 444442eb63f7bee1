"""Bounds of the arm's slide q5 along a curve, in exact rational numbers.

The length of a polynomial's part lies between that of its chord and that of its control polygon.
Summed over small parts, this bounds the tool's distance, the time, and so q5 = q5(0) + t² q.
"""

from __future__ import annotations

import itertools
from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from fractions import Fraction

from abi.verify.exact.interval import Interval, enclose, rounded
from abi.verify.exact.solids import ExactCurve, dot, sub

_MOVED = Fraction(1, 1 << 59)
"""How much longer or shorter a step may be whose ends were rounded, [unit]."""
_PARTS = 64  # of each polynomial; with 16, one right proof of forty was refused


@dataclass(frozen=True)
class ExactTiming:
    """Three phases: speeding up, cruising, slowing down.

    Attributes:
        t1, t2, t3: their durations, [s].
        peak: speed of the cruise, [unit/s].
        acceleration, deceleration: of the first and the last, [unit/s²].
    """

    t1: Fraction
    t2: Fraction
    t3: Fraction
    peak: Fraction
    acceleration: Fraction
    deceleration: Fraction

    def at(self, way: Interval) -> Interval:
        """Time at which a distance has been travelled, [s]."""
        return Interval(self._at(way.low).low, self._at(way.high).high)

    def _at(self, way: Fraction) -> Interval:
        speeding = self.peak * self.t1 / 2
        cruising = speeding + self.peak * self.t2
        length = cruising + self.peak * self.t3 / 2
        if way <= speeding:
            time = enclose(2 * max(way, Fraction(0)) / self.acceleration).sqrt()
            return Interval(time.low, min(time.high, self.t1))
        if way <= cruising:
            return enclose(self.t1 + (way - speeding) / self.peak)
        duration = self.t1 + self.t2 + self.t3
        left = enclose(2 * max(length - way, Fraction(0)) / self.deceleration).sqrt()
        return enclose(duration).minus(left)


@dataclass(frozen=True, eq=False)
class ExactSlide:
    """Bounds of q5 at some parameters of a curve; it rises or falls all along."""

    parameters: list[Fraction]
    values: list[Interval]

    def within(self, start: Fraction, end: Fraction) -> Interval:
        """Bounds of q5 from one parameter to another, [unit]."""
        first = max(bisect_right(self.parameters, start) - 1, 0)
        last = min(bisect_left(self.parameters, end), len(self.parameters) - 1)
        a, b = self.values[first], self.values[last]
        return Interval(min(a.low, b.low), max(a.high, b.high))


def anywhere(first: Fraction, last: Fraction) -> ExactSlide:
    """A slide of which only the ends of its range are known; it is still if they are one."""
    return ExactSlide([Fraction(0)], [Interval(min(first, last), max(first, last))])


def moving(curve: ExactCurve, timing: ExactTiming, q5: Fraction, rate: Fraction) -> ExactSlide:
    """A slide pushed from ``q5`` by rate·t², [unit/s²]."""
    low = high = Fraction(0)
    parameters, values = [curve[0].start], [Interval(q5, q5)]
    for span in curve:
        for part in range(_PARTS):
            a = span.start + (span.end - span.start) * part / _PARTS
            b = span.start + (span.end - span.start) * (part + 1) / _PARTS
            points = [rounded(point) for point in span.points(a, b)]
            steps = [sub(q, p) for p, q in itertools.pairwise(points)]
            chord = sub(points[-1], points[0])
            low += max(enclose(dot(chord, chord)).sqrt().low - _MOVED, Fraction(0))
            high += sum((enclose(dot(step, step)).sqrt().high for step in steps), Fraction(0))
            high += len(steps) * _MOVED
            time = timing.at(Interval(low, high))
            parameters.append(b)
            squared = time.times(time)
            values.append(enclose(q5).plus(squared.times(enclose(rate))))
    return ExactSlide(parameters, values)
