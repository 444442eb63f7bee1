"""Check of a plan's certificates in exact rational numbers.

The plan is checked as written: its curves' knots, control points and coefficients, its scene's
obstacles and its certificates' planes, each number taken exactly. No code that makes certificates
is used; mesh files are read and repaired as for planning. The proof is that of
:mod:`abi.clearance.certificate`; here every inequality is decided exactly, and the pieces must
cover the whole curve for every obstacle.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, ParamSpec

from abi import assets
from abi.errors import SceneError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.primitives import Box, Capsule, Cylinder, Sphere
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.obstacles.triangle_mesh.surface import Surface
from abi.scene.scene import Scene
from abi.verify.exact import (
    ExactCurve,
    ExactQuadratics,
    ExactSolid,
    ExactSpline,
    Vec3,
    dot,
    hull,
)
from abi.verify.exact_mesh import ExactMesh
from abi.verify.fault import Fault
from abi.verify.plan_fields import finite, list_of, mapping, number_of, numbers_of, vector_of
from abi.verify.tool_path import check_ends
from abi.verify.verify_arm import check_arm
from abi.verify.verify_chain import check_chain

_P = ParamSpec("_P")

CURVES = ("bspline", "quadratic")

_TOUCH = Fraction(1, 10**9)
"""Depth to which a curve may enter a primitive that is over 4 times as deep, [unit]."""


@dataclass(frozen=True)
class Verdict:
    """Verdict on one curve, or on the arm that follows it.

    Attributes:
        curve: ``bspline``, ``quadratic`` or ``arm``.
        proven: whether its certificate proves what the plan claims.
        reason: what is proven, or why it is not, as the end of a sentence.
    """

    curve: str
    proven: bool
    reason: str

    def __str__(self) -> str:
        return f"{self.curve}: {'proven' if self.proven else 'NOT proven'}: {self.reason}"


@dataclass(frozen=True)
class _Plane:
    start: float
    end: float
    normal: Vec3


class PlanMeshes(MeshSource):
    """Mesh files beside a plan, or else those of the shipped scenes.

    Attributes:
        shipped: names of the files taken from the shipped scenes.
    """

    def __init__(self, folder: Path) -> None:
        super().__init__(folder=folder)
        self.shipped: list[str] = []
        self._folder = folder

    def surface(self, name: str) -> Surface:
        """Source of the meshes, as in :class:`MeshSource`."""
        try:
            return super().surface(name)
        except SceneError as error:
            # a file that is there but is no mesh is what was meant
            if not (self._folder / name).exists():
                with contextlib.suppress(SceneError):
                    surface = MeshSource(folder=assets.path("scenes")).surface(name)
                    self.shipped.append(name)
                    return surface
            expected = f"{error.expected}, beside the plan or in the folder of --meshes"
            raise SceneError(error.field, name, expected) from None


def verify(plan: object, folder: Path | MeshSource | None = None) -> tuple[Verdict, ...]:
    """Check every curve of a plan, and the arm.

    Args:
        plan: the result of ``Plan.to_dict``, as it is or read back from JSON.
        folder: source of the scene's mesh files; None for a scene without files.

    Raises:
        SceneError: ``plan`` is no plan; names the field that is wrong.
    """
    if not isinstance(plan, dict) or not all(name in plan for name in ("scene", *CURVES)):
        raise SceneError("plan", plan, "a plan as abi plan writes it")
    if type(version := plan.get("version")) is not int or version != 1:
        raise SceneError("version", version, "1")
    scene = Scene.from_dict(plan["scene"], folder)
    obstacles = _obstacles(plan["scene"], scene)
    verdicts = [_verdict(name, plan[name], obstacles, scene) for name in CURVES]
    if "arm" in plan:
        verdicts.append(_arm_verdict(plan, scene, obstacles))
    return tuple(verdicts)


def _arm_verdict(
    plan: dict[str, Any], scene: Scene, obstacles: list[ExactSolid | ExactMesh]
) -> Verdict:
    if plan["arm"] is None:
        return Verdict("arm", False, "the plan has no motion")
    section, timing = mapping("arm", plan["arm"]), mapping("timing", plan.get("timing"))
    if section.get("certificate") is None:
        claim = "it claims to be certified but" if section.get("certified") else "it"
        return Verdict("arm", False, f"{claim} carries no certificate")
    if scene.arm.model == "urdf":
        return _checked(check_chain, section, scene, obstacles)
    name = timing.get("curve")
    if name not in CURVES:
        raise SceneError("timing.curve", name, f"one of {', '.join(CURVES)}")
    curve = _curve(name, mapping(name, plan[name]))
    return _checked(check_arm, section, timing, curve, scene, obstacles)


def _checked(check: Callable[_P, str], *args: _P.args, **kwargs: _P.kwargs) -> Verdict:
    try:
        return Verdict("arm", True, check(*args, **kwargs))
    except Fault as fault:
        return Verdict("arm", False, f"its certificate is wrong, {fault}")


def _verdict(
    name: str, section: Any, obstacles: list[ExactSolid | ExactMesh], scene: Scene
) -> Verdict:
    if section is None:
        return Verdict(name, False, "the plan has no such curve")
    required = Fraction(scene.spline.clearance)
    curve = _curve(name, mapping(name, section))
    certificate = section.get("certificate")
    if certificate is None:
        claim = "it claims to be certified but" if section.get("certified") else "it"
        return Verdict(name, False, f"{claim} carries no certificate")
    required = Fraction(scene.spline.clearance)
    field = f"{name}.certificate"
    margin, planes = _certificate(field, mapping(field, certificate), len(obstacles))
    try:
        check_ends(curve, scene)
        _check_claim(section, margin, required)
        _check_margin(margin, obstacles)
        for k, obstacle in enumerate(obstacles):
            assert margin is not None
            try:
                _check_obstacle(curve, obstacle, planes[k], margin)
            except Fault as fault:
                raise Fault(f"obstacle {k + 1}: {fault}") from None
    except Fault as fault:
        return Verdict(name, False, f"its certificate is wrong, {fault}")
    if margin is None:
        return Verdict(name, True, "there is no obstacle")
    distance = f"{float(margin):.9g} {scene.unit}"
    if margin < required - _TOUCH:
        distance += f", less than the {float(required):g} {scene.unit} asked for,"
    number = "the obstacle" if len(obstacles) == 1 else f"all {len(obstacles)} obstacles"
    count = sum(map(len, planes))
    return Verdict(name, True, f"it keeps {distance} from {number}, by {count} planes")


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
    spans = curve.spans
    first, last = spans[0][0], spans[-1][1]
    planes = sorted(planes, key=lambda plane: plane.start)
    sides = []
    for plane in planes:
        start, end = Fraction(plane.start), Fraction(plane.end)
        points = hull(curve, start, end) if start < end else []
        if not points:
            raise Fault(f"a piece from {plane.start:g} to {plane.end:g} is not on the curve")
        sides.append((start, end, plane.normal, min(dot(plane.normal, at) for at in points)))
    if isinstance(obstacle, ExactMesh):
        if (at := obstacle.uncovered(sides, first, last, margin)) is not None:
            raise Fault(f"nothing separates a triangle from the curve at {float(at):g}")
        if obstacle.closed and any(obstacle.inside(point) for point in _starts(curve)):
            raise Fault("the curve begins inside")
        return
    reached = first
    for start, end, normal, least in sides:
        if start > reached:
            break
        if not obstacle.separated(normal, least, margin):
            raise Fault(f"the piece from {float(start):g} to {float(end):g} is not separated")
        reached = max(reached, end)
    if reached < last:
        raise Fault(f"no piece covers the curve after {float(reached):g}")


def _starts(curve: ExactCurve) -> list[Vec3]:
    """Points where the curve starts, and where it goes on after a jump."""
    starts: list[Vec3] = []
    before = None
    for start, end, span in curve.spans:
        points = curve.points(span, start, end)
        if points[0] != before:
            starts.append(points[0])
        before = points[-1]
    return starts


def _curve(name: str, section: dict[str, Any]) -> ExactCurve:
    if name == "bspline":
        degree = section.get("degree")
        if type(degree) is not int or not 1 <= degree <= 20:
            raise SceneError("bspline.degree", degree, "a whole number from 1 to 20")
        knots = numbers_of("bspline.knots", section.get("knots"))
        points = list_of("bspline.control_points", section.get("control_points"))
        control = tuple(vector_of("bspline.control_points", point) for point in points)
        if len(knots) != len(control) + degree + 1 or len(control) <= degree:
            raise SceneError("bspline.knots", len(knots), "one for each control point and degree+1")
        if sorted(knots) != knots or knots[degree] >= knots[len(control)]:
            raise SceneError("bspline.knots", knots, "numbers that do not fall")
        return ExactSpline(degree, tuple(map(Fraction, knots)), control)
    ends: list[tuple[Fraction, Fraction]] = []
    coefficients: list[tuple[Vec3, Vec3, Vec3]] = []
    for piece in list_of("quadratic.pieces", section.get("pieces")):
        part = mapping("quadratic.pieces", piece)
        start, end = (finite("quadratic.pieces.t", part.get(key)) for key in ("t0", "t1"))
        rows = list_of("quadratic.pieces.coefficients", part.get("coefficients"))
        if len(rows) != 3 or start >= end or (ends and ends[-1][1] != start):
            raise SceneError("quadratic.pieces", piece, "pieces of three rows, side by side")
        ends.append((Fraction(start), Fraction(end)))
        c0, c1, c2 = (vector_of("quadratic.pieces.coefficients", row) for row in rows)
        coefficients.append((c0, c1, c2))
    if not ends:
        raise SceneError("quadratic.pieces", [], "at least one piece")
    return ExactQuadratics(tuple(ends), tuple(coefficients))


def _certificate(
    field: str, data: dict[str, Any], obstacles: int
) -> tuple[Fraction | None, list[list[_Plane]]]:
    """Margin of a certificate, and its planes by obstacle."""
    margin = data.get("margin")
    planes: list[list[_Plane]] = [[] for _ in range(obstacles)]
    for entry in list_of(f"{field}.planes", data.get("planes")):
        plane = mapping(f"{field}.planes", entry)
        number = plane.get("obstacle")
        if type(number) is not int or not 0 <= number < obstacles:
            raise SceneError(f"{field}.planes.obstacle", number, "the number of an obstacle")
        start, end = (finite(f"{field}.planes.{key}", plane.get(key)) for key in ("t0", "t1"))
        normal = vector_of(f"{field}.planes.direction", plane.get("direction"))
        planes[number].append(_Plane(start, end, normal))
    return None if margin is None else Fraction(finite(f"{field}.margin", margin)), planes


def _obstacles(data: Any, scene: Scene) -> list[ExactSolid | ExactMesh]:
    entries = list_of("scene.obstacles", mapping("scene", data).get("obstacles", []))
    if len(entries) != len(scene.obstacles):
        raise SceneError("scene.obstacles", len(entries), "those of the scene")
    return [
        _obstacle(mapping("scene.obstacles", entry), shape)
        for entry, shape in zip(entries, scene.obstacles, strict=True)
    ]


def _obstacle(entry: dict[str, Any], shape: object) -> ExactSolid | ExactMesh:
    position = vector_of("scene.obstacles.position", entry.get("position", (0.0, 0.0, 0.0)))
    w, x, y, z = numbers_of("scene.obstacles.wxyz", entry.get("wxyz", (1.0, 0.0, 0.0, 0.0)))
    if isinstance(shape, MeshShape):
        surface = shape.surface
        return ExactMesh(
            surface.vertices, surface.faces, surface.closed, shape.factor, position, (w, x, y, z)
        )
    zero = Fraction(0)
    half, disc, ball = (zero, zero, zero), zero, zero
    if isinstance(shape, Box):
        a, b, c = vector_of("scene.obstacles.size", entry["size"])
        half = (a / 2, b / 2, c / 2)
    else:
        if not isinstance(shape, Sphere | Cylinder | Capsule):
            raise SceneError("scene.obstacles.shape", entry.get("shape"), "one that can be checked")
        radius = Fraction(entry["radius"])
        disc, ball = (radius, zero) if isinstance(shape, Cylinder) else (zero, radius)
        half = (zero, zero, Fraction(entry.get("height", 0)) / 2)
    return ExactSolid(half, disc, ball, position, (w, x, y, z))
