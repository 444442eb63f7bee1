"""Stage 5: the quadratic curve, as in the paper, clear in one piece, or clear in several."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Literal

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.curves import fit_bspline
from abi.curves.bspline import BSpline
from abi.curves.clear_quadratic import PointsAt, Target, least_squares_target, nearest_clear
from abi.curves.fit import Fit, proven_fit
from abi.curves.quadratic import Quadratic, least_squares
from abi.obstacles.obstacle_set import ObstacleSet

Mode = Literal["least_squares", "clear", "pieces"]

_COUNTS = (2, 3, 4, 5, 6, 7, 8, 10, 13, 16, 20, 24)
MOST_PIECES = _COUNTS[-1]
"""Most pieces that are tried; the control polygon may give more."""

_DIRECTIONS = 48
_RADII = np.geomspace(0.02, 4, 12)  # of the curve's extent
_SAMPLES = 24
_STARTS = 3
_APART = 0.8  # cosine of the angle between two starts
_HALVINGS = 6


Accepts = Callable[[Quadratic], bool]
"""Further conditions on a curve that keeps the clearance."""


def fit(
    spline: Fit[BSpline],
    obstacles: ObstacleSet,
    clearance: float,
    mode: Mode,
    accepts: Accepts | None = None,
) -> Fit[Quadratic]:
    """Fit a curve of quadratic pieces to the B-spline, with the same ends.

    - ``least_squares``: one piece, :func:`abi.curves.quadratic.least_squares`, clear or not.
    - ``clear``: the least-squares curve if it is clear, else the nearest clear one that is found;
      in about one of a hundred random scenes another is nearer by 6 % or more.
    - ``pieces``: the curve of ``clear`` if there is one, else the fewest clear C¹ pieces found.

    Args:
        spline: the curve to approximate.
        obstacles: to keep clear of.
        clearance: distance to keep from every obstacle, [unit].
        mode: one of the three.
        accepts: a further condition, such as that the arm is clear along the curve, for all modes
            except ``least_squares``.

    Returns:
        The curve; if none is found, the least-squares curve with ``holds`` False and a ``note``.
    """
    quadratic = least_squares(spline.curve, spline.arc)
    fitted = proven_fit(quadratic, quadratic.extent, obstacles, clearance)
    if mode == "least_squares" or (fitted.holds and (accepts is None or accepts(quadratic))):
        return fitted
    single = nearest_single(quadratic, spline.at_share, obstacles, clearance, accepts)
    if single is not None:
        return single
    if mode == "clear":
        return replace(
            fitted,
            note="No single quadratic with these ends was found that keeps the clearance; "
            "mode pieces joins several.",
        )
    several = fewest_pieces(spline, obstacles, clearance, accepts)
    if several is not None:
        return several
    contrast = "; the B-spline does" if spline.holds else ": the B-spline does not"
    return replace(
        fitted, note=f"No quadratic pieces were found that keep the clearance{contrast}."
    )


def nearest_single(
    quadratic: Quadratic,
    curve: PointsAt,
    obstacles: ObstacleSet,
    clearance: float,
    accepts: Accepts | None = None,
) -> Fit[Quadratic] | None:
    """The clear quadratic nearest in L2 to ``quadratic`` among those searched, with its ends.

    Its one free control point is moved in 48 directions by 12 distances. From the nearest clear
    ones that lie apart, and from ``curve`` itself, the nearest clear curve is found by
    :func:`abi.curves.clear_quadratic.nearest_clear`.

    Args:
        quadratic: the least-squares quadratic of one piece, not clear.
        curve: points of the curve that it approximates, at shares of its arc length.
        obstacles, clearance: to keep clear of, and how far, [unit].
        accepts: a further condition. If the nearest clear curve does not meet it, the nearest of
            the moved ones that does is taken and brought nearer by halving its distance.
    """
    c0, c1, c2 = quadratic.coefficients[0]
    points = np.stack([c0, c0 + c1 / 2, c0 + c1 + c2])
    target = Target(quadratic.breaks, read_only(points), obstacles, clearance)
    found = _met(nearest_clear(target, [curve, *_starts(target)]), obstacles, clearance)
    if found is None or accepts is None or accepts(found.curve):
        return found
    return _nearest_met(target, accepts)


def fewest_pieces(
    spline: Fit[BSpline],
    obstacles: ObstacleSet,
    clearance: float,
    accepts: Accepts | None = None,
) -> Fit[Quadratic] | None:
    """The clear C¹ curve with the fewest quadratic pieces found, from two up.

    The quadratic B-spline on the control polygon, refined by :func:`abi.curves.fit_bspline.fit`,
    is clear when the polygon is clearer than required. With fewer pieces than that, the breaks are
    tried evenly along the B-spline and closer where it bends, and the curve passes the obstacles
    on the sides where the B-spline does: with every number of pieces up to 8, then in steps of a
    quarter up to 24, and with the numbers between the last two steps.

    Args:
        spline: the curve to approximate, of a length above 0.
        obstacles, clearance: to keep clear of, and how far, [unit].
        accepts: a further condition.
    """
    on_polygon = _on_the_polygon(spline.curve, obstacles, clearance)
    last = _met(on_polygon, obstacles, clearance, accepts)
    most = MOST_PIECES if last is None else min(MOST_PIECES, len(last.curve.pieces) - 1)
    tried = 1
    in_pieces = partial(_in_pieces, spline.at_share, obstacles, clearance, accepts)
    for pieces in (count for count in _COUNTS if count <= most):
        fitted = in_pieces(pieces)
        if fitted is not None:
            between = map(in_pieces, range(tried + 1, pieces))
            return next((fewer for fewer in between if fewer is not None), fitted)
        tried = pieces
    return last


def _in_pieces(
    curve: PointsAt,
    obstacles: ObstacleSet,
    clearance: float,
    accepts: Accepts | None,
    pieces: int,
) -> Fit[Quadratic] | None:
    """Clear curve with that many pieces near ``curve``, or None."""
    for breaks in (np.linspace(0, 1, pieces + 1), _closer_where_bent(curve, pieces)):
        target = least_squares_target(curve, read_only(breaks), obstacles, clearance)
        fitted = _met(nearest_clear(target, [curve]), obstacles, clearance, accepts)
        if fitted is not None:
            return fitted
    return None


def _on_the_polygon(spline: BSpline, obstacles: ObstacleSet, clearance: float) -> Quadratic | None:
    """Quadratic B-spline on the spline's control polygon, refined where needed, or None."""
    if spline.degree != 2:
        polygon = spline.control_points
        spline = fit_bspline.fit(polygon, 2, obstacles, clearance).curve
    if spline.degree < 2:
        return None
    return Quadratic.from_control_points(spline.control_points, spline.breaks)


def _nearest_met(target: Target, accepts: Accepts) -> Fit[Quadratic] | None:
    """The nearest moved curve that is clear and meets the conditions, brought nearer; or None."""
    directions, lacking = _moved(target)
    for shell, radius in enumerate((_RADII * target.extent).tolist()):
        for direction in directions[lacking[shell] <= 0]:
            moved = _by(target, radius * direction)
            fitted = _met(moved, target.obstacles, target.clearance, accepts)
            if fitted is not None:
                return _nearer(target, radius * direction, accepts, fitted)
    return None


def _nearer(
    target: Target, move: FloatArray, accepts: Accepts, fitted: Fit[Quadratic]
) -> Fit[Quadratic]:
    """The curve moved less in the same direction, as far as bisection finds."""
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        moved = _by(target, middle * move)
        nearer = _met(moved, target.obstacles, target.clearance, accepts)
        if nearer is None:
            low = middle
        else:
            high, fitted = middle, nearer
    return fitted


def _met(
    curve: Quadratic | None,
    obstacles: ObstacleSet,
    clearance: float,
    accepts: Accepts | None = None,
) -> Fit[Quadratic] | None:
    """The fit of a curve, if it is proven clear and meets the further condition, else None."""
    if curve is None:
        return None
    fitted = proven_fit(curve, curve.extent, obstacles, clearance)
    return fitted if fitted.holds and (accepts is None or accepts(curve)) else None


def _by(target: Target, move: FloatArray) -> Quadratic:
    """The target with its free control point displaced by (3,), [unit]."""
    control = target.control_points.copy()
    control[1] += move
    return Quadratic.from_control_points(control, target.breaks)


def _starts(target: Target) -> list[Quadratic]:
    """Displaced curves: the nearest that are clear at samples, then the clearest; all distinct."""
    directions, lacking = _moved(target)
    chosen: list[int] = []
    starts = []
    for number in lacking.argsort(axis=None, kind="stable"):
        radius, direction = divmod(int(number), _DIRECTIONS)
        if (directions[chosen] @ directions[direction] < _APART).all():
            chosen.append(direction)
            starts.append(_by(target, _RADII[radius] * target.extent * directions[direction]))
        if len(starts) == _STARTS:
            break
    return starts


def _moved(target: Target) -> tuple[FloatArray, FloatArray]:
    """Directions (48, 3), and the clearance missing after each of 12 displacements, (12, 48)."""
    directions = _sphere(_DIRECTIONS)
    free = target.control_points[1] + np.multiply.outer(_RADII * target.extent, directions)
    basis = target.basis(np.arange(1, _SAMPLES) / _SAMPLES)
    points = (basis[:, [0, 2]] @ target.control_points[[0, 2]])[:, None, None] + (
        basis[:, 1, None, None, None] * free
    )
    distance, _ = target.obstacles.nearest(points.reshape(-1, 3))
    lacking = np.maximum(target.aim - distance.reshape(points.shape[:3]).min(axis=0), 0)
    return directions, lacking


def _sphere(count: int) -> FloatArray:
    """Directions (count, 3) spread evenly: a Fibonacci lattice on the unit sphere."""
    k = np.arange(count)
    z = 1 - (2 * k + 1) / count
    azimuth = k * np.pi * (3 - np.sqrt(5))
    radius = np.sqrt(1 - z**2)
    return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), z], axis=1)


def _closer_where_bent(curve: PointsAt, pieces: int) -> FloatArray:
    """Breaks (pieces + 1,), half of them spaced by length and half by the turn of the tangent."""
    t = np.linspace(0, 1, 257)
    steps = np.diff(curve(t), axis=0)
    turns = np.linalg.norm(np.diff(steps, axis=0), axis=1)
    turned = np.concatenate([[0], np.cumsum(turns), [turns.sum()]])
    share = t + turned / (float(turned[-1]) or 1.0)
    return np.asarray(np.interp(np.linspace(0, share[-1], pieces + 1), share, t))
