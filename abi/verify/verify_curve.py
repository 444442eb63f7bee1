"""Check of the certificate of a curve in exact rational numbers.

The proof is that of :mod:`abi.clearance.certificate`; here every inequality is decided exactly, and
the pieces must cover the whole curve for every obstacle.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from abi.errors import SceneError
from abi.scene.scene import Scene
from abi.verify.exact import ExactCurve, ExactSolid, Vec3, dot, hull
from abi.verify.exact_mesh import ExactMesh
from abi.verify.fault import Fault
from abi.verify.plan_fields import finite, list_of, mapping, number_of, vector_of
from abi.verify.sides import check_apart
from abi.verify.tool_path import check_ends

_TOUCH = Fraction(1, 10**9)
"""Depth to which a curve may enter a primitive that is over 4 times as deep, [unit]."""


_Plane = tuple[Fraction, Fraction, Vec3]
"""Ends of a piece of the curve, and the direction that separates it."""


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
    margin, planes = _certificate(field, mapping(field, section["certificate"]), len(obstacles))
    check_ends(curve, scene)
    _check_claim(section, margin, required)
    _check_margin(margin, obstacles)
    if margin is None:
        return "there is no obstacle"
    for k, obstacle in enumerate(obstacles):
        try:
            _check_obstacle(curve, obstacle, planes[k], margin)
        except Fault as fault:
            raise Fault(f"obstacle {k + 1}: {fault}") from None
    distance = f"{float(margin):.9g} {scene.unit}"
    if margin < required - _TOUCH:
        distance += f", less than the {float(required):g} {scene.unit} asked for,"
    number = "the obstacle" if len(obstacles) == 1 else f"all {len(obstacles)} obstacles"
    return f"it keeps {distance} from {number}, by {sum(map(len, planes))} planes"


def _check_claim(section: dict[str, Any], margin: Fraction | None, required: Fraction) -> None:
    stated = section.get("clearance")
    if (stated is None) != (margin is None) or (margin is not None and number_of(stated) != margin):
        raise Fault("its margin is not the clearance stated")
    enough = margin is None or margin >= required - _TOUCH
    if section.get("certified") is not enough:
        claim = "said to be certified" if not enough else "not said to be certified"
        raise Fault(f"as the curve is {claim}")


def _check_margin(margin: Fraction | None, obstacles: list[ExactSolid | ExactMesh]) -> None:
    if (margin is None) != (not obstacles):
        raise Fault("a margin belongs to obstacles")
    if margin is None or margin >= 0:
        return
    deep = all(isinstance(solid, ExactSolid) and solid.depth > 4 * _TOUCH for solid in obstacles)
    if margin < -_TOUCH or not deep:
        raise Fault("its margin is negative")


def _check_obstacle(
    curve: ExactCurve, obstacle: ExactSolid | ExactMesh, planes: list[_Plane], margin: Fraction
) -> None:
    sides = []
    for start, end, normal in planes:
        points = hull(curve, start, end) if start < end else []
        if not points:
            raise Fault(f"a piece from {float(start):g} to {float(end):g} is not on the curve")
        sides.append((start, end, normal, min(dot(normal, at) for at in points)))
    check_apart(sides, (curve[0].start, curve[-1].end), obstacle, margin)
    if isinstance(obstacle, ExactMesh) and any(obstacle.inside(point) for point in _starts(curve)):
        raise Fault("the curve begins inside")


def _starts(curve: ExactCurve) -> list[Vec3]:
    """Points where the curve starts, and where it goes on after a jump."""
    starts: list[Vec3] = []
    before = None
    for span in curve:
        if span.bezier[0] != before:
            starts.append(span.bezier[0])
        before = span.bezier[-1]
    return starts


def _certificate(
    field: str, data: dict[str, Any], obstacles: int
) -> tuple[Fraction | None, list[list[_Plane]]]:
    """Margin of a certificate, and its planes by obstacle, in order."""
    margin = data.get("margin")
    planes: list[list[_Plane]] = [[] for _ in range(obstacles)]
    for entry in list_of(f"{field}.planes", data.get("planes")):
        plane = mapping(f"{field}.planes", entry)
        number = plane.get("obstacle")
        if type(number) is not int or not 0 <= number < obstacles:
            raise SceneError(f"{field}.planes.obstacle", number, "the number of an obstacle")
        start, end = (
            Fraction(finite(f"{field}.planes.{key}", plane.get(key))) for key in ("t0", "t1")
        )
        normal = vector_of(f"{field}.planes.direction", plane.get("direction"))
        planes[number].append((start, end, normal))
    return None if margin is None else Fraction(finite(f"{field}.margin", margin)), [
        sorted(group) for group in planes
    ]
