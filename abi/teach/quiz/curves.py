"""Questions about B-splines and knots."""

from __future__ import annotations

import numpy as np

from abi.curves.bspline import BSpline, clamped
from abi.teach.numbers import point
from abi.teach.quiz.question import QuizQuestion, chosen, of_count

_MOVED = 1e-9


def pieces_moved(random: np.random.Generator) -> QuizQuestion:
    """How many pieces of a curve change with one control point?"""
    curve = _curve(random)
    count = len(curve.control_points)
    number = int(random.integers(0, count))
    middles = (curve.breaks[1:] + curve.breaks[:-1]) / 2
    moved = int((curve.influence(middles)[:, number] > _MOVED).sum())
    return of_count(
        random,
        f"A clamped B-spline of degree {curve.degree} has {count} control points and uniform "
        f"knots. The control point number {number + 1} is moved. How many of its {len(middles)} "
        "polynomial pieces change?",
        moved,
        [curve.degree, curve.degree + 1, 1, len(middles)],
        f"A control point counts in {curve.degree + 1} spans of knots, and at the ends of a "
        f"clamped curve some of them have no length; what is left here: {moved}.",
        {"degree": curve.degree, "points": count, "number": number},
    )


def points_influencing(random: np.random.Generator) -> QuizQuestion:
    """How many control points move a point of the curve?"""
    curve = _curve(random)
    spans = len(curve.breaks) - 1
    share = round(float(random.uniform(0.05, 0.95)), 2)
    while np.abs(curve.breaks - share).min() < 1e-3:
        share = round(float(random.uniform(0.05, 0.95)), 2)
    count = int((curve.influence(np.array([share]))[0] > _MOVED).sum())
    points = len(curve.control_points)
    return of_count(
        random,
        f"A clamped B-spline of degree {curve.degree} has {points} control points and "
        f"{spans} pieces. On how many of the control points does the point at the parameter "
        f"{share:g}, inside a piece, depend?",
        count,
        [curve.degree, points],
        f"On degree + 1 = {count}: each piece is made by so many.",
        {"degree": curve.degree, "points": points, "parameter": share},
    )


def points_after_knot(random: np.random.Generator) -> QuizQuestion:
    """How many control points of the refined curve are new?"""
    curve = _curve(random)
    place = round(float(random.uniform(0.05, 0.95)), 2)
    while np.abs(curve.breaks - place).min() < 1e-3:
        place = round(float(random.uniform(0.05, 0.95)), 2)
    points = len(curve.control_points)
    return of_count(
        random,
        f"A knot is inserted at {place:g}, where there was none, into a B-spline of degree "
        f"{curve.degree} with {points} control points. How many control points of the same curve "
        "are then at new places?",
        curve.degree,
        [1, curve.degree + 1, curve.degree - 1],
        f"{curve.degree} new ones take the place of {curve.degree - 1} old ones; all others stay.",
        {"degree": curve.degree, "points": curve.control_points.tolist(), "place": place},
    )


def point_of_curve(random: np.random.Generator) -> QuizQuestion:
    """Where is a point of a quadratic B-spline?"""
    while True:
        corners = random.integers(0, 7, (4, 3)).astype(float)
        share = float(random.choice([0.25, 0.5, 0.75]))
        curve = clamped(corners, 2)
        place = curve(share)
        polygon = corners[0] + share * (corners[3] - corners[0])
        leg = corners[1] + share * (corners[2] - corners[1])
        wrong = [polygon, leg, (corners[1] + corners[2]) / 2, corners.mean(axis=0)]
        words = [point(one) for one in wrong]
        if len({point(place), *words}) == 5:
            break
    told = ", ".join(point(corner) for corner in corners)
    return chosen(
        random,
        f"A clamped B-spline of degree 2 with uniform knots 0, 0, 0, 0.5, 1, 1, 1 has the control "
        f"points {told}. Where is it at the parameter {share:g}?",
        point(place),
        words,
        f"De Boor's algorithm takes means of neighbours twice and comes to {point(place)}.",
        {"points": corners.tolist(), "parameter": share},
    )


def _curve(random: np.random.Generator) -> BSpline:
    degree = int(random.integers(2, 5))
    count = degree + int(random.integers(3, 7))
    return clamped(random.uniform(0.0, 6.0, (count, 3)).round(1), degree)
