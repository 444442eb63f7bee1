"""Curves in space, and their arc length in both directions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike

from abi import arguments
from abi.arrays import FloatArray, ShortRepr, flat, read_only
from abi.curves import curve_kernels as kernels
from abi.curves.bezier import Bezier

_GAUSS = 16
_NODES, _WEIGHTS = legendre.leggauss(_GAUSS)
# Speeds at the Gauss nodes times this are the Legendre coefficients of the speed on [-1, 1] …
_SPEED = legendre.legvander(_NODES, _GAUSS - 1) * _WEIGHTS[:, None] * (np.arange(_GAUSS) + 0.5)
# … and times this, those of its integral from -1.
_TRAVELLED = np.asarray(legendre.legint(_SPEED, lbnd=-1, axis=1), dtype=np.float64)
_AT_NODES = legendre.legvander(_NODES, _GAUSS).T
_RULE = (flat(_NODES), flat(_WEIGHTS), flat(_SPEED[:, -2:].T), flat(_TRAVELLED))


class Curve(Protocol):
    """A continuous, piecewise polynomial curve in space, such as a spline or a quadratic."""

    def bezier(self) -> Bezier:
        """Bézier points of the curve's polynomials."""

    @property
    def interval(self) -> tuple[float, float]:
        """First and last parameter."""

    def __call__(self, parameter: ArrayLike, order: int = 0) -> FloatArray:
        """Point, or derivative of that order by the parameter.

        Args:
            parameter: a number or shape (n,); clamped to the interval.
            order: 0 for the point, 1 for the first derivative, and so on.

        Returns:
            Shape (3,) for a number, (n, 3) for an array; [unit] per parameter**order, world.
        """


@dataclass(frozen=True, eq=False, repr=False)
class ArcLength(ShortRepr):
    """Arc length of one curve as a function of the parameter, and back.

    The parameter interval is cut into pieces so short that on each the speed is a Legendre series
    up to rounding; the integrated series is the arc length, so both directions agree to rounding
    and neither evaluates the curve again.

    Attributes:
        length: arc length of the whole curve, [unit].
        edges: parameters between the pieces, increasing, shape (m + 1,).
        travelled: arc length from the start to each edge, [unit], shape (m + 1,).
        series: Legendre coefficients of the arc length within each piece, [unit], shape (m, 17).
        nodes: parameters of the Gauss points of all pieces, increasing, shape (16 m,).
        weights: arc length each Gauss point stands for, [unit], shape (16 m,); the sum of
            f(nodes)·weights is the integral of f along the curve.
    """

    length: float
    edges: FloatArray
    travelled: FloatArray
    series: FloatArray
    nodes: FloatArray
    weights: FloatArray

    def __post_init__(self) -> None:
        edges = arguments.increasing("edges", self.edges)
        pieces = len(edges) - 1
        arguments.keep(
            self,
            length=arguments.number("length", self.length, 0.0),
            edges=edges,
            travelled=arguments.numbers("travelled", self.travelled, (pieces + 1,)),
            series=arguments.numbers("series", self.series, (pieces, _GAUSS + 1)),
            nodes=arguments.numbers("nodes", self.nodes, (_GAUSS * pieces,)),
            weights=arguments.numbers("weights", self.weights, (_GAUSS * pieces,)),
        )

    @property
    def passed(self) -> FloatArray:
        """Arc length from the start to each Gauss point, [unit], shape (16 m,)."""
        return np.asarray((self.travelled[:-1, None] + self.series @ _AT_NODES).ravel())

    def distance(self, parameter: ArrayLike) -> FloatArray:
        """Arc length from the start to a parameter.

        Args:
            parameter: a number or any shape; clamped to the interval.

        Returns:
            [unit], in the shape given.
        """
        parameters = arguments.number_or_numbers("parameter", parameter)
        distances = np.empty(parameters.size)
        kernels.arc_lengths(*self._table, flat(parameters), distances)
        return distances.reshape(parameters.shape)

    def parameter(self, distance: ArrayLike) -> FloatArray:
        """Parameter at which an arc length has been travelled, by Newton's method within a bracket.

        The arc length there differs from ``distance`` by less than 1e-12 of the length. Where the
        curve rests (repeated control points) the parameter is one of those that fit.

        Args:
            distance: [unit], a number or any shape; clamped to [0, length].

        Returns:
            Parameters in the shape given.
        """
        distances = arguments.number_or_numbers("distance", distance)
        parameters = np.empty(distances.size)
        gauss = self.nodes, self.weights
        kernels.parameters_at(*self._table, *gauss, flat(distances), parameters)
        return parameters.reshape(distances.shape)

    @property
    def _table(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        return self.edges, self.travelled, flat(self.series)


def arc_length(curve: Curve | Bezier) -> ArcLength:
    """Arc length of a curve, s(u) = ∫ |P'(u)| du, to about 1e-12 of itself.

    Gauss-Legendre quadrature with 16 points on each polynomial piece; pieces are halved until the
    last two coefficients of the speed's Legendre series contribute nothing. A curve that stays at
    one point has length 0.

    Args:
        curve: continuous, a polynomial between its breaks.
    """
    pieces = curve.bezier()
    breaks, points = pieces.breaks, pieces.points
    rounding = 8 * np.finfo(float).eps * float(np.abs(points[:, [0, -1]]).max())
    # Bézier points of the derivative (Farin, Curves and Surfaces for CAGD, section 4.4)
    control = pieces.degree * np.diff(points, axis=1) / np.diff(breaks)[:, None, None]
    edges, travelled, series, nodes, weights = kernels.measured_pieces(
        flat(breaks), flat(control), *_RULE, rounding
    )
    return ArcLength(
        length=float(travelled[-1]),
        edges=read_only(edges),
        travelled=read_only(travelled),
        series=read_only(series.reshape(len(edges) - 1, -1)),
        nodes=read_only(nodes),
        weights=read_only(weights),
    )
