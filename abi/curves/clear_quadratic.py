"""Search for the clear quadratic spline nearest to a given one, for stage 5's modes.

A C¹ curve of m quadratic pieces is a quadratic B-spline with m + 2 control points; its ends are
fixed, so m of them are free. Among the curves that keep the clearance, the search is for the one
nearest to the least-squares curve in L2, which is a quadratic function of the free points.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.polynomial import legendre

from abi import arguments
from abi.arrays import FloatArray, IntArray, read_only
from abi.curves.clearance.curve_clearance import ROUNDING, curve_clearance
from abi.curves.quadratic import Quadratic
from abi.obstacles.obstacle_set import ObstacleSet

PointsAt = Callable[[FloatArray], FloatArray]
"""Points (n, 3) of a curve at parameters (n,) in [0, 1], [unit]."""

_NODES, _WEIGHTS = legendre.leggauss(8)
_PARTS = 32  # short pieces of the whole curve at first, at least …
_FEWEST_PARTS = 8  # … and of each polynomial
_SHORTEST = 1e-3  # short piece, of the whole curve
_ROUNDS = 16
_SETTLED = 1e-3  # of the curve's extent: largest move of a round that needs no other
_ALLOWANCE = 1e-5  # of the curve's extent, kept beyond the clearance
_INFEASIBLE = 1e-6  # distance of (0, 1) to the cone of the rows, above which they are feasible


@dataclass(frozen=True, eq=False)
class Target:
    """The least-squares curve on some breaks, and the clearance to keep.

    Attributes:
        breaks: from 0 to 1, shape (m + 1,).
        control_points: of the least-squares curve, shape (m + 2, 3), [unit], world.
        obstacles: to keep clear of.
        clearance: distance to keep from every obstacle, [unit].
    """

    breaks: FloatArray
    control_points: FloatArray
    obstacles: ObstacleSet
    clearance: float

    def __post_init__(self) -> None:
        breaks = arguments.increasing("breaks", self.breaks)
        points = arguments.numbers("control_points", self.control_points, (len(breaks) + 1, 3))
        clearance = arguments.number("clearance", self.clearance)
        arguments.keep(self, breaks=breaks, control_points=points, clearance=clearance)

    def basis(self, parameters: FloatArray) -> FloatArray:
        """Weight of each control point in the points at ``parameters`` (n,), shape (n, m + 2)."""
        return _basis(self.breaks, arguments.numbers("parameters", parameters, (-1,)))

    @cached_property
    def extent(self) -> float:
        """Diagonal of the control points' bounding box, [unit]."""
        return float(np.linalg.norm(np.ptp(self.control_points, axis=0)))

    @cached_property
    def aim(self) -> float:
        """Distance to aim at, [unit]: the clearance plus an allowance, if the ends keep that."""
        ends, _ = self.obstacles.nearest(self.control_points[[0, -1]])
        room = max(0.0, float(ends.min()) - self.clearance)
        return self.clearance + min(_ALLOWANCE * self.extent + ROUNDING, room / 2)

    @cached_property
    def norm(self) -> FloatArray:
        """Matrix L (m, m) with abs(Lᵀx)² the squared L2 norm of the curve of free points x."""
        t, weights = _quadrature(self.breaks)
        inner = self.basis(t)[:, 1:-1]
        return np.asarray(np.linalg.cholesky(inner.T @ (weights[:, None] * inner)))

    def distance(self, control_points: FloatArray) -> float:
        """L2 distance of another curve on the same breaks, [unit]."""
        shape = self.control_points.shape
        control_points = arguments.numbers("control_points", control_points, shape)
        move = (control_points - self.control_points)[1:-1]
        return float(np.linalg.norm(self.norm.T @ move))


def least_squares_target(
    curve: PointsAt, breaks: FloatArray, obstacles: ObstacleSet, clearance: float
) -> Target:
    """The curve on ``breaks`` with the ends of ``curve`` that is nearest to it in L2.

    With one piece that is :func:`abi.curves.quadratic.least_squares`.

    Args:
        curve: points of the curve to approximate at shares of its arc length, which is above 0.
        breaks: from 0 to 1, increasing, shape (m + 1,).
        obstacles: to keep clear of.
        clearance: distance to keep from every obstacle, [unit].
    """
    t, weights = _quadrature(_even_cuts(breaks))
    basis = _basis(breaks, t)
    ends = curve(np.array([0.0, 1.0]))
    residual = curve(t) - basis[:, [0, -1]] @ ends
    root = np.sqrt(weights)[:, None]
    inner = np.linalg.lstsq(basis[:, 1:-1] * root, residual * root, rcond=None)[0]
    points = np.concatenate([ends[:1], inner, ends[1:]])
    return Target(breaks, read_only(points), obstacles, clearance)


def nearest_clear(target: Target, starts: Sequence[PointsAt]) -> Quadratic | None:
    """Find the clear curve nearest to ``target``, from starts on different sides of obstacles.

    A convex obstacle's signed distance is a convex function of the point: it is nowhere below its
    tangent. So with y a point of the start and g the gradient of d there, the half space

        d(y) + g·(x - y) >= clearance

    has no point x nearer than the clearance. The curve is halved into short Bézier pieces, each
    to lie with its control points in the half space of the start's point in its middle. The
    nearest such curve is a least-distance problem (Lawson and Hanson, Solving Least Squares
    Problems, chapter 23). It replaces the start, and so on until it settles: each round
    is no farther from ``target`` than the one before (the convex-concave procedure, Yuille and
    Rangarajan 2003). A mesh need not be convex; where the curve comes too near it aims higher.

    Args:
        target: to be near to.
        starts: points (n, 3) at parameters (n,) in [0, 1], [unit]; they need not be clear, but
            a clear one leads to a clear curve if there are enough pieces. The one that is nearest
            after two rounds is continued; the next one only if that does not become clear.

    Returns:
        The curve, clear as far as measured, or None.
    """
    if not len(target.obstacles):
        return Quadratic.from_control_points(target.control_points, target.breaks)
    cuts = _even_cuts(target.breaks)
    middles = _middles(cuts)
    through = target.basis(middles)
    basis = _of_control_points(target, cuts, through)
    candidates: list[tuple[float, int, FloatArray]] = []
    for start in starts:
        solution = _within_half_spaces(target, basis, start(middles), target.aim)
        if solution is not None:
            solution = _within_half_spaces(target, basis, through @ solution[0], target.aim)
        if solution is not None:
            candidates.append((target.distance(solution[0]), len(candidates), solution[0]))
    settled = (_settled(target, points) for *_, points in sorted(candidates))
    return next((curve for curve in settled if curve is not None), None)


def _settled(target: Target, control_points: FloatArray) -> Quadratic | None:
    """Iterate from control points (m + 2, 3) until they converge and the curve is clear.

    The short pieces that touch their half space are halved, so that in the end it costs nothing
    that a piece lies in its half space with its control points.
    """
    points, aim = control_points, target.aim
    cuts = _even_cuts(target.breaks)
    tolerance = (target.aim - target.clearance) / 2 + ROUNDING
    step = np.inf
    for number in range(1, _ROUNDS + 1):
        middles = _middles(cuts)
        through = target.basis(middles)
        basis = _of_control_points(target, cuts, through)
        solution = _within_half_spaces(target, basis, through @ points, aim)
        if solution is not None:
            step = float(np.abs(solution[0] - points).max())
            points = solution[0]
            halved = solution[1][np.diff(cuts)[solution[1]] > _SHORTEST]
            cuts = np.sort(np.append(cuts, middles[halved]))
        if (
            solution is None
            or number == _ROUNDS
            or (step <= _SETTLED * target.extent and not len(halved))
        ):
            curve = Quadratic.from_control_points(points, target.breaks)
            measured = curve_clearance(curve, target.obstacles, target.clearance, tolerance)
            if measured.distance >= target.clearance:
                return curve
            if solution is None:
                return None
            aim += 1.5 * (target.clearance - measured.distance)
    return None


def _within_half_spaces(
    target: Target, basis: tuple[FloatArray, FloatArray], near: FloatArray, aim: float
) -> tuple[FloatArray, IntArray] | None:
    """The nearest curve in the half spaces of ``near`` (n, 3), and the pieces on their planes.

    Args:
        target: to be near to.
        basis: of the n short pieces, see :func:`_of_control_points`.
        near: a point for each piece, [unit].
        aim: distance of the half spaces from the obstacles, [unit].

    Returns:
        Control points (m + 2, 3), [unit], and numbers of pieces; None when there is no such curve.
    """
    all_points, free = basis
    control = all_points @ target.control_points
    normals, bounds = [], []
    for obstacle in target.obstacles:
        distance, gradient = obstacle.signed_distance_gradient(near)
        ahead = np.einsum("nkj,nj->nk", control - near[:, None], gradient)
        bounds.append(aim - distance[:, None] - ahead)
        normals.append(np.einsum("nkm,nj->nkmj", free, gradient))
    b = np.concatenate(bounds).ravel()
    a = np.concatenate(normals).reshape(len(b), -1)
    movable = np.flatnonzero((a != 0).any(axis=1))  # all but the curve's ends
    solution = _least_distance(a[movable], b[movable])
    if solution is None:
        return None
    move, touching = solution
    points = target.control_points.copy()
    points[1:-1] += np.linalg.solve(target.norm.T, move.reshape(-1, 3))
    return points, np.unique(movable[touching] // 3 % len(near))


def _least_distance(a: FloatArray, b: FloatArray) -> tuple[FloatArray, IntArray] | None:
    """Shortest y with a·y >= b, and the active rows (Lawson and Hanson, 23.27)."""
    if (b <= 0).all():
        return np.zeros(a.shape[1]), np.zeros(0, dtype=np.int32)
    scale = np.linalg.norm(a, axis=1)
    a, b = a / scale[:, None], b / scale
    size = float(b.max())
    system = np.concatenate([a.T, b[None] / size])
    ahead = np.append(np.zeros(a.shape[1]), 1.0)
    try:
        weights, norm = scipy.optimize.nnls(system, ahead)
    except RuntimeError:  # too many iterations
        return None
    if norm < _INFEASIBLE:
        return None
    residual = system @ weights - ahead
    return -residual[:-1] / residual[-1] * size, np.flatnonzero(weights).astype(np.int32)


def _even_cuts(breaks: FloatArray) -> FloatArray:
    parts = max(_FEWEST_PARTS, -(-_PARTS // (len(breaks) - 1)))
    cuts = np.linspace(breaks[:-1], breaks[1:], parts, endpoint=False, axis=1)
    return np.append(cuts, breaks[-1])


def _middles(cuts: FloatArray) -> FloatArray:
    return (cuts[:-1] + cuts[1:]) / 2


def _of_control_points(
    target: Target, cuts: FloatArray, through: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Weights of the curve's control points in those of its Bézier pieces between the cuts.

    Args:
        target: with the curve's breaks.
        cuts: (n + 1,).
        through: weights in the points in the middle of each piece (n, m + 2).

    Returns:
        Shape (n, 3, m + 2); and those of the free points, measured in L2, (n, 3, m).
    """
    ends = target.basis(cuts)
    # a quadratic's middle is a quarter of its ends and half of its middle control point
    control = np.stack([ends[:-1], 2 * through - (ends[:-1] + ends[1:]) / 2, ends[1:]], axis=1)
    inner = control[:, :, 1:-1]
    free = np.linalg.solve(target.norm, inner.reshape(-1, inner.shape[2]).T).T
    return control, np.asarray(free, dtype=float).reshape(inner.shape)


def _basis(breaks: FloatArray, parameters: FloatArray) -> FloatArray:
    knots = np.concatenate([breaks[:1], breaks[:1], breaks, breaks[-1:], breaks[-1:]])
    return np.asarray(scipy.interpolate.BSpline.design_matrix(parameters, knots, 2).toarray())


def _quadrature(breaks: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Gauss points and weights on each piece, both (8 m,)."""
    middle, half = (breaks[:-1] + breaks[1:]) / 2, np.diff(breaks) / 2
    return (middle[:, None] + half[:, None] * _NODES).ravel(), np.outer(half, _WEIGHTS).ravel()
