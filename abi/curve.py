"""What a curve is, and its arc length in both directions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike, NDArray

from abi.arrays import FloatArray, read_only

_GAUSS = 16
_NODES, _WEIGHTS = legendre.leggauss(_GAUSS)
# Speeds at the Gauss nodes times this are the Legendre coefficients of the speed on [-1, 1] …
_SPEED = legendre.legvander(_NODES, _GAUSS - 1) * _WEIGHTS[:, None] * (np.arange(_GAUSS) + 0.5)
# … and times this, those of its integral from -1.
_TRAVELLED = legendre.legint(_SPEED, lbnd=-1, axis=1)


class Curve(Protocol):
    """A piecewise polynomial curve in space: spline and quadratic alike."""

    @property
    def degree(self) -> int:
        """Largest degree of a piece."""

    @property
    def interval(self) -> tuple[float, float]:
        """First and last parameter."""

    @property
    def breaks(self) -> FloatArray:
        """Parameters between which the curve is one polynomial, ends included, shape (k,)."""

    def __call__(self, parameter: ArrayLike, order: int = 0) -> FloatArray:
        """Point, or derivative of that order by the parameter.

        Args:
            parameter: a number or shape (n,); clamped to the interval.
            order: 0 for the point, 1 for the first derivative, and so on.

        Returns:
            Shape (3,) for a number, (n, 3) for an array; [unit] per parameter**order, world.
        """


@dataclass(frozen=True, eq=False)
class ArcLength:
    """Arc length of one curve as a function of the parameter, and back.

    The parameter interval is cut into pieces so short that the speed on each is a Legendre series
    to rounding; the integrated series is the arc length, so both directions agree to rounding and
    neither evaluates the curve again.

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

    def distance(self, parameter: ArrayLike) -> FloatArray:
        """Arc length from the start to a parameter.

        Args:
            parameter: a number or any shape; clamped to the interval.

        Returns:
            [unit], in the shape given.
        """
        given = np.asarray(parameter, dtype=float)
        asked = np.clip(given.ravel(), self.edges[0], self.edges[-1])
        piece = _piece(self.edges, asked)
        left, right = self.edges[piece], self.edges[piece + 1]
        place = 2 * (asked - left) / (right - left) - 1
        found = self.travelled[piece] + _series(self.series[piece], place)
        found = np.where(asked <= self.edges[0], 0.0, np.clip(found, 0.0, self.length))
        found = np.where(asked >= self.edges[-1], self.length, found)
        return np.asarray(found.reshape(given.shape))

    def parameter(self, distance: ArrayLike) -> FloatArray:
        """Parameter at which an arc length has been travelled, by Newton within a bracket.

        The arc length there differs from ``distance`` by less than 1e-12 of the length. Where the
        curve rests (repeated control points) the parameter is one of those that fit.

        Args:
            distance: [unit], a number or any shape; clamped to [0, length].

        Returns:
            Parameters in the shape given.
        """
        given = np.asarray(distance, dtype=float)
        asked = np.clip(given.ravel(), 0.0, self.length)
        piece = _piece(self.travelled, asked)
        left, right = self.edges[piece], self.edges[piece + 1]
        guess = 2 * (self._near(asked) - left) / (right - left) - 1
        wanted = asked - self.travelled[piece]
        place = _invert(self.series[piece], wanted, guess, 1e-13 * self.length)
        found = np.minimum(left + (right - left) * (place + 1) / 2, right)
        found = np.where(asked <= 0, self.edges[0], found)
        found = np.where(asked >= self.length, self.edges[-1], found)
        return np.asarray(found.reshape(given.shape))

    def _near(self, distance: FloatArray) -> FloatArray:
        """About where a distance has been travelled: straight between the Gauss points."""
        passed = np.cumsum(self.weights) - self.weights / 2
        return np.interp(distance, passed, self.nodes)


def measure(curve: Curve) -> ArcLength:
    """Measure a curve's arc length, s(u) = ∫ |P'(u)| du, to about 1e-12 of itself.

    Gauss-Legendre quadrature with 16 points on each polynomial piece; pieces are halved until the
    last two coefficients of the speed's Legendre series contribute nothing. A curve that stays at
    one point has length 0.

    Args:
        curve: the curve to measure.

    Returns:
        The measured arc length.
    """
    breaks = np.asarray(curve.breaks, dtype=float)
    ends = np.stack([breaks[:-1], breaks[1:]], axis=1)
    rounding = 8 * np.finfo(float).eps * float(np.abs(curve(breaks)).max())
    accepted: list[tuple[FloatArray, FloatArray]] = []
    settled = 0.0
    for _ in range(40):
        half = (ends[:, 1] - ends[:, 0]) / 2
        nodes = ends.mean(axis=1)[:, None] + half[:, None] * _NODES
        derivatives = curve(nodes.ravel(), 1)
        speed = np.linalg.norm(derivatives, axis=1).reshape(nodes.shape) * half[:, None]
        lengths = speed @ _WEIGHTS
        tail = np.abs(speed @ _SPEED[:, -2:]).sum(axis=1)
        total = settled + float(lengths.sum())
        done = tail <= 1e-13 * total + rounding
        accepted.append((ends[done], speed[done]))
        settled += float(lengths[done].sum())
        if done.all():
            break
        rest = ends[~done]
        middle = rest.mean(axis=1)
        ends = np.stack([rest[:, 0], middle, middle, rest[:, 1]], axis=1).reshape(-1, 2)
    else:
        accepted.append((rest, speed[~done]))
    pieces = np.concatenate([pair[0] for pair in accepted])
    speeds = np.concatenate([pair[1] for pair in accepted])
    if float((speeds @ _WEIGHTS).sum()) <= rounding:
        speeds = np.zeros_like(speeds)  # such a curve has no direction, hence no inverse
    return _assemble(pieces, speeds)


def _assemble(ends: FloatArray, speed: FloatArray) -> ArcLength:
    order = np.argsort(ends[:, 0])
    ends, speed = ends[order], speed[order]
    weights = speed * _WEIGHTS
    travelled = np.concatenate([[0.0], np.cumsum(weights.sum(axis=1))])
    middle, half = ends.mean(axis=1), (ends[:, 1] - ends[:, 0]) / 2
    return ArcLength(
        length=float(travelled[-1]),
        edges=read_only(np.append(ends[:, 0], ends[-1, 1])),
        travelled=read_only(travelled),
        series=read_only(speed @ _TRAVELLED),
        nodes=read_only((middle[:, None] + half[:, None] * _NODES).ravel()),
        weights=read_only(weights.ravel()),
    )


def _piece(edges: FloatArray, value: FloatArray) -> NDArray[np.intp]:
    return np.clip(np.searchsorted(edges, value, side="right") - 1, 0, len(edges) - 2)


def _series(coefficients: FloatArray, place: FloatArray) -> FloatArray:
    values = legendre.legvander(place, coefficients.shape[1] - 1)
    return np.asarray(np.einsum("nk,nk->n", coefficients, values))


def _invert(
    series: FloatArray, wanted: FloatArray, guess: FloatArray, tolerance: float
) -> FloatArray:
    """Places in [-1, 1] where increasing series (n, k) that start from 0 reach ``wanted`` (n,)."""
    slope = np.asarray(legendre.legder(series, axis=1), dtype=float)
    place: FloatArray = np.clip(guess, -1.0, 1.0)
    # a little wider, so that Newton may step on an end
    low, high = np.full_like(place, -1.0 - 1e-9), np.full_like(place, 1.0 + 1e-9)
    rest = np.arange(len(place))
    for _ in range(60):
        at = place[rest]
        error = _series(series[rest], at) - wanted[rest]
        far = np.abs(error) > tolerance
        if not far.any():
            break
        rest, at, error = rest[far], at[far], error[far]
        low[rest] = np.where(error < 0, at, low[rest])
        high[rest] = np.where(error > 0, at, high[rest])
        speed = _series(slope[rest], at)
        newton = at - np.divide(error, speed, out=np.zeros_like(error), where=speed > 0)
        inside = (newton > low[rest]) & (newton < high[rest])
        place[rest] = np.where(inside, newton, (low[rest] + high[rest]) / 2)
    return np.clip(place, -1.0, 1.0)
