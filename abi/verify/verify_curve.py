"""Check of the certificate of a curve in exact rational numbers.

The proof is that of :mod:`abi.curves.clearance.certificate`; here every inequality is decided
exactly, and the pieces must cover the whole curve for every obstacle.
"""

from __future__ import annotations

import itertools
from fractions import Fraction
from functools import partial
from typing import Any

from abi.errors import SceneError
from abi.scene.scene import Scene
from abi.verify.certificate import CertifiedPlane, claimed_margin, planes_of
from abi.verify.exact.mesh import ExactMesh
from abi.verify.exact.solids import ExactCurve, ExactSolid, Vec3, dot, hull
from abi.verify.fault import Fault
from abi.verify.plan_fields import mapping
from abi.verify.separation import check_apart
from abi.verify.tool_path import check_ends

_TOUCH = Fraction(1, 10**9)
"""Depth to which a curve may enter a primitive that is over 4 times as deep, [unit]."""

_GAP = Fraction(1, 10**9)
"""Largest gap between two pieces, times 1 [unit] and their largest coordinate."""


def check_curve(
    name: str,
    section: dict[str, Any],
    curve: ExactCurve,
    scene: Scene,
    obstacles: list[ExactSolid | ExactMesh],
) -> str:
    """Check the certificate of a plan's curve, and return what it proves as the end of a sentence.

    Raises:
        Fault: it does not prove what the plan claims.
        SceneError: a field has the wrong form.
    """
    required = Fraction(scene.spline.clearance)
    field = f"{name}.certificate"
    certificate = mapping(field, section["certificate"])
    planes = planes_of(field, certificate, partial(_obstacle, field, len(obstacles)))
    check_ends(curve, scene)
    starts, gap = _starts(curve)
    margin = claimed_margin(name, section, required, obstacles, _TOUCH)
    if margin is None:
        return "there is no obstacle"
    are_deep = all(map(_is_deep, obstacles))
    if margin < 0 and not are_deep:
        raise Fault("its margin is negative")
    if margin <= gap and (gap > _TOUCH or not are_deep):
        raise Fault("it keeps no distance from an obstacle, and may go through")
    span = curve[0].start, curve[-1].end
    for k, obstacle in enumerate(obstacles):
        label = f"obstacle {k + 1}"
        check_apart(label, planes.get(k, []), partial(_least, curve), span, obstacle, margin)
        if isinstance(obstacle, ExactMesh) and any(map(obstacle.inside, starts)):
            raise Fault(f"{label}: the curve begins inside")
    distance = f"{float(margin):.9g} {scene.unit}"
    if margin < required - _TOUCH:
        distance += f", less than the {float(required):g} {scene.unit} asked for,"
    number = "the obstacle" if len(obstacles) == 1 else f"all {len(obstacles)} obstacles"
    return f"it keeps {distance} from {number}, by {sum(map(len, planes.values()))} planes"


def _is_deep(solid: ExactSolid | ExactMesh) -> bool:
    return isinstance(solid, ExactSolid) and solid.depth > 4 * _TOUCH


def _least(curve: ExactCurve, plane: CertifiedPlane) -> Fraction:
    """Least product of a plane's direction with its piece of the curve."""
    points = hull(curve, plane.start, plane.end)
    if not points:
        piece = f"{float(plane.start):g} to {float(plane.end):g}"
        raise Fault(f"a piece from {piece} is not on the curve")
    return min(dot(plane.normal, at) for at in points)


def _starts(curve: ExactCurve) -> tuple[list[Vec3], Fraction]:
    """Points where the curve starts, and where it goes on after a gap of rounding; bound of gaps.

    Raises:
        Fault: it jumps farther.
    """
    starts, widest = [curve[0].bezier[0]], Fraction(0)
    for before, after in itertools.pairwise(curve):
        last, first = before.bezier[-1], after.bezier[0]
        if first != last:
            starts.append(first)
        largest = max(abs(number) for point in (last, first) for number in point)
        gap = max(abs(a - b) for a, b in zip(last, first, strict=True))
        if gap > _GAP * (1 + largest):
            raise Fault(f"the curve jumps at {float(after.start):g}")
        widest = max(widest, gap)
    return starts, 2 * widest  # over the root of three times that along one axis


def _obstacle(field: str, obstacles: int, entry: dict[str, Any]) -> int:
    """Number of the obstacle that an entry of a certificate names, of so many."""
    number = entry.get("obstacle")
    if type(number) is not int or not 0 <= number < obstacles:
        raise SceneError(f"{field}.planes.obstacle", number, "the number of an obstacle")
    return number
