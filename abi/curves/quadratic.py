"""Stage 5, the curve: the quadratic with exact ends that is nearest to the B-spline."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from abi.arrays import FloatArray, read_only
from abi.clearance.curve_clearance import ROUNDING, Clearance, prove
from abi.curves.curve import ArcLength, Curve
from abi.obstacles.obstacle_set import NO_OBSTACLES, ObstacleSet

Piece = tuple[float, float, FloatArray]
"""First and last parameter, and rows c0, c1, c2 of c0 + c1·t + c2·t² between them (3, 3), [unit]"""

_FINEST = 1e-6  # of the curve's extent: how finely its clearance is measured


@dataclass(frozen=True, eq=False)
class Quadratic:
    """The curve P(t) = c0 + c1·t + c2·t² on [0, 1].

    Attributes:
        coefficients: rows c0, c1, c2, shape (3, 3), [unit], world.
        obstacles: what the curve should keep clear of.
        asked: distance it should keep from every obstacle, [unit].
        note: why it is not the curve that was asked for, as a sentence; empty when it is.
    """

    coefficients: FloatArray
    obstacles: ObstacleSet = NO_OBSTACLES
    asked: float = 0.0
    note: str = ""

    @property
    def degree(self) -> int:
        """2, also for a straight line."""
        return 2

    @property
    def interval(self) -> tuple[float, float]:
        """First and last parameter."""
        return (0.0, 1.0)

    @cached_property
    def breaks(self) -> FloatArray:
        """The ends of the interval: one polynomial, shape (2,)."""
        return read_only(np.array([0.0, 1.0]))

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """The one polynomial, on [0, 1]."""
        return ((0.0, 1.0, self.coefficients),)

    @cached_property
    def clearance(self) -> Clearance:
        """Distance to the obstacles, proven where it can be; fine to a millionth of the extent."""
        extent = float(np.linalg.norm(np.ptp(self([0.0, 0.25, 0.5, 0.75, 1.0]), axis=0)))
        return prove(self, self.obstacles, self.asked, _FINEST * extent + ROUNDING)

    @property
    def holds(self) -> bool:
        """Whether it is proven that the curve keeps the distance asked for."""
        return self.clearance.keeps(self.asked)

    def __call__(self, parameter: ArrayLike, order: int = 0) -> FloatArray:
        """Point, or derivative of that order by the parameter; see :class:`abi.curves.curve.Curve`.

        Args:
            parameter: a number or shape (n,); clamped to [0, 1].
            order: of the derivative; above 2 it is 0.

        Returns:
            Shape (3,) for a number, (n, 3) for an array; [unit], world.
        """
        t = np.clip(np.asarray(parameter, dtype=float), 0.0, 1.0)[..., None]
        c0, c1, c2 = self.coefficients
        if order == 0:
            return np.asarray(c0 + (c1 + c2 * t) * t)
        if order == 1:
            return np.asarray(c1 + 2 * c2 * t)
        return np.asarray((2 * c2 if order == 2 else np.zeros(3)) + np.zeros_like(t))


def fit(curve: Curve, arc: ArcLength, obstacles: ObstacleSet, clearance: float) -> Quadratic:
    """Least-squares quadratic with the curve's ends, paper stage 5.

    The curve is taken as S(t), t the part of its arc length travelled, so that the fit does not
    depend on how the curve is parametrised. Between the ends A and B every quadratic is
    A + (B - A)·t + c2·(t² - t), and ∫ abs(P(t) - S(t))² dt over [0, 1] is least where its
    derivative by c2 is zero. As ∫ (t² - t)² dt = 1/30,

        c2 = 30 ∫ (S(t) - A - (B - A)·t) (t² - t) dt,    c1 = B - A - c2,    c0 = A.

    The integral is taken along the curve, dt = abs(S'(u)) du / length, by Gauss quadrature.
    Nothing moves the quadratic away from the obstacles; ``holds`` says whether it is clear.

    Args:
        curve: the curve to approximate.
        arc: its arc length.
        obstacles: what the quadratic should keep clear of.
        clearance: distance to keep from every obstacle, [unit].
    """
    first, last = curve(np.array(curve.interval))
    bend = np.zeros(3)
    if arc.length > 0:
        t = (arc.passed / arc.length)[:, None]
        above = curve(arc.nodes) - first - (last - first) * t
        bend = 30 * (arc.weights @ (above * (t**2 - t))) / arc.length
    coefficients = read_only(np.stack([first, last - first - bend, bend]))
    return Quadratic(coefficients, obstacles, clearance)
