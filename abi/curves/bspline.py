"""Stage 4: a B-spline on the path's vertices, kept clear of the obstacles."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from abi.arrays import BoolArray, FloatArray, flat, read_only
from abi.clearance.curve_clearance import ROUNDING, Clearance, measure, prove
from abi.curves import bspline_kernels as kernels
from abi.curves.control_points import graded
from abi.curves.curve import measure as arc_length
from abi.obstacles.obstacle_set import NO_OBSTACLES, ObstacleSet

_FINEST = 1e-6  # of the path's extent: how finely a clearance is measured
_ROUNDS = 60
_MOST_INSERTED = 2000
_PUSHES = 3  # in a row, before the polygon is refined
_WORTH = 0.3  # part of what is missing that a push must win to be kept
_FINER = 3  # times that a near miss is cleared more finely
_SAMPLES = 8  # in each stretch that is too near


@dataclass(frozen=True, eq=False)
class BSpline:
    """A clamped B-spline on [0, 1]; it starts at its first control point and ends at the last.

    Attributes:
        degree: p; pieces are polynomials of this degree, joined with p - 1 equal derivatives.
        control_points: shape (n, 3), [unit], world.
        knots: shape (n + p + 1,), from 0 to 1, the ends p + 1 times.
        added: which control points are not vertices of the path, shape (n,).
        pushed: which control points were pushed away from an obstacle, shape (n,).
        obstacles: what the curve should keep clear of.
        asked: distance it should keep from every obstacle, [unit].
    """

    degree: int
    control_points: FloatArray
    knots: FloatArray
    added: BoolArray
    pushed: BoolArray
    obstacles: ObstacleSet
    asked: float

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

    @cached_property
    def clearance(self) -> Clearance:
        """Distance to the obstacles, proven where it can be; fine to a millionth of the extent."""
        return prove(self, self.obstacles, self.asked, _finest(self.control_points))

    @property
    def holds(self) -> bool:
        """Whether it is proven that the curve keeps the distance asked for."""
        return self.clearance.keeps(self.asked)

    def __call__(self, parameter: ArrayLike, order: int = 0) -> FloatArray:
        """Point, or derivative of that order by the parameter; see :class:`abi.curves.curve.Curve`.

        Args:
            parameter: a number or shape (n,); clamped to [0, 1].
            order: of the derivative; above the degree it is 0.

        Returns:
            Shape (3,) for a number, (n, 3) for an array; [unit], world.
        """
        inside = np.asarray(np.clip(parameter, 0.0, 1.0), dtype=float)
        if order > self.degree:
            return np.zeros((*inside.shape, 3))
        found = np.empty(3 * inside.size)
        shape = (flat(self.knots), flat(self.control_points), self.degree)
        kernels.spline(*shape, flat(inside), order, found)
        return found.reshape(*inside.shape, 3)


def clamped(control_points: FloatArray, degree: int) -> BSpline:
    """B-spline with clamped, otherwise uniform knots, near no obstacle.

    Args:
        control_points: shape (n, 3), n > degree, [unit], world.
        degree: at least 1.
    """
    points = np.array(control_points, dtype=float)
    none = read_only(np.zeros(len(points), dtype=bool))
    knots = _uniform_knots(len(points), degree)
    return BSpline(degree, read_only(points), knots, none, none, NO_OBSTACLES, 0.0)


def fit(
    path_points: FloatArray,
    degree: int,
    obstacles: ObstacleSet,
    clearance: float,
    taut: bool = False,
) -> BSpline:
    """B-spline with the path's vertices as control points, kept clear of the obstacles.

    A spline lies in the convex hull of each degree + 1 neighbouring control points (de Boor, A
    Practical Guide to Splines, chapter IX), so it cuts the path's corners and may come nearer to
    an obstacle than the path. Where it does, the control points with influence there are pushed
    along the distance's gradient, which keeps the curve round; pushed points stay within the
    path's bounding box and the control polygon stays as clear as it must. Where that does not
    help, the edges of the polygon under the failing piece are halved: with edges of length h the
    curve is within degree·h of the polygon, so a path clearer than asked always ends in a curve
    that holds. Pushing is given up when it makes the curve longer than the path. When the path
    itself is not clearer than asked, the curve is kept about as clear as the path; ``holds`` says
    whether that is enough.

    Args:
        path_points: vertices, shape (k, 3) with k >= 2, [unit], world; first and last are the
            curve's ends.
        degree: asked for, at least 1; lowered to k - 1 when the path is too short for it.
        obstacles: what to keep clear of.
        clearance: distance to keep from every obstacle, [unit].
        taut: the path is taut, with few vertices: control points are added on its legs, so that the
            curve rounds the bends only as far as there is room; see ``abi.curves.control_points``.
            The degree is then never lowered.

    Returns:
        The spline; with ``holds`` False the clearest one found.
    """
    points = np.array(path_points, dtype=float)
    assert points.shape == (len(points), 3)
    assert len(points) >= 2
    added = np.zeros(len(points), dtype=bool)
    if taut:
        points, added = graded(points, degree, obstacles, clearance)
    degree = min(degree, len(points) - 1)
    none = read_only(np.zeros(len(points), dtype=bool))
    shape = degree, read_only(points), _uniform_knots(len(points), degree)
    spline = BSpline(*shape, read_only(added), none, obstacles, clearance)
    if not obstacles:
        return spline
    gap = obstacles.polyline_clearance(points) - clearance
    if gap >= -ROUNDING and obstacles.all_convex and spline.holds:
        return spline
    # Of the room between the path and the clearance asked for, the control polygon may lose half
    # and the measurement an eighth.
    tolerance = max(gap / 8, _finest(points))
    wanted = clearance + min(0.0, gap - 2 * tolerance)
    room = (wanted, clearance + min(gap, gap / 2), tolerance)
    cleared = _cleared(spline, *room, _PUSHES)
    longest = float(_edge_lengths(points).sum())
    if cleared is not spline and cleared.moved and arc_length(cleared).length > longest:
        cleared = _cleared(spline, *room, 0)
    return cleared if gap < -ROUNDING else _finished(cleared, room, longest)


def _finished(spline: BSpline, room: tuple[float, float, float], longest: float) -> BSpline:
    """Clear a curve more finely that misses what was asked for by no more than it was measured to.

    That happens where the path keeps just the clearance, or the end of a rounding.
    """
    # near a mesh, whose distance is not convex, measuring that finely takes seconds
    if spline.holds or not spline.obstacles.all_convex:
        return spline
    _, floor, tolerance = room
    finer = spline
    for _ in range(_FINER):
        if finer.holds or finer.clearance.nearest < finer.asked - 4 * tolerance:
            break
        tolerance /= 16
        finer = _cleared(finer, finer.asked - 2 * tolerance, floor, tolerance, _PUSHES)
    return finer if finer.holds and arc_length(finer).length <= longest else spline


def _cleared(
    spline: BSpline, wanted: float, floor: float, tolerance: float, most_pushes: int
) -> BSpline:
    """Push and refine until ``wanted`` is kept; the control polygon keeps ``floor``, [unit]."""
    aim = wanted + 2 * tolerance
    found = measure(spline, spline.obstacles, aim, tolerance)
    if found.distance >= wanted:
        return spline
    best, best_distance = spline, found.distance
    box = (spline.control_points.min(axis=0), spline.control_points.max(axis=0))
    pushes = 0
    for _ in range(_ROUNDS):
        if found.distance >= wanted or spline.inserted > _MOST_INSERTED:
            break
        worth = found.distance + _WORTH * (wanted - found.distance)
        pushed = _pushed(spline, found, aim, box) if pushes < most_pushes else None
        if pushed and spline.obstacles.polyline_clearance(pushed.control_points) < floor:
            pushed = None
        trial = measure(pushed, spline.obstacles, aim, tolerance) if pushed else found
        if pushed and trial.distance > worth:
            spline, found, pushes = pushed, trial, pushes + 1
        else:
            spline, pushes = _refined(spline, found), 0
            found = measure(spline, spline.obstacles, aim, tolerance)
        if found.distance > best_distance:
            best, best_distance = spline, found.distance
    return best


def _pushed(
    spline: BSpline, found: Clearance, aim: float, box: tuple[FloatArray, FloatArray]
) -> BSpline:
    """Move the inner control points outwards, within ``box``, to lift the curve to ``aim``."""
    parameters = np.linspace(*_failing(found), _SAMPLES).ravel()
    samples = spline(parameters)
    distance, gradient = spline.obstacles.outward(samples)
    lift = gradient * np.maximum(aim - distance, 0)[:, None]
    influence = _influence(spline, parameters)[:, 1:-1]
    # The steepest way to lift all samples at once: neighbours move alike, so that the polygon
    # stays smooth. The step is the one that lifts the worst sample as far as it needs.
    move = influence.T @ lift
    worst = int(distance.argmin())
    gained = float(lift[worst] @ (influence[worst] @ move))
    points = spline.control_points.copy()
    if gained > 0:
        points[1:-1] += move * (float(lift[worst] @ lift[worst]) / gained)
    points = np.clip(points, *box)
    pushed = spline.pushed | (points != spline.control_points).any(axis=1)
    return _changed(spline, points, spline.added, pushed)


def _influence(spline: BSpline, parameters: FloatArray) -> FloatArray:
    """Weights of the control points in the points at ``parameters`` (m,), shape (m, n)."""
    found = np.zeros(len(parameters) * len(spline.control_points))
    kernels.basis(flat(spline.knots), spline.degree, flat(parameters), found)
    return found.reshape(len(parameters), -1)


def _refined(spline: BSpline, found: Clearance) -> BSpline:
    """Halve the edges of the control polygon on which the failing pieces depend."""
    p, n = spline.degree, len(spline.control_points)
    start, end = _failing(found)
    first = np.clip(np.searchsorted(spline.knots, start, side="right") - 1, p, n - 1) - p
    last = np.clip(np.searchsorted(spline.knots, end, side="left") - 1, p, n - 1)
    # Edge k is under a piece when more intervals have opened up to it than closed before it.
    count = np.bincount(first, minlength=n) - np.bincount(last, minlength=n)
    lengths = _edge_lengths(spline.control_points)
    edges = np.flatnonzero((np.cumsum(count)[:-1] > 0) & (lengths > 0))
    middles = (spline.control_points[edges] + spline.control_points[edges + 1]) / 2
    return _changed(
        spline,
        np.insert(spline.control_points, edges + 1, middles, axis=0),
        np.insert(spline.added, edges + 1, True),
        np.insert(spline.pushed, edges + 1, False),
    )


def _changed(spline: BSpline, points: FloatArray, added: BoolArray, pushed: BoolArray) -> BSpline:
    return replace(
        spline,
        control_points=read_only(points),
        knots=_uniform_knots(len(points), spline.degree),
        added=read_only(added),
        pushed=read_only(pushed),
    )


def _failing(found: Clearance) -> tuple[FloatArray, FloatArray]:
    """First and last parameters (k,) of the stretches that are too near, at least one."""
    stretches = np.array(found.violations or ((found.at, found.at),))
    return stretches[:, 0], stretches[:, 1]


def _uniform_knots(count: int, degree: int) -> FloatArray:
    knots = np.ones(count + degree + 1)
    knots[:degree] = 0.0
    knots[degree : count + 1] = np.linspace(0, 1, count - degree + 1)
    return read_only(knots)


def _edge_lengths(points: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(np.diff(points, axis=0), axis=1))


def _finest(points: FloatArray) -> float:
    return _FINEST * float(np.linalg.norm(np.ptp(points, axis=0))) + ROUNDING
