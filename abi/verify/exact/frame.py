"""Frames in exact numbers: multiples of 2^-200 with an error bound, as sines are not rational."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from abi.robot.urdf.joint import Joint
from abi.verify.exact.solids import Vec3
from abi.verify.fault import Fault

BITS = 200
ONE = 1 << BITS
_LARGEST_ANGLE = 64

Exact: TypeAlias = "NDArray[np.object_]"  # of exact numbers, such as a matrix in 2^-200


class ExactFrame(NamedTuple):
    """A frame in the world: rotation and origin in 2^-200, and bounds of the errors of both."""

    turn: Exact
    origin: Exact
    turn_error: int
    origin_error: int

    def place(self, point: Vec3) -> tuple[Vec3, Fraction]:
        """A point of the frame in the world, and a bound of its error along each axis."""
        whole = wholes(np.array(point, dtype=object))
        size = abs(whole).max() + 1
        x, y, z = (self.turn @ whole >> BITS) + self.origin
        error = 3 * (size * self.turn_error // ONE + 1) + 6 + 1 + self.origin_error
        return (Fraction(x, ONE), Fraction(y, ONE), Fraction(z, ONE)), Fraction(error, ONE)


def behind(frame: ExactFrame, turn: Exact, origin: Exact, error: int) -> ExactFrame:
    """A frame after a transform whose numbers are wrong by at most ``error`` in 2^-200.

    No entry of a rotation exceeds 2. A product of three terms is wrong by what each factor is,
    times the other, and by one for rounding.
    """
    size = max(abs(origin)) + error
    return ExactFrame(
        frame.turn @ turn >> BITS,
        (frame.turn @ origin >> BITS) + frame.origin,
        6 * (frame.turn_error + error) + 3 * (frame.turn_error * error // ONE + 1) + 1,
        frame.origin_error + 3 * (size * frame.turn_error // ONE + 1) + 6 * error + 1,
    )


def turned(joint: Joint, angle: Fraction) -> tuple[Exact, int]:
    """Rotation about a joint's axis (Rodrigues' formula), and a bound of its error, in 2^-200."""
    if abs(angle) > _LARGEST_ANGLE:
        raise Fault(f"{joint.name} turns by more than {_LARGEST_ANGLE} rad")
    sine, cosine, error = sine_and_cosine(angle)
    along, across, square = _products(*joint.axis.tolist())
    turn = ((ONE - cosine) * along + sine * across) // square
    turn[np.diag_indices(3)] += cosine
    return turn, 4 * error + 1


@lru_cache(maxsize=256)
def _products(*axis: float) -> tuple[Exact, Exact, int]:
    """The axis times itself, its cross product as a matrix, and by what both are too large.

    In whole numbers: a fraction for each entry would take ten times as long.
    """
    parts = [*map(Fraction, axis)]
    scale = math.lcm(*(part.denominator for part in parts))
    x, y, z = numbers = [int(part * scale) for part in parts]
    along: Exact = np.array([[one * other for other in numbers] for one in numbers], dtype=object)
    across: Exact = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=object)
    return along, scale * across, scale**2


@lru_cache(maxsize=1 << 12)  # joints that stand keep their angles
def sine_and_cosine(angle: Fraction) -> tuple[int, int, int]:
    """Sine and cosine in 2^-200, and a bound of the error of both, by Taylor's series.

    Once a term is below the last digit, so are all that follow, each at most half the one before.
    """
    x = whole(angle)
    sums = [ONE, 0]  # terms of even and of odd order, without their signs
    term, order = ONE, 0
    error, errors = 0, 2
    while term or order <= 2 * abs(angle):
        order += 1
        term = (term * x >> BITS) // order
        # the term before is wrong by `error`, the angle by 1, and both divisions round
        error = (error * (abs(x) + 1) >> BITS) // order + abs(term) // ONE + 4
        errors += error
        sums[order % 2] += term if order % 4 < 2 else -term
    return sums[1], sums[0], errors + error


def nearly_sine_and_cosine(angle: Fraction) -> tuple[Fraction, Fraction]:
    """Sine and cosine, wrong by far less than the last digit of a floating-point number."""
    sine, cosine, _ = sine_and_cosine(angle)
    return Fraction(sine, ONE), Fraction(cosine, ONE)


def _nearest_float(whole: int) -> Fraction:
    """The floating-point number nearest to a number of 2^-200."""
    return Fraction(whole / ONE)


def whole(number: Fraction) -> int:
    """Number of 2^-200 below it, less than one away."""
    return number.numerator * ONE // number.denominator


wholes: Callable[[Exact], Exact] = np.frompyfunc(whole, 1, 1)
fractions: Callable[[NDArray[Any]], Exact] = np.frompyfunc(Fraction, 1, 1)
rounded: Callable[[Exact], Exact] = np.frompyfunc(_nearest_float, 1, 1)
