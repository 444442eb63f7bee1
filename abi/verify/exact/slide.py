"""Bounds of the arm's slide q5 along a curve, in exact rational numbers.

The length of a polynomial's part lies between that of its chord and that of its control polygon.
Summed over small parts, this bounds the tool's distance, the time, and so q5 = q5(0) + t² q.
"""

from __future__ import annotations

import itertools
from bisect import bisect_left, bisect_right
from collections.abc import Callable
from fractions import Fraction
from functools import partial

from abi.verify.exact.interval import Interval, enclose, rounded
from abi.verify.exact.solids import ExactCurve, dot, sub

_MOVED = Fraction(1, 1 << 59)
"""How much longer or shorter a step may be whose ends were rounded, [unit]."""
_PARTS = 64  # of each polynomial; with 16, one right proof of forty was refused


ExactSlide = Callable[[Fraction, Fraction], Interval]
"""Function that bounds q5 from one parameter of a curve to another, [unit]."""


def anywhere(first: Fraction, last: Fraction) -> ExactSlide:
    """A slide of which only the ends of its range are known; it is still if they are one."""
    return partial(_within, [Fraction(0)], [Interval(min(first, last), max(first, last))])


def moving(
    curve: ExactCurve,
    phases: tuple[Fraction, Fraction, Fraction],
    speeds: tuple[Fraction, Fraction, Fraction],
    q5: Fraction,
    rate: Fraction,
) -> ExactSlide:
    """A slide that is pushed while the tool speeds up, cruises and slows down.

    Args:
        curve: path of the tool.
        phases: durations of the three, [s].
        speeds: that of the cruise, [unit/s], and the rates of the first and last, [unit/s²].
        q5: where the slide begins, [unit].
        rate: its way over t², [unit/s²].
    """
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
            time = Interval(_time(phases, speeds, low).low, _time(phases, speeds, high).high)
            parameters.append(b)
            squared = time.times(time)
            values.append(enclose(q5).plus(squared.times(enclose(rate))))
    return partial(_within, parameters, values)


def _within(
    parameters: list[Fraction], values: list[Interval], start: Fraction, end: Fraction
) -> Interval:
    """Bounds from one parameter to another of what rises or falls between ``parameters``."""
    first = max(bisect_right(parameters, start) - 1, 0)
    last = min(bisect_left(parameters, end), len(parameters) - 1)
    a, b = values[first], values[last]
    return Interval(min(a.low, b.low), max(a.high, b.high))


def _time(
    phases: tuple[Fraction, Fraction, Fraction],
    speeds: tuple[Fraction, Fraction, Fraction],
    way: Fraction,
) -> Interval:
    """Time at which the tool has travelled a distance, [s]; see :func:`moving`."""
    (t1, t2, t3), (peak, acceleration, deceleration) = phases, speeds
    speeding = peak * t1 / 2
    cruising = speeding + peak * t2
    length = cruising + peak * t3 / 2
    if way <= speeding:
        time = enclose(2 * max(way, Fraction(0)) / acceleration).sqrt()
        return Interval(time.low, min(time.high, t1))
    if way <= cruising:
        return enclose(t1 + (way - speeding) / peak)
    left = enclose(2 * max(length - way, Fraction(0)) / deceleration).sqrt()
    return enclose(t1 + t2 + t3).minus(left)
