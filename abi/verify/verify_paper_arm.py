"""Check of the certificate of the paper's arm in exact rational numbers.

The proof is that of :mod:`abi.arm_planning.certificates.paper_arm_certificate`.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from fractions import Fraction
from functools import lru_cache, partial
from typing import Any

from abi.scene.scene import Scene
from abi.verify.arm_capsules import capsules_of, check_bend
from abi.verify.certificate import (
    ARM,
    CapsuleKey,
    CertifiedPlane,
    capsule_of,
    claimed_margin,
    planes_of,
    words_of,
)
from abi.verify.exact.interval import enclose, rounded
from abi.verify.exact.mesh import ExactMesh
from abi.verify.exact.paper_arm import ExactArm, ExactCapsule, ExactPose
from abi.verify.exact.slide import ExactSlide, anywhere, moving
from abi.verify.exact.solids import (
    ExactCurve,
    ExactFloor,
    ExactSolid,
    dot,
    hull,
    sub,
    times_length,
    vector,
)
from abi.verify.fault import Fault
from abi.verify.plan_fields import finite, mapping
from abi.verify.separation import check_apart
from abi.verify.tool_path import check_ends, check_tool, point_at

_UPRIGHT = (1.0, 0.0, 0.0, 0.0)
_BELOW = Fraction(1, 10**9)
"""Accepted depth of the tool below the floor, over the coordinates of workspace and arm."""
_SAME = Fraction(1, 10**9)
"""Accepted error of a duration, over itself and 1 s."""
_HALVINGS = 30
_NOT_ITS = ("allowed", "apart_only", "axis")
"""What only plans of other arms state."""
_PHASES, _WITHOUT_PHASES = ("three_phase", "slowed"), ("time_optimal", "jerk_limited")
"""Laws whose motions have three phases, and never have; of any other a plan has them or has not."""


_PoseNear = Callable[[Fraction, Fraction, Fraction], ExactPose]
"""Function from a piece's first and last parameter, and that of a pose, to the arm near this."""


def check_paper_arm(
    section: dict[str, Any],
    timing: dict[str, Any],
    curve: ExactCurve,
    scene: Scene,
    obstacles: list[ExactSolid | ExactMesh],
) -> str:
    """Check the certificate of a plan's arm, and return what it proves as the end of a sentence.

    Raises:
        Fault: it does not prove what the plan claims.
        SceneError: a field has the wrong form.
    """
    certificate = mapping(ARM, section["certificate"])
    margin = claimed_margin("arm", section, Fraction(scene.arm.clearance), obstacles)
    for name in _NOT_ITS:
        if section.get(name) not in (None, []):
            raise Fault(f"it states {name}, which the paper's arm has not")
    elbow = section.get("elbow")
    if elbow not in ("up", "down"):
        raise Fault("its elbow is neither up nor down")
    settings = scene.arm
    arm = ExactArm(
        *(vector(settings.base), Fraction(settings.a1) + Fraction(settings.a2)),
        *(Fraction(settings.a3), Fraction(settings.a4) + Fraction(settings.a5)),
        1 if elbow == "up" else -1,
    )
    slide = _slide(scene, timing, curve)
    near = lru_cache(maxsize=None)(partial(_pose_near, arm, curve, slide))
    check_ends(curve, scene)
    check_tool(section, timing, arm, curve, slide)
    sleeve = Fraction(settings.a4)
    capsules = capsules_of(certificate, arm, sleeve)
    check_bend(section["positions"], capsules, sleeve)
    planes = planes_of(ARM, certificate, partial(_key, len(capsules)))
    floor = ExactFloor(min(arm.base[2], Fraction(scene.workspace.min[2])))
    span = curve[0].start, curve[-1].end
    _check_above(curve, floor, scene)
    for number, capsule in enumerate(capsules):
        least = partial(_least, arm, near, capsule)
        for k, obstacle in enumerate(obstacles):
            label = f"{capsule.link} and obstacle {k + 1}"
            check_apart(label, planes.get((number, k), []), least, span, obstacle, margin)
        for name, part in _others(capsule, capsules, floor, arm):
            label = f"{capsule.link} and {name}"
            check_apart(label, planes.get((number, name), []), least, span, part)
    for obstacle in obstacles:
        if isinstance(obstacle, ExactMesh) and obstacle.inside(arm.base):
            raise Fault("the base is inside a mesh")
    count = sum(map(len, planes.values()))
    kept = words_of(margin, scene.unit, asked=scene.arm.clearance)
    return (
        f"{kept}, and clear of the floor and its column, all along the curve, by {count} "
        "directions; not compared are forearm and upper arm, and of the fingers at the floor only "
        "the tool between them"
    )


def _check_above(curve: ExactCurve, floor: ExactFloor, scene: Scene) -> None:
    """Raise if the tool, around which the fingers may touch the floor, gets below it."""
    arm, box = scene.arm, scene.workspace
    size = max(map(abs, (*box.min, *box.max))) + arm.a1 + arm.a2 + arm.a3 + arm.a4 + arm.a5
    least = floor.height - _BELOW * Fraction(size)
    parts = [(0, [point[2] for point in span.bezier]) for span in curve]
    while parts:
        halvings, heights = parts.pop()
        if min(heights) >= least:
            continue
        if min(heights[0], heights[-1]) < least or halvings == _HALVINGS:
            raise Fault("the tool gets below the floor")
        rows = [heights]  # de Casteljau's scheme halves it
        while len(rows[-1]) > 1:
            rows.append([(a + b) / 2 for a, b in itertools.pairwise(rows[-1])])
        both = [row[0] for row in rows], [row[-1] for row in reversed(rows)]
        parts += [(halvings + 1, half) for half in both]


def _others(
    capsule: ExactCapsule, capsules: list[ExactCapsule], floor: ExactFloor, arm: ExactArm
) -> list[tuple[str, ExactFloor | ExactSolid]]:
    """Everything but the obstacles that a capsule must keep clear of, by name."""
    others: list[tuple[str, ExactFloor | ExactSolid]] = []
    if capsule.body == "column":
        return others
    if not capsule.grips:
        others.append(("floor", floor))
    if not capsule.neighbour:
        others += [(one.link, _still(one, arm)) for one in capsules if one.body == "column"]
    return others


def _still(capsule: ExactCapsule, arm: ExactArm) -> ExactSolid:
    """A capsule of the column as a solid."""
    zero, (x, y, z) = Fraction(0), arm.base
    centre = (x, y, z + (capsule.low + capsule.high) / 2)
    half = (zero, zero, (capsule.high - capsule.low) / 2)
    return ExactSolid(half, zero, capsule.radius, centre, _UPRIGHT)


def _pose_near(
    arm: ExactArm,
    curve: ExactCurve,
    slide: ExactSlide,
    start: Fraction,
    end: Fraction,
    at: Fraction,
) -> ExactPose:
    """The arm with its tool at a parameter of a curve, and how far it moves on a piece of that."""
    points = hull(curve, start, end)
    if not points or not start <= at <= end:
        raise Fault(f"a piece from {float(start):g} is not on the curve")
    place = rounded(point_at(curve, at))
    # rounding a point moves it by less than 2^-59
    ways = [sub(rounded(point), place) for point in points]
    away = enclose(max(dot(way, way) for way in ways)).sqrt().high + Fraction(1, 1 << 59)
    slid = slide(start, end)
    pose = arm.near(place, enclose(arm.lower + slid.low, arm.lower + slid.high), away)
    if pose is None:
        raise Fault(f"the arm may not reach all places near {float(at):g}")
    return pose


def _least(
    arm: ExactArm, near: _PoseNear, capsule: ExactCapsule, plane: CertifiedPlane
) -> Fraction:
    """Lower bound of a plane's product with the capsule all along its piece."""
    pose = near(plane.start, plane.end, plane.at)
    way = arm.way(pose, capsule) + capsule.radius
    return arm.least(pose, capsule, plane.normal) - times_length(way, plane.normal)


def _slide(scene: Scene, timing: dict[str, Any], curve: ExactCurve) -> ExactSlide:
    settings, motion = scene.arm, scene.motion
    start, force = Fraction(settings.q5), Fraction(settings.forces[1])
    if force == 0:
        return anywhere(start, start)
    mass5, mass6 = map(Fraction, settings.masses[1:])
    radius5, radius6 = map(Fraction, settings.radii[1:])
    inertia = mass5 * radius5**2 + mass6 * radius6**2
    if settings.dynamics == "corrected":
        inertia = 2 * (mass5 + mass6)
    if motion.law in _WITHOUT_PHASES or (motion.law not in _PHASES and timing.get("t1") is None):
        duration = Fraction(finite("timing.duration", timing.get("duration")))
        return anywhere(start, start + force / inertia * duration**2)
    names = ("t1", "t2", "t3", "peak_speed")  # of three phases, of any law
    t1, t2, t3, peak = (Fraction(finite(f"timing.{name}", timing.get(name))) for name in names)
    duration = Fraction(finite("timing.duration", timing.get("duration")))
    if abs(duration - (t1 + t2 + t3)) > _SAME * (1 + duration):
        raise Fault("its duration is not that of its three phases")
    rates = Fraction(motion.acceleration), Fraction(motion.deceleration)
    ways = (1, motion.speed), (t1, rates[0]), (t3, rates[1])
    if any(peak > Fraction(most) * time * (1 + _SAME) for time, most in ways):
        raise Fault("its speed is larger, or grows faster, than its scene lets it")
    if not any((t1, t2, t3)):
        return anywhere(start, start)
    if (motion.law != "three_phase" or motion.time_step is not None) and t1 and t3:
        rates = peak / t1, peak / t3
    return moving(curve, (t1, t2, t3), (peak, *rates), start, force / inertia)


def _key(capsules: int, entry: dict[str, Any]) -> CapsuleKey:
    """Capsule, and number of an obstacle, name of a link, or ``floor``."""
    obstacle = entry.get("obstacle")
    if type(obstacle) is int or isinstance(obstacle, str):
        return capsule_of(entry, capsules), obstacle
    raise Fault("a direction belongs to no obstacle")
