"""Stage 5, the curve in more than one piece: quadratics that pass into one another smoothly."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from abi.arrays import FloatArray, read_only
from abi.clearance.curve_clearance import ROUNDING, Clearance, prove
from abi.curves.quadratic import Piece
from abi.obstacles.obstacle_set import NO_OBSTACLES, ObstacleSet

_FINEST = 1e-6  # of the curve's extent: how finely its clearance is measured


@dataclass(frozen=True, eq=False)
class Quadratics:
    """A curve on [0, 1] whose piece i is c0 + c1·t + c2·t² from ``breaks[i]`` to ``breaks[i + 1]``.

    The pieces share points and first derivatives where they meet (C¹), so the tool goes through at
    full speed.

    Attributes:
        coefficients: rows c0, c1, c2 of each piece in the parameter of the whole curve, shape
            (m, 3, 3), [unit], world.
        breaks: where the pieces meet, from 0 to 1, increasing, shape (m + 1,).
        obstacles: what the curve should keep clear of.
        asked: distance it should keep from every obstacle, [unit].
    """

    coefficients: FloatArray
    breaks: FloatArray
    obstacles: ObstacleSet = NO_OBSTACLES
    asked: float = 0.0

    @property
    def degree(self) -> int:
        """2, also for straight lines."""
        return 2

    @property
    def interval(self) -> tuple[float, float]:
        """First and last parameter."""
        return (0.0, 1.0)

    @property
    def note(self) -> str:
        """What there is to say about the curve: nothing, it has the pieces it needs."""
        return ""

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """First and last parameter and coefficients (3, 3) of each piece."""
        ends = self.breaks.tolist()
        return tuple(zip(ends[:-1], ends[1:], self.coefficients, strict=True))

    @cached_property
    def clearance(self) -> Clearance:
        """Distance to the obstacles, proven where it can be; fine to a millionth of the extent."""
        extent = float(np.linalg.norm(np.ptp(self(np.linspace(0, 1, 33)), axis=0)))
        return prove(self, self.obstacles, self.asked, _FINEST * extent + ROUNDING)

    @property
    def holds(self) -> bool:
        """Whether it is proven that the curve keeps the distance asked for."""
        return self.clearance.keeps(self.asked)

    def __call__(self, parameter: ArrayLike, order: int = 0) -> FloatArray:
        """Point, or derivative of that order by the parameter; see :class:`abi.curves.curve.Curve`.

        Args:
            parameter: a number or shape (n,); clamped to [0, 1].
            order: of the derivative; above 2 it is 0, and the second is the later piece's where
                two meet.

        Returns:
            Shape (3,) for a number, (n, 3) for an array; [unit], world.
        """
        t = np.clip(np.asarray(parameter, dtype=float), 0.0, 1.0)
        piece = np.searchsorted(self.breaks[1:-1], t, side="right")
        c0, c1, c2 = np.moveaxis(self.coefficients[piece], -2, 0)
        t = t[..., None]
        if order == 0:
            return np.asarray(c0 + (c1 + c2 * t) * t)
        if order == 1:
            return np.asarray(c1 + 2 * c2 * t)
        return np.asarray((2 * c2 if order == 2 else np.zeros(3)) + np.zeros_like(t))


def join(
    control_points: FloatArray, breaks: FloatArray, obstacles: ObstacleSet, clearance: float
) -> Quadratics:
    """The clamped quadratic B-spline with simple inner knots, as its polynomial pieces.

    Such splines are all the C¹ piecewise quadratics on these breaks (de Boor, A Practical Guide to
    Splines, chapter IX). Piece i has the Bézier points (p_i, P_i+1, p_i+1), where P are the control
    points and p_i, at break i, divides the edge from P_i to P_i+1 as the break divides the two
    spans beside it.

    Args:
        control_points: shape (m + 2, 3), [unit], world; the curve's ends are the first and last.
        breaks: from 0 to 1, increasing, shape (m + 1,).
        obstacles: what the curve should keep clear of.
        clearance: distance to keep from every obstacle, [unit].
    """
    spans = np.diff(breaks)[:, None]
    share = spans[:-1] / (spans[:-1] + spans[1:])
    inner = control_points[1:-2] * (1 - share) + control_points[2:-1] * share
    joints = np.concatenate([control_points[:1], inner, control_points[-1:]])
    first, middle, last = joints[:-1], control_points[1:-1], joints[1:]
    # in u = (t - t0) / span first, then in t
    b1, b2 = 2 * (middle - first) / spans, (first - 2 * middle + last) / spans**2
    t0 = breaks[:-1, None]
    coefficients = np.stack([first - b1 * t0 + b2 * t0**2, b1 - 2 * b2 * t0, b2], axis=1)
    return Quadratics(read_only(coefficients), read_only(breaks.copy()), obstacles, clearance)
