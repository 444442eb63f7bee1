"""Stage 5's three ways to a quadratic curve: as the paper, clear in one piece, clear in several."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.curves import bspline, quadratic
from abi.curves.bspline import BSpline
from abi.curves.clear_quadratic import ByLength, Target, nearest_clear, target
from abi.curves.curve import ArcLength
from abi.curves.quadratic import Quadratic
from abi.curves.quadratics import Quadratics, join
from abi.obstacles.obstacle_set import ObstacleSet

Mode = Literal["least_squares", "clear", "pieces"]

_COUNTS = (2, 3, 4, 5, 6, 7, 8, 10, 13, 16, 20, 24)
MOST_PIECES = _COUNTS[-1]
"""More pieces than these only on the control polygon."""

_DIRECTIONS = 48
_RADII = np.geomspace(0.02, 4, 12)  # of the curve's extent
_SAMPLES = 24
_STARTS = 3
_APART = 0.8  # cosine of the angle between two starts


def fit(
    spline: BSpline, arc: ArcLength, obstacles: ObstacleSet, clearance: float, mode: Mode
) -> Quadratic | Quadratics:
    """A curve of quadratic pieces near the B-spline and with its ends.

    - ``least_squares``: one piece, :func:`abi.curves.quadratic.fit`, whether it is clear or not.
    - ``clear``: that one where it is clear, else the clear one nearest to it.
    - ``pieces``: that one where there is one, else the fewest pieces found that are clear and C¹.

    Args:
        spline: the curve to approximate.
        arc: its arc length.
        obstacles: what to keep clear of.
        clearance: distance to keep from every obstacle, [unit].
        mode: one of the three.

    Returns:
        The curve. When none is found the least-squares curve, with ``holds`` False and a ``note``.
    """
    square = quadratic.fit(spline, arc, obstacles, clearance)
    if square.holds or mode == "least_squares":
        return square
    shape = ByLength(spline, arc)
    found = nearest_single(square, shape)
    if found is not None:
        return found
    if mode == "clear":
        return replace(
            square,
            note="No single quadratic with these ends was found that keeps the clearance; "
            "mode pieces joins several.",
        )
    several = fewest_pieces(spline, shape, obstacles, clearance)
    if several is not None:
        return several
    does = "; the B-spline does" if spline.holds else ": the B-spline does not"
    return replace(square, note=f"No quadratic pieces were found that keep the clearance{does}.")


def nearest_single(square: Quadratic, shape: ByLength) -> Quadratic | None:
    """The clear quadratic nearest in L2 to ``square``, with its ends, as far as searched.

    Its one free control point is moved in 48 directions by 12 distances. From the nearest clear
    ones that lie apart, and from the way ``shape`` passes the obstacles, the nearest clear curve
    is found by :func:`abi.curves.clear_quadratic.nearest_clear`.

    Args:
        square: the least-squares quadratic, not clear.
        shape: the curve it approximates.
    """
    c0, c1, c2 = square.coefficients
    points = np.stack([c0, c0 + c1 / 2, c0 + c1 + c2])
    breaks = read_only(np.array([0.0, 1.0]))
    wanted = Target(breaks, read_only(points), square.obstacles, square.asked)
    found = nearest_clear(wanted, [shape, *_starts(wanted)])
    if found is None:
        return None
    single = replace(square, coefficients=read_only(found.coefficients[0].copy()))
    return single if single.holds else None


def fewest_pieces(
    spline: BSpline, shape: ByLength, obstacles: ObstacleSet, clearance: float
) -> Quadratics | None:
    """The clear C¹ curve of the fewest quadratic pieces found, from two up.

    The quadratic B-spline on the control polygon, refined by :func:`abi.curves.bspline.fit`, is
    clear when the polygon is clearer than asked. With fewer pieces than that, the breaks are tried
    evenly along the B-spline and closer where it bends, and the curve passes the obstacles on the
    sides where the B-spline does: with every number of pieces up to 8, then in steps of a quarter
    up to 24, and with the numbers between the last two steps.

    Args:
        spline: the curve to approximate, of a length above 0.
        shape: the same as a function of its arc length.
        obstacles: what to keep clear of.
        clearance: distance to keep from every obstacle, [unit].
    """
    last = _on_the_polygon(spline, obstacles, clearance)
    most = MOST_PIECES if last is None else min(MOST_PIECES, len(last.pieces) - 1)
    tried = 1
    for pieces in (count for count in _COUNTS if count <= most):
        found = _in_pieces(pieces, shape, obstacles, clearance)
        if found is not None:
            between = (_in_pieces(k, shape, obstacles, clearance) for k in range(tried + 1, pieces))
            return next((fewer for fewer in between if fewer is not None), found)
        tried = pieces
    return last


def _in_pieces(
    pieces: int, shape: ByLength, obstacles: ObstacleSet, clearance: float
) -> Quadratics | None:
    """A clear curve of so many pieces near ``shape``, or None."""
    for breaks in (np.linspace(0, 1, pieces + 1), _closer_where_bent(shape, pieces)):
        wanted = target(shape, read_only(breaks), obstacles, clearance)
        found = nearest_clear(wanted, [shape])
        if found is not None and found.holds:
            return found
    return None


def _on_the_polygon(spline: BSpline, obstacles: ObstacleSet, clearance: float) -> Quadratics | None:
    """The clear quadratic B-spline on the spline's control points, halved where needed, or None."""
    if spline.degree != 2:
        spline = bspline.fit(spline.control_points, 2, obstacles, clearance)
    if spline.degree < 2:
        return None
    curve = join(spline.control_points, spline.breaks, obstacles, clearance)
    return curve if curve.holds else None


def _starts(wanted: Target) -> list[Quadratics]:
    """Moved curves: the nearest that are clear at samples, then the clearest; all apart."""
    directions = _sphere(_DIRECTIONS)
    free = wanted.control_points[1] + np.multiply.outer(_RADII * wanted.extent, directions)
    basis = wanted.basis(np.arange(1, _SAMPLES) / _SAMPLES)
    points = (basis[:, [0, 2]] @ wanted.control_points[[0, 2]])[:, None, None] + (
        basis[:, 1, None, None, None] * free
    )
    distance, _ = wanted.obstacles.nearest(points.reshape(-1, 3))
    lacking = np.maximum(wanted.aim - distance.reshape(points.shape[:3]).min(axis=0), 0)
    chosen: list[int] = []
    starts = []
    for place in lacking.argsort(axis=None, kind="stable"):
        radius, direction = divmod(int(place), _DIRECTIONS)
        if (directions[chosen] @ directions[direction] < _APART).all():
            chosen.append(direction)
            control = wanted.control_points.copy()
            control[1] = free[radius, direction]
            starts.append(join(control, wanted.breaks, wanted.obstacles, wanted.asked))
        if len(starts) == _STARTS:
            break
    return starts


def _sphere(count: int) -> FloatArray:
    """Directions (count, 3) spread evenly: a Fibonacci lattice on the unit sphere."""
    k = np.arange(count)
    z = 1 - (2 * k + 1) / count
    turn = k * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - z**2)
    return np.stack([across * np.cos(turn), across * np.sin(turn), z], axis=1)


def _closer_where_bent(shape: ByLength, pieces: int) -> FloatArray:
    """Breaks (pieces + 1,), half of them shared out by length and half by the turn of tangents."""
    t = np.linspace(0, 1, 257)
    steps = np.diff(shape(t), axis=0)
    turns = np.linalg.norm(np.diff(steps, axis=0), axis=1)
    turned = np.concatenate([[0], np.cumsum(turns), [turns.sum()]])
    share = t + turned / (float(turned[-1]) or 1.0)
    return np.asarray(np.interp(np.linspace(0, share[-1], pieces + 1), share, t))
