"""Stage 4: a B-spline on the path's vertices, kept clear of the obstacles."""

from __future__ import annotations

import numpy as np

from abi import arguments
from abi.arrays import FloatArray
from abi.curves.bspline import BSpline, clamped
from abi.curves.clearance.curve_clearance import ROUNDING, Clearance, curve_clearance
from abi.curves.control_points import place_control_points
from abi.curves.curve import arc_length
from abi.curves.fit import Fit, clearance_tolerance, proven_fit
from abi.obstacles.obstacle_set import ObstacleSet

_ROUNDS = 60
_MOST_INSERTED = 2000
_PUSHES = 3  # in a row, before the polygon is refined
_LEAST_GAIN = 0.3  # of a push that is kept, as a part of the missing clearance
_REFINEMENTS = 3  # of a near miss
_SAMPLES = 8  # in each stretch that is too near


def fit(
    path_points: FloatArray,
    degree: int,
    obstacles: ObstacleSet,
    clearance: float,
    taut: bool = False,
    path_clearance: float | None = None,
) -> Fit[BSpline]:
    """B-spline with the path's vertices as control points, kept clear of the obstacles.

    A spline lies in the convex hull of each degree + 1 neighbouring control points (de Boor, A
    Practical Guide to Splines, chapter IX), so it cuts the path's corners and may come nearer to
    an obstacle than the path. Where it does, the control points with influence there are pushed
    along the distance's gradient, which keeps the curve round; pushed points stay within the
    path's bounding box and the control polygon stays as clear as it must. Where that does not
    help, the edges of the polygon under the failing piece are halved: with edges of length h the
    curve is within degree·h of the polygon, so a path clearer than required always ends in a curve
    that holds. Pushing is given up when it makes the curve longer than the path. When the path
    itself is not clearer than that, the curve is kept about as clear as the path; ``holds`` says
    whether that is enough.

    Args:
        path_points: vertices, shape (k, 3) with k >= 2, [unit], world; first and last are the
            curve's ends.
        degree: at least 1; lowered to k - 1 when the path is too short for it.
        obstacles: to keep clear of.
        clearance: distance to keep from every obstacle, [unit].
        taut: the path is taut, with few vertices: control points are added on its legs, so that the
            curve rounds the bends only as far as there is room; see ``abi.curves.control_points``.
            The degree is then never lowered.
        path_clearance: the path's own distance to the obstacles, [unit], where it is known.

    Returns:
        The spline and its clearance; with ``holds`` False it is the clearest one found.
    """
    points = arguments.polyline("path_points", path_points)
    degree = arguments.integer("degree", degree, 1, arguments.LARGEST_ID)
    clearance = arguments.number("clearance", clearance)
    added = np.zeros(len(points), dtype=bool)
    if taut:
        points, added = place_control_points(points, degree, obstacles, clearance)
    direct, fitted = clamped(points, min(degree, len(points) - 1), added), None
    if path_clearance is None:
        path_clearance = obstacles.polyline_clearance(points)
    gap = path_clearance - clearance
    if gap >= -ROUNDING and obstacles.all_convex:
        fitted = proven_fit(direct, direct.extent, obstacles, clearance)
        if fitted.holds:
            return fitted
    # Of the room between the path and the clearance, the control polygon may lose half
    # and the measurement an eighth.
    tolerance = max(gap / 8, clearance_tolerance(direct.extent))
    least = clearance + min(0.0, gap - 2 * tolerance)
    of_polygon = clearance + min(gap, gap / 2)
    cleared = _cleared(direct, obstacles, least, of_polygon, tolerance)
    longest = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    if cleared.moved and arc_length(cleared).length > longest:
        cleared = _cleared(direct, obstacles, least, of_polygon, tolerance, most_pushes=0)
    if fitted is None or cleared is not direct:
        fitted = proven_fit(cleared, cleared.extent, obstacles, clearance)
    # near a mesh, whose distance is not convex, measuring more finely takes seconds
    if fitted.holds or gap < -ROUNDING or not obstacles.all_convex:
        return fitted
    return _finished(fitted, obstacles, of_polygon, tolerance, longest)


def _finished(
    fitted: Fit[BSpline],
    obstacles: ObstacleSet,
    of_polygon: float,
    tolerance: float,
    longest: float,
) -> Fit[BSpline]:
    """Move a curve that misses the clearance by no more than the tolerance in finer steps.

    That happens where the path keeps just the clearance, or the end of a rounding. Of several
    arguments see :func:`_cleared`; the curve gets no longer than ``longest``, [unit].
    """
    required, finer = fitted.required, fitted
    for _ in range(_REFINEMENTS):
        if finer.holds or finer.clearance.nearest < required - 4 * tolerance:
            break
        tolerance /= 16
        least = required - 2 * tolerance
        cleared = _cleared(finer.curve, obstacles, least, of_polygon, tolerance)
        if cleared is not finer.curve:
            finer = proven_fit(cleared, cleared.extent, obstacles, required)
    return finer if finer.holds and finer.arc.length <= longest else fitted


def _cleared(
    spline: BSpline,
    obstacles: ObstacleSet,
    least: float,
    of_polygon: float,
    tolerance: float,
    most_pushes: int = _PUSHES,
) -> BSpline:
    """Push and refine until the clearance is kept; otherwise the clearest curve seen.

    Args:
        spline: to begin with.
        obstacles: to keep clear of.
        least: distance to keep, [unit].
        of_polygon: distance that the control polygon keeps while points are pushed, [unit].
        tolerance: of the curve's measured distance, [unit].
        most_pushes: in a row, before the polygon is refined.
    """
    # pushes aim at a little more; stretches nearer than that are measured
    aim = least + 2 * tolerance
    measured = curve_clearance(spline, obstacles, aim, tolerance)
    best, best_distance = spline, measured.distance
    box = (spline.control_points.min(axis=0), spline.control_points.max(axis=0))
    pushes = 0
    for _ in range(_ROUNDS):
        if measured.distance >= least or spline.inserted > _MOST_INSERTED:
            break
        enough = measured.distance + _LEAST_GAIN * (least - measured.distance)
        pushed = None
        if pushes < most_pushes:
            pushed = _pushed(spline, measured, obstacles, aim, box)
        if pushed and obstacles.polyline_clearance(pushed.control_points) < of_polygon:
            pushed = None
        trial = curve_clearance(pushed, obstacles, aim, tolerance) if pushed else measured
        if pushed and trial.distance > enough:
            spline, measured, pushes = pushed, trial, pushes + 1
        else:
            spline, pushes = _refined(spline, measured), 0
            measured = curve_clearance(spline, obstacles, aim, tolerance)
        if measured.distance > best_distance:
            best, best_distance = spline, measured.distance
    return best


def _pushed(
    spline: BSpline,
    measured: Clearance,
    obstacles: ObstacleSet,
    aim: float,
    box: tuple[FloatArray, FloatArray],
) -> BSpline:
    """Move the inner control points outwards, within ``box``, to lift the curve to the aim."""
    parameters = np.linspace(*_failing(measured), _SAMPLES).ravel()
    distance, gradient = obstacles.signed_distance_gradient(spline(parameters))
    lift = gradient * np.maximum(aim - distance, 0)[:, None]
    influence = spline.influence(parameters)[:, 1:-1]
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
    return clamped(points, spline.degree, spline.added, pushed)


def _refined(spline: BSpline, measured: Clearance) -> BSpline:
    """Halve the edges of the control polygon on which the failing pieces depend."""
    p, n = spline.degree, len(spline.control_points)
    start, end = _failing(measured)
    first = np.clip(np.searchsorted(spline.knots, start, side="right") - 1, p, n - 1) - p
    last = np.clip(np.searchsorted(spline.knots, end, side="left") - 1, p, n - 1)
    # Edge k is under a piece when more intervals have opened up to it than closed before it.
    count = np.bincount(first, minlength=n) - np.bincount(last, minlength=n)
    return spline.refined(np.flatnonzero(np.cumsum(count)[:-1] > 0))


def _failing(measured: Clearance) -> tuple[FloatArray, FloatArray]:
    """First and last parameters (k,) of the stretches that are too near, at least one."""
    stretches = np.array(measured.violations or ((measured.at, measured.at),))
    return stretches[:, 0], stretches[:, 1]
