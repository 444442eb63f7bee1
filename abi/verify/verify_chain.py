"""Check of the certificate of a URDF arm in exact numbers.

The proof is that of :mod:`abi.arm_planning.certificates.chain_certificate`. The joint positions,
the capsules and the pairs that must keep apart are checked as written. That the capsules hold the
corners of the links is checked, too, and so that these are where the joints take them; a test shows
that they hold all of them.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Container, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np

from abi.obstacles.pose import METRES, Quaternion, rotation
from abi.scene.arm_end import ENDS
from abi.scene.held_axis import HeldAxis
from abi.scene.scene import Scene
from abi.verify.allowed_contacts import Other, allowed_contacts, check_insides, not_compared
from abi.verify.certificate import (
    ARM,
    CapsuleKey,
    CertifiedPlane,
    capsule_of,
    claimed_margin,
    planes_of,
    words_of,
)
from abi.verify.exact.chain import ExactChain
from abi.verify.exact.frame import ExactFrame
from abi.verify.exact.link_corners import check_corners, check_lines
from abi.verify.exact.mesh import ExactMesh
from abi.verify.exact.robot_chain import exact_chain
from abi.verify.exact.solids import (
    ExactFloor,
    ExactSolid,
    LinkPiece,
    MovedHull,
    Vec3,
    dot,
    sub,
    vector,
)
from abi.verify.exact_path import positions_at
from abi.verify.fault import Fault
from abi.verify.held_direction import check_held_at_samples, check_span
from abi.verify.held_links import held_below_floor, held_in_each_other, held_in_mounts
from abi.verify.joint_motion import JointMotion
from abi.verify.joint_rates import check_rates
from abi.verify.plan_fields import finite, list_of, mapping, numbers_of, vector_of
from abi.verify.samples import check_samples, check_tool_points
from abi.verify.separation import check_apart

_REACHED = Fraction(1, 10**5)
"""Accepted error of the tool at start and goal, over the length of the chain."""
_TOLD = Fraction(1, 10**9)
"""Accepted error of the tool at a sample, over the length of the chain and its position."""
_ROUNDED = Fraction(1, 1 << 46)
"""Accepted rounding error, over the largest coordinate."""
_ASKED = 1e-5
"""Accepted error of a joint, or of the tool's direction, at start and goal."""
_ORIGIN = Fraction(0), Fraction(0), Fraction(0)
_LEAST_ANGLE = 0.01
"""Least angle to a direction held at samples that is checked, [rad]: less would take too long."""
_PAST = Fraction(1, 10**9)
"""Distance by which a joint may exceed its limit, [rad] or [unit]."""


def check_chain(
    section: dict[str, Any],
    timing: dict[str, Any],
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
    units = round(1 / METRES[scene.unit])
    stands = scene.arm.base, units, scene.arm.base_wxyz, scene.arm.gripper
    chain = exact_chain(scene.robot, scene.arm.tool, *stands)
    check_samples(section, timing, chain.coordinates)
    rows = _rows(certificate, section, chain)
    duration = finite("timing.duration", timing.get("duration"))
    check_rates(section, duration, rows, chain, scene)
    check_span(section, scene, duration)
    motion = JointMotion(chain, [*itertools.pairwise(rows)])
    _check_ends(chain, rows, scene)
    check_tool_points(section, partial(_tool, chain), _tolerance(chain, rows))
    capsules = _capsules(certificate, chain, scene)
    pairs = _pairs(certificate, len(capsules))
    bodies: dict[str, list[LinkPiece]] = {}
    for capsule in capsules:
        bodies.setdefault(capsule[0].link, []).append(capsule)
    check_corners(scene.robot, chain, bodies)
    check_lines(chain, scene.robot, bodies)
    ends = [rows[k] for k in (0, len(rows) // 2, -1)]
    allowed = allowed_contacts(certificate, scene, obstacles, chain, ends)
    _check_all_named(capsules, pairs, allowed)
    if section.get("allowed") != certificate.get("allowed"):
        raise Fault("the plan lists other contacts that are allowed")
    in_hand = [hull.frame == chain.frames[scene.arm.tool] for hull, _ in capsules]
    touchable = [scene.arm.grasping and behind for behind in in_hand]
    links = {hull.link for (hull, _), touches in zip(capsules, touchable, strict=True) if touches}
    stated = list_of("arm.apart_only", section.get("apart_only", [*links]))
    if not all(isinstance(name, str) for name in stated) or {*stated} != links:
        raise Fault("the plan names other links that need only be apart from obstacles")
    planes = planes_of(ARM, certificate, partial(_key, len(capsules)))
    span = Fraction(0), Fraction(len(rows) - 1)
    floor = ExactFloor(min(Fraction(scene.arm.base[2]), Fraction(scene.workspace.min[2])))
    for number, capsule in enumerate(capsules):
        least, link = partial(_least, motion, capsule), capsule[0].link
        distance = Fraction(0) if touchable[number] else margin
        for k, obstacle in enumerate(obstacles):
            if (link, k) not in allowed:
                label = f"{link} and obstacle {k + 1}"
                check_apart(label, planes.get((number, k), []), least, span, obstacle, distance)
        if (link, "floor") not in allowed:
            label = f"{link} and floor"
            check_apart(label, planes.get((number, "floor"), []), least, span, floor)
    for i, j in pairs:
        label = f"{capsules[j][0].link} and {capsules[i][0].link}"
        apart = partial(_apart, motion, capsules[i], capsules[j])
        check_apart(label, planes.get((j, -1 - i), []), apart, span, None)
    _check_outside(motion, capsules, obstacles, allowed)
    clear = [
        (link, k) for link in bodies for k in range(len(obstacles)) if (link, k) not in allowed
    ]
    beside = {(capsules[i][0].link, capsules[j][0].link) for i, j in pairs}
    check_insides(scene.robot, chain, rows[0], obstacles, [*clear, *beside])
    held = scene.arm.held_axis or _claimed_axis(scene, section)
    kept = ""
    if held is not None:
        kept = check_held_at_samples(held, chain, scene.arm.tool, rows, section)
    count = sum(map(len, planes.values()))
    words = words_of(margin, scene.unit, asked=scene.arm.clearance)
    if scene.arm.grasping:
        words += ", those behind the last joint only apart from it"
    sunk = sorted(a for a, other in allowed if other == "floor" and chain.frames[a] >= 0)
    left_out = f"{_left_out(certificate)}{not_compared([*sunk, *held_below_floor(scene, chain)])}"
    left_out += held_in_each_other(scene, chain, scene.arm.allowed)
    left_out += held_in_mounts(scene, chain, obstacles, scene.arm.allowed)
    return (
        f"{words}, and clear of the floor and each other ({len(pairs)} pairs), by {count} "
        f"directions{kept}{left_out}"
    )


def _claimed_axis(scene: Scene, section: dict[str, Any]) -> HeldAxis | None:
    """What a plan claims of a direction that its scene holds exactly; None if it holds none."""
    if scene.arm.exact_axis is None:
        return None
    claimed = mapping("arm.axis", section["axis"])
    tolerance = finite("arm.axis.tolerance", claimed.get("tolerance"))
    if not _LEAST_ANGLE <= tolerance <= math.pi / 2:
        raise Fault(f"that the gripper is within {tolerance:g} rad of its direction is not checked")
    return HeldAxis.model_construct(
        direction=scene.arm.exact_axis, tolerance=tolerance, begin=0.0, end=1.0
    )


def _left_out(certificate: dict[str, Any]) -> str:
    """Number of contacts allowed for each reason, as the end of a sentence."""
    reasons = Counter(str(one["reason"]) for one in certificate.get("allowed", []))
    named = ", ".join(f"{count} {reason}" for reason, count in reasons.items())
    return f"; allowed to touch: {named}" if named else ""


def _check_all_named(
    capsules: Sequence[LinkPiece],
    pairs: Sequence[tuple[int, int]],
    allowed: Container[tuple[str, Other]],
) -> None:
    """Raise if two links are neither kept apart nor allowed to touch."""
    apart = {frozenset(pair) for pair in pairs}
    for (i, (first, _)), (j, (second, _)) in itertools.combinations(enumerate(capsules), 2):
        named = first.link == second.link or (first.link, second.link) in allowed
        if not named and frozenset((i, j)) not in apart:
            raise Fault(f"nothing keeps {first.link} and {second.link} apart")


def _rows(
    certificate: dict[str, Any], section: dict[str, Any], chain: ExactChain
) -> list[list[Fraction]]:
    """Joint positions between which the joints move straight; the plan has every k-th of them."""
    label = f"{ARM}.positions"
    rows = [numbers_of(label, row) for row in list_of(label, certificate.get("positions"))]
    count = len(chain.coordinates)
    if len(rows) < 2 or any(len(row) != count for row in rows):
        raise Fault(f"its positions are not two or more of {count} joints")
    wanted = [numbers_of("arm.positions", row) for row in section.get("positions", [])]
    step, left = divmod(len(rows) - 1, max(len(wanted) - 1, 1))
    if step < 1 or left > 0 or rows[::step] != wanted:
        raise Fault("its positions are not those of the motion")
    exact = [[Fraction(number) for number in row] for row in rows]
    for name, column, (low, high) in zip(
        chain.coordinates, zip(*exact, strict=True), chain.limits, strict=True
    ):
        if min(column) < low - _PAST or max(column) > high + _PAST:
            raise Fault(f"{name} is past its limit")
    return exact


def _check_ends(chain: ExactChain, rows: Sequence[Sequence[Fraction]], scene: Scene) -> None:
    """Raise unless the first row is at the start and the last at the goal, as requested at both."""
    metres, length = METRES[scene.unit], _length(chain, (rows[0], rows[-1]))
    box = scene.workspace
    room = max(Fraction(high) - Fraction(low) for low, high in zip(box.min, box.max, strict=True))
    slides = {one.name for one in scene.robot.joints if one.kind == "prismatic"}
    for name, row in zip(ENDS, (rows[0], rows[-1]), strict=True):
        frame, end = chain.place(row)[-1], getattr(scene.arm, name)
        place, _ = frame.place(_ORIGIN)
        allowed = _REACHED * length + Fraction(0 if end is None else end.position_tolerance)
        allowed += _ROUNDED * max(map(abs, place)) + _TOLD * room
        away = sub(place, vector(getattr(scene, name)))
        if dot(away, away) > allowed * allowed:
            raise Fault(f"the tool tip is not at the {name}")
        if end is not None and end.is_pose and _turned(frame, end.wxyz) > end.angle_tolerance:
            raise Fault(f"the tool tip is turned otherwise at the {name}")
        for joint, asked in (scene.arm.joints_at(name, metres) or {}).items():
            at = float(row[chain.coordinates.index(joint)])
            if abs(at - (asked / metres if joint in slides else asked)) > _ASKED:
                raise Fault(f"the joints are not those asked for at the {name}")


def _length(chain: ExactChain, rows: Sequence[Sequence[Fraction]]) -> Fraction:
    """Bound of the chain's length from its first joint to the tip at some coordinates, [unit]."""
    above = chain.above(chain.before[-1])
    length = sum((sum(map(abs, chain.origins[k][:3, 3])) for k in (*above[:-1], -1)), Fraction(0))
    slides = [chain.joints[k] for k in above if chain.joints[k].kind == "prismatic"]
    return length + sum(max(abs(chain.value(one, row)) for row in rows) for one in slides)


def _tool(chain: ExactChain, row: Sequence[Fraction]) -> Vec3:
    """The tool tip at positions of the joints, [unit], world."""
    return chain.place(row)[-1].place(_ORIGIN)[0]


def _tolerance(chain: ExactChain, rows: Sequence[Sequence[Fraction]]) -> Fraction:
    """Accepted error of the stated tool position, [unit]: that of floating point."""
    far = max(map(abs, _tool(chain, rows[0])))
    strokes = max(abs(at) for row in rows for at in row)
    return _TOLD * (_length(chain, rows[:1]) + far + strokes)


def _turned(frame: ExactFrame, wxyz: Quaternion) -> float:
    """Angle between a frame and an orientation, less the accepted error, [rad]."""
    origin, *axes = (frame.place(vector(one))[0] for one in ((0, 0, 0), *np.eye(3).tolist()))
    turn = np.array([[float(part) for part in sub(axis, origin)] for axis in axes]).T
    turn /= np.linalg.norm(turn, axis=0)
    cosine = (np.trace(turn @ rotation(wxyz).T) - 1) / 2
    return math.acos(min(max(cosine, -1.0), 1.0)) - _ASKED


def _check_outside(
    motion: JointMotion,
    capsules: Sequence[LinkPiece],
    obstacles: list[ExactSolid | ExactMesh],
    allowed: Container[tuple[str, Other]],
) -> None:
    """Raise if a capsule, clear of all triangles, is inside a closed mesh."""
    frames = motion.chain.place(positions_at(motion.path, Fraction(0)))
    for _, hull in capsules:
        point = hull.points[0]
        if hull.frame >= 0:
            point, _ = frames[hull.frame].place(point)
        for k, obstacle in enumerate(obstacles):
            if (hull.link, k) in allowed:
                continue
            if isinstance(obstacle, ExactMesh) and obstacle.inside(point):
                raise Fault(f"{hull.link} is inside a mesh")


def _least(motion: JointMotion, capsule: LinkPiece, plane: CertifiedPlane) -> Fraction:
    """Lower bound of a plane's product with a capsule, or its closer hull, all along its piece."""
    return motion.least(capsule[plane.closer], plane)


def _apart(
    motion: JointMotion, first: LinkPiece, second: LinkPiece, plane: CertifiedPlane
) -> Fraction:
    """Lower bound of a plane's product with a capsule that it must keep apart from another."""
    return motion.apart(first[plane.closer], second[plane.closer], plane)


def _capsules(certificate: dict[str, Any], chain: ExactChain, scene: Scene) -> list[LinkPiece]:
    """Pieces of links: each within a radius of a segment, and in a hull that is closer."""
    capsules: list[LinkPiece] = []
    for entry in list_of(f"{ARM}.capsules", certificate.get("capsules")):
        data = mapping(f"{ARM}.capsules", entry)
        link, radius = data.get("link"), Fraction(finite(f"{ARM}.radius", data.get("radius")))
        low, high = (vector_of(f"{ARM}.capsules.{key}", data.get(key)) for key in ("from", "to"))
        if not isinstance(link, str) or link not in chain.frames or radius <= 0:
            raise Fault("a capsule has no link, or no extent")
        points = [
            vector_of(f"{ARM}.capsules.points", point)
            for point in list_of(f"{ARM}.capsules.points", data.get("points"))
        ]
        rounding = Fraction(finite(f"{ARM}.capsules.rounding", data.get("rounding")))
        if not points or rounding < 0:
            raise Fault(f"{link} has no hull")
        if data.get("joint") != chain.frames[link]:
            raise Fault(f"{link} is moved by another joint")
        frame = chain.frames[link]
        segment = MovedHull(link, frame, (low, high), radius)
        capsules.append((segment, MovedHull(link, frame, (*points,), rounding)))
    held = {hull.link for hull, _ in capsules}
    for name, link in scene.robot.links.items():
        if link.shapes and name not in held:
            raise Fault(f"{name} has no capsule")
    return capsules


def _pairs(certificate: dict[str, Any], capsules: int) -> list[tuple[int, int]]:
    pairs = []
    for entry in list_of(f"{ARM}.pairs", certificate.get("pairs")):
        pair = list_of(f"{ARM}.pairs", entry)
        if len(pair) != 2 or any(type(one) is not int or not 0 <= one < capsules for one in pair):
            raise Fault("a pair is not of two capsules")
        pairs.append((int(pair[0]), int(pair[1])))
    return pairs


def _key(capsules: int, entry: dict[str, Any]) -> CapsuleKey:
    """Capsule, and number of an obstacle, ``floor``, or another capsule: -1 less its number."""
    capsule, obstacle = capsule_of(entry, capsules), entry.get("obstacle")
    other = entry.get("other")
    if type(other) is int and 0 <= other < capsules:
        return capsule, -1 - other
    if obstacle == "floor" or (type(obstacle) is int and obstacle >= 0):
        return capsule, obstacle
    raise Fault("a direction belongs to no obstacle")
