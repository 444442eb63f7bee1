"""Stage 4, the curve: a clamped B-spline."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from abi import arguments
from abi.arrays import BoolArray, FloatArray, ShortRepr, clip, flat, read_only
from abi.curves import curve_kernels as kernels
from abi.curves.bezier import Bezier
from abi.errors import ArgumentError


@dataclass(frozen=True, eq=False, repr=False)
class BSpline(ShortRepr):
    """A clamped B-spline on [0, 1]; it starts at its first control point and ends at the last.

    Attributes:
        degree: p; pieces are polynomials of this degree, joined with p - 1 equal derivatives.
        control_points: shape (n, 3), [unit], world.
        knots: shape (n + p + 1,), from 0 to 1, the ends p + 1 times.
        added: which control points are not vertices of the path, shape (n,).
        pushed: which control points were pushed away from an obstacle, shape (n,).
    """

    degree: int
    control_points: FloatArray
    knots: FloatArray
    added: BoolArray
    pushed: BoolArray

    def __post_init__(self) -> None:
        points = arguments.points("control_points", self.control_points)
        count = len(points)
        degree = arguments.integer("degree", self.degree, 1, max(count - 1, 1))
        if count < 2:
            raise ArgumentError("number of control points", count, "2 or more")
        knots = arguments.numbers("knots", self.knots, (count + degree + 1,))
        is_clamped = not knots[: degree + 1].any() and (knots[count:] == 1).all()
        if not is_clamped or (knots[1:] < knots[:-1]).any():
            wanted = f"numbers that do not fall, {degree + 1} zeros first, as many ones last"
            raise ArgumentError("knots", knots.tolist(), wanted)
        added = arguments.flags("added", self.added, (count,))
        pushed = arguments.flags("pushed", self.pushed, (count,))
        arguments.keep(
            self, degree=degree, control_points=points, knots=knots, added=added, pushed=pushed
        )

    @property
    def inserted(self) -> int:
        """Number of control points that are not vertices of the path."""
        return int(self.added.sum())

    @property
    def moved(self) -> int:
        """Number of control points that were pushed away from an obstacle."""
        return int(self.pushed.sum())

    @property
    def interval(self) -> tuple[float, float]:
        """First and last parameter."""
        return (0.0, 1.0)

    @cached_property
    def breaks(self) -> FloatArray:
        """Parameters between which the curve is one polynomial: the distinct knots, shape (k,)."""
        return read_only(np.unique(self.knots))

    @property
    def extent(self) -> float:
        """Diagonal of the control points' bounding box, [unit]."""
        return float(np.linalg.norm(np.ptp(self.control_points, axis=0)))

    def bezier(self) -> Bezier:
        """Bézier points, by inserting every knot until it occurs ``degree`` times; cached."""
        return self._bezier

    @cached_property
    def _bezier(self) -> Bezier:
        """The Bézier points.

        Bézier point j of the polynomial on [a, b] is the blossom at a, degree - j times, and b, j
        times (Ramshaw, Blossoms are polar forms, 1989, section 6). De Boor's recursion for it
        takes convex combinations only, so errors do not grow.
        """
        spans = len(self.control_points) - self.degree
        breaks, points = np.empty(spans + 1), np.empty(3 * spans * (self.degree + 1))
        spline = flat(self.knots), flat(self.control_points), self.degree
        count = kernels.bezier(*spline, breaks, points)
        pieces = points.reshape(spans, self.degree + 1, 3)[:count]
        size = float(np.abs(self.control_points).max())
        return Bezier(read_only(breaks[: count + 1]), read_only(pieces), size)

    def influence(self, parameters: FloatArray) -> FloatArray:
        """Weights of the n control points in the points at ``parameters`` (m,), shape (m, n)."""
        parameters = arguments.within("parameters", parameters, (-1,), 0.0, 1.0)
        if not len(parameters):
            return np.empty((0, len(self.control_points)))
        design = scipy.interpolate.BSpline.design_matrix(parameters, self.knots, self.degree)
        return np.asarray(design.toarray())

    def refined(self, edges: NDArray[np.integer[Any]]) -> BSpline:
        """Halve edges of the control polygon, given by index; an edge of length 0 stays."""
        edges = arguments.ids("edges", edges, (-1,), len(self.control_points) - 1)
        ends = self.control_points[edges], self.control_points[edges + 1]
        long = np.linalg.norm(ends[1] - ends[0], axis=1) > 0
        edges, middles = edges[long], (ends[0] + ends[1])[long] / 2
        # edge k is between k and k + 1
        places = np.sort(np.concatenate([np.arange(len(self.control_points)), edges + 0.5]))
        before = places.astype(int)
        new = places != before
        points = self.control_points[before]
        points[new] = middles
        return clamped(points, self.degree, self.added[before] | new, self.pushed[before] & ~new)

    def __call__(self, parameter: ArrayLike, order: int = 0) -> FloatArray:
        """Point, or derivative of that order by the parameter; see :class:`abi.curves.curve.Curve`.

        Args:
            parameter: a number or shape (n,); clamped to [0, 1].
            order: of the derivative; above the degree it is 0.

        Returns:
            Shape (3,) for a number, (n, 3) for an array; [unit], world.
        """
        t = clip(arguments.number_or_numbers("parameter", parameter), 0.0, 1.0)
        order = arguments.integer("order", order, 0, arguments.LARGEST_ID)
        if order > self.degree:
            return np.zeros((*t.shape, 3))
        points, local = np.empty(3 * t.size), np.empty(3 * (self.degree + 1))
        spline = self.knots, flat(self.control_points), self.degree
        kernels.spline(*spline, flat(t), order, local, points)
        return points.reshape(*t.shape, 3)


def clamped(
    control_points: FloatArray,
    degree: int,
    added: BoolArray | None = None,
    pushed: BoolArray | None = None,
) -> BSpline:
    """B-spline with clamped, otherwise uniform knots.

    Args:
        control_points: shape (n, 3), n > degree, [unit], world.
        degree: at least 1.
        added: which control points are not vertices of the path, shape (n,); None for none.
        pushed: which were pushed away from an obstacle, shape (n,); None for none.

    Raises:
        ArgumentError: control points or degree are not as stated.
    """
    points = arguments.points("control_points", control_points)
    degree = arguments.integer("degree", degree, 1, max(len(points) - 1, 1))
    none = np.zeros(len(points), dtype=bool)
    return BSpline(
        degree,
        points,
        _uniform_knots(len(points), degree),
        none if added is None else added,
        none if pushed is None else pushed,
    )


def _uniform_knots(count: int, degree: int) -> FloatArray:
    knots = np.ones(count + degree + 1)
    knots[:degree] = 0.0
    knots[degree : count + 1] = np.linspace(0, 1, count - degree + 1)
    return read_only(knots)
