"""Curves of a plan as written, each number taken exactly."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from abi.errors import SceneError
from abi.verify.exact.solids import ExactCurve, ExactSpan, exact_quadratic, exact_spline
from abi.verify.plan_fields import finite, list_of, mapping, numbers_of, vector_of

CURVES = ("bspline", "quadratic")


def curve_of(name: str, section: dict[str, Any]) -> ExactCurve:
    """Curve of :data:`CURVES` from its section of a plan.

    Raises:
        SceneError: a field has the wrong form.
    """
    if name == "bspline":
        degree = section.get("degree")
        if type(degree) is not int or not 1 <= degree <= 5:
            raise SceneError("bspline.degree", degree, "a whole number from 1 to 5")
        knots = numbers_of("bspline.knots", section.get("knots"))
        points = list_of("bspline.control_points", section.get("control_points"))
        control = [vector_of("bspline.control_points", point) for point in points]
        if len(knots) != len(control) + degree + 1 or len(control) <= degree:
            raise SceneError("bspline.knots", len(knots), "one for each control point and degree+1")
        if sorted(knots) != knots or knots[degree] >= knots[len(control)]:
            raise SceneError("bspline.knots", knots, "numbers that do not fall")
        return exact_spline(degree, [*map(Fraction, knots)], control)
    spans: list[ExactSpan] = []
    for piece in list_of("quadratic.pieces", section.get("pieces")):
        part = mapping("quadratic.pieces", piece)
        start, end = (finite("quadratic.pieces.t", part.get(key)) for key in ("t0", "t1"))
        rows = list_of("quadratic.pieces.coefficients", part.get("coefficients"))
        if len(rows) != 3 or start >= end or (spans and spans[-1].end != start):
            raise SceneError("quadratic.pieces", piece, "pieces of three rows, side by side")
        c0, c1, c2 = (vector_of("quadratic.pieces.coefficients", row) for row in rows)
        spans.append(exact_quadratic(Fraction(start), Fraction(end), c0, c1, c2))
    if not spans:
        raise SceneError("quadratic.pieces", [], "at least one piece")
    return spans
