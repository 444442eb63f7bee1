"""Check of a plan's certificates in exact rational numbers.

The plan is checked as written: its curves' knots, control points and coefficients, its scene's
obstacles and its certificates' planes, each number taken exactly. No code that makes certificates
is used; mesh files are read and repaired as for planning.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.scene.scene import Scene
from abi.verify.exact.mesh import ExactMesh
from abi.verify.exact.solids import ExactSolid
from abi.verify.fault import Fault
from abi.verify.plan_curves import CURVES, curve_of
from abi.verify.plan_fields import list_of, mapping
from abi.verify.plan_obstacles import obstacles_of
from abi.verify.verify_chain import check_chain
from abi.verify.verify_curve import check_curve
from abi.verify.verify_motion import verify_motion
from abi.verify.verify_paper_arm import check_paper_arm
from abi.verify.verify_tasks import check_tasks

_KINDS = (("verdict", "motion"), ("legs",), ("scene", *CURVES))
"""Names that tell a verdict on a motion, a plan of tasks, and a plan."""


@dataclass(frozen=True)
class Verdict:
    """Verdict on one curve, or on the arm that follows it.

    Attributes:
        curve: ``bspline``, ``quadratic``, ``arm`` or ``motion``; of tasks ``leg 1, arm`` and so on,
            and ``tasks``: whether the legs join.
        proven: whether its certificate proves what the plan claims.
        reason: what is proven, or why it is not, as the end of a sentence.
    """

    curve: str
    proven: bool
    reason: str

    def __str__(self) -> str:
        return f"{self.curve}: {'proven' if self.proven else 'NOT proven'}: {self.reason}"


def verify(plan: object, folder: Path | MeshSource | None = None) -> tuple[Verdict, ...]:
    """Check every curve of a plan, and the arm.

    Args:
        plan: the result of ``Plan.to_dict`` or ``TaskPlan.to_dict``, as it is or read back from
            JSON, or the verdict on a motion that ``abi certify`` writes.
        folder: source of the scene's mesh files; None for a scene without files.

    Raises:
        SceneError: ``plan`` is no plan; names the field that is wrong.
    """
    if not isinstance(plan, dict):
        raise SceneError("plan", plan, "a plan as abi plan writes it")
    kinds = [all(name in plan for name in names) for names in _KINDS]
    if sum(kinds) > 1:
        raise SceneError(
            "plan", [*plan], "one of a plan, a plan of tasks, or a verdict on a motion"
        )
    if kinds[0]:
        return (_motion_verdict(plan, folder),)
    return _task_verdicts(plan, folder) if kinds[1] else _plan_verdicts(plan, folder)


def _plan_verdicts(
    plan: dict[str, Any], folder: Path | MeshSource | None, is_leg: bool = False
) -> tuple[Verdict, ...]:
    """Verdicts on the curves of a plan, of a leg those said to be clear, and on its arm."""
    if not all(name in plan for name in ("scene", *CURVES)):
        raise SceneError("plan", [*plan], "a plan as abi plan writes it")
    if type(version := plan.get("version")) is not int or version != 1:
        raise SceneError("version", version, "1")
    scene = Scene.from_dict(plan["scene"], folder)
    obstacles = obstacles_of(scene)
    # a motion from the space of the joints follows no curve of the tool
    needs_arm = is_leg or plan.get("joint_search") is not None
    curves = [name for name in CURVES if _claims(plan[name]) or not needs_arm]
    verdicts = [_curve_verdict(name, plan[name], scene, obstacles) for name in curves]
    if "arm" in plan or needs_arm:
        verdicts.append(_arm_verdict(plan, scene, obstacles))
    if len(scene.tasks) > 1:
        rest = f"; the plan is of the first of {len(scene.tasks)} legs, and of none of the others"
        verdicts = [replace(one, reason=one.reason + rest) for one in verdicts]
    return tuple(verdicts)


def _claims(curve: Any) -> bool:
    """Check whether a curve is stated to be clear: where objects are taken it need not be."""
    return isinstance(curve, dict) and bool(curve.get("certified") or curve.get("certificate"))


def _task_verdicts(plan: dict[str, Any], folder: Path | MeshSource | None) -> tuple[Verdict, ...]:
    """Verdicts on each leg of a sequence of tasks, and on whether the legs join."""
    if type(version := plan.get("version")) is not int or version != 1:
        raise SceneError("version", version, "1")
    source = MeshSource.of(folder)
    scene = Scene.from_dict(plan.get("scene"), source)
    verdicts = [
        replace(verdict, curve=f"leg {number}, {verdict.curve}")
        for number, leg in enumerate(list_of("legs", plan["legs"]), 1)
        for verdict in _plan_verdicts(mapping("legs", leg), source, is_leg=True)
    ]
    try:
        verdicts.append(Verdict("tasks", True, check_tasks(plan, scene, source)))
    except Fault as fault:
        verdicts.append(Verdict("tasks", False, str(fault)))
    return tuple(verdicts)


def _motion_verdict(data: dict[str, Any], folder: Path | MeshSource | None) -> Verdict:
    if type(version := data.get("version")) is not int or version != 1:
        raise SceneError("version", version, "1")
    return _checked("motion", data, partial(verify_motion, data, folder))


def _curve_verdict(
    name: str, section: Any, scene: Scene, obstacles: list[ExactSolid | ExactMesh]
) -> Verdict:
    if section is None:
        return Verdict(name, False, "the plan has no such curve")
    section = mapping(name, section)
    curve = curve_of(name, section)
    return _checked(name, section, partial(check_curve, name, section, curve, scene, obstacles))


def _arm_verdict(
    plan: dict[str, Any], scene: Scene, obstacles: list[ExactSolid | ExactMesh]
) -> Verdict:
    if plan.get("arm") is None:
        return Verdict("arm", False, "the plan has no motion")
    section, timing = mapping("arm", plan["arm"]), mapping("timing", plan.get("timing"))
    if scene.arm.model == "urdf":
        return _checked("arm", section, partial(check_chain, section, timing, scene, obstacles))
    name = timing.get("curve")
    if name not in CURVES:
        raise SceneError("timing.curve", name, f"one of {', '.join(CURVES)}")
    curve = curve_of(name, mapping(name, plan[name]))
    check = partial(check_paper_arm, section, timing, curve, scene, obstacles)
    return _checked("arm", section, check)


def _checked(name: str, section: dict[str, Any], check: Callable[[], str]) -> Verdict:
    if section.get("certificate") is None:
        claim = "it claims to be certified but" if section.get("certified") else "it"
        return Verdict(name, False, f"{claim} carries no certificate")
    try:
        return Verdict(name, True, check())
    except Fault as fault:
        return Verdict(name, False, f"its certificate is wrong, {fault}")
