"""Stage 5, the curve: quadratic pieces with exact ends, one of them or several."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from abi import arguments
from abi.arrays import FloatArray, ShortRepr, clip, read_only
from abi.curves.bezier import Bezier
from abi.curves.curve import ArcLength, Curve
from abi.errors import ArgumentError

Piece = tuple[float, float, FloatArray]
"""First and last parameter, and rows c0, c1, c2 of c0 + c1·t + c2·t² between them (3, 3), [unit]"""


@dataclass(frozen=True, eq=False, repr=False)
class Quadratic(ShortRepr):
    """A curve on [0, 1] whose piece i is c0 + c1·t + c2·t² from ``breaks[i]`` to ``breaks[i + 1]``.

    Where pieces meet they share points and first derivatives (C¹), so the tool passes at full
    speed.

    Attributes:
        coefficients: rows c0, c1, c2 of each piece in the parameter of the whole curve, shape
            (m, 3, 3), [unit], world.
        breaks: where the pieces meet, from 0 to 1, increasing, shape (m + 1,).
    """

    coefficients: FloatArray
    breaks: FloatArray

    def __post_init__(self) -> None:
        breaks = arguments.increasing("breaks", self.breaks)
        if breaks[0] != 0 or breaks[-1] != 1:
            raise ArgumentError("breaks", breaks.tolist(), "numbers from 0 to 1")
        rows = arguments.numbers("coefficients", self.coefficients, (len(breaks) - 1, 3, 3))
        arguments.keep(self, coefficients=rows, breaks=breaks)

    @classmethod
    def single(cls, coefficients: FloatArray) -> Quadratic:
        """The curve of one piece with the rows c0, c1, c2, shape (3, 3), [unit], world."""
        rows = arguments.numbers("coefficients", coefficients, (3, 3))
        return cls(rows[None], np.arange(2.0))

    @classmethod
    def from_control_points(cls, control_points: FloatArray, breaks: FloatArray) -> Quadratic:
        """The clamped quadratic B-spline with simple inner knots, as its polynomial pieces.

        Such splines are all the C¹ piecewise quadratics on these breaks (de Boor, A Practical
        Guide to Splines, chapter IX). Piece i has the Bézier points (p_i, P_i+1, p_i+1), where P
        are the control points and p_i, at break i, divides the edge from P_i to P_i+1 as the break
        divides the two spans beside it.

        Args:
            control_points: shape (m + 2, 3), [unit], world; the curve's ends are the first and
                last.
            breaks: from 0 to 1, increasing, shape (m + 1,).
        """
        breaks = arguments.increasing("breaks", breaks)
        control_points = arguments.numbers("control_points", control_points, (len(breaks) + 1, 3))
        spans = np.diff(breaks)[:, None]
        share = spans[:-1] / (spans[:-1] + spans[1:])
        inner = control_points[1:-2] * (1 - share) + control_points[2:-1] * share
        joints = np.concatenate([control_points[:1], inner, control_points[-1:]])
        first, middle, last = joints[:-1], control_points[1:-1], joints[1:]
        # in u = (t - t0) / span first, then in t
        b1, b2 = 2 * (middle - first) / spans, (first - 2 * middle + last) / spans**2
        t0 = breaks[:-1, None]
        coefficients = np.stack([first - b1 * t0 + b2 * t0**2, b1 - 2 * b2 * t0, b2], axis=1)
        return cls(coefficients, breaks)

    @property
    def interval(self) -> tuple[float, float]:
        """First and last parameter."""
        return (0.0, 1.0)

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """First and last parameter and coefficients (3, 3) of each piece."""
        ends = self.breaks.tolist()
        return tuple(zip(ends[:-1], ends[1:], self.coefficients, strict=True))

    @cached_property
    def extent(self) -> float:
        """Diagonal of the bounding box of points along the curve, [unit]."""
        samples = self(np.linspace(0, 1, 5 if len(self.coefficients) == 1 else 33))
        return float(np.linalg.norm(np.ptp(samples, axis=0)))

    def bezier(self) -> Bezier:
        """Bézier points of the pieces; cached."""
        return self._bezier

    @cached_property
    def _bezier(self) -> Bezier:
        """Bézier points: the blossom at (a, a), (a, b), (b, b)."""
        start, end = self.breaks[:-1], self.breaks[1:]
        blossom = np.ones((len(start), 3, 3))
        blossom[:, :, 1] = np.stack([start, (start + end) / 2, end], axis=1)
        blossom[:, :, 2] = np.stack([start * start, start * end, end * end], axis=1)
        sizes = np.abs(blossom).max(axis=1, keepdims=True) @ np.abs(self.coefficients)
        points = read_only(blossom @ self.coefficients)
        return Bezier(self.breaks, points, float(sizes.max()))

    def __call__(self, parameter: ArrayLike, order: int = 0) -> FloatArray:
        """Point, or derivative of that order by the parameter; see :class:`abi.curves.curve.Curve`.

        Args:
            parameter: a number or shape (n,); clamped to [0, 1].
            order: of the derivative; above 2 it is 0, and the second is the later piece's where
                two meet.

        Returns:
            Shape (3,) for a number, (n, 3) for an array; [unit], world.
        """
        t = clip(arguments.number_or_numbers("parameter", parameter), 0.0, 1.0)
        order = arguments.integer("order", order, 0, arguments.LARGEST_ID)
        piece = np.searchsorted(self.breaks[1:-1], t, side="right")
        rows = self.coefficients[piece]
        c0, c1, c2 = rows[..., 0, :], rows[..., 1, :], rows[..., 2, :]
        t = t[..., None]
        if order == 0:
            return np.asarray(c0 + (c1 + c2 * t) * t)
        if order == 1:
            return np.asarray(c1 + 2 * c2 * t)
        return np.asarray((2 * c2 if order == 2 else np.zeros(3)) + np.zeros_like(t))


def least_squares(curve: Curve, arc: ArcLength) -> Quadratic:
    """Least-squares quadratic of one piece with the curve's ends, paper stage 5.

    The curve is taken as S(t), where t is the fraction of its arc length travelled, so that the fit
    does not depend on how the curve is parametrised. Between the ends A and B every quadratic is
    A + (B - A)·t + c2·(t² - t), and ∫ abs(P(t) - S(t))² dt over [0, 1] is least where its
    derivative by c2 is zero. As ∫ (t² - t)² dt = 1/30,

        c2 = 30 ∫ (S(t) - A - (B - A)·t) (t² - t) dt,    c1 = B - A - c2,    c0 = A.

    The integral is taken along the curve, dt = abs(S'(u)) du / length, by Gauss quadrature.
    Nothing moves the quadratic away from the obstacles.

    Args:
        curve: the curve to approximate.
        arc: its arc length.
    """
    first, last = curve(np.array(curve.interval))
    c2 = np.zeros(3)
    if arc.length > 0:
        t = (arc.passed / arc.length)[:, None]
        above = curve(arc.nodes) - first - (last - first) * t
        c2 = 30 * (arc.weights @ (above * (t**2 - t))) / arc.length
    return Quadratic.single(np.stack([first, last - first - c2, c2]))
