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
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from abi.obstacles.pose import METRES, Quaternion, rotation
from abi.scene.arm_end import ENDS
from abi.scene.held_axis import HeldAxis
from abi.scene.scene import Scene
from abi.verify.allowed_contacts import Other, allowed_contacts
from abi.verify.certificate import (
    ARM,
    CapsuleKey,
    CertifiedPlane,
    capsule_of,
    claimed_margin,
    planes_of,
    words_of,
)
from abi.verify.exact.chain import ExactChain, ExactFrame, exact_chain
from abi.verify.exact.link_corners import LinkPiece, check_corners
from abi.verify.exact.mesh import ExactMesh
from abi.verify.exact.solids import ExactFloor, ExactSolid, Vec3, dot, sub, times_length, vector
from abi.verify.fault import Fault
from abi.verify.held_direction import check_held_at_samples
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


class _Capsule(NamedTuple):
    """A piece of a link, in the frame of a joint, -1 for the world.

    It is within ``radius`` of a segment, and within ``rounding`` of the hull of ``points``.
    """

    link: str
    frame: int
    ends: tuple[Vec3, Vec3]
    radius: Fraction
    points: tuple[Vec3, ...]
    rounding: Fraction

    def corners(self, closer: bool) -> tuple[tuple[Vec3, ...], Fraction]:
        """Points whose hull contains it with a radius: of the segment, or of the closer hull."""
        return (self.points, self.rounding) if closer else (self.ends, self.radius)


@dataclass(frozen=True, eq=False)
class _JointMotion:
    """Joints that move straight from row to row, with cached poses and displacements."""

    chain: ExactChain
    rows: list[list[Fraction]]
    frames: dict[Fraction, list[ExactFrame]] = field(default_factory=dict)
    ways: dict[tuple[Fraction, Fraction, Fraction], list[Fraction]] = field(default_factory=dict)
    levers: dict[tuple[int, bool, int], list[Fraction]] = field(default_factory=dict)

    def positions(self, at: Fraction) -> list[Fraction]:
        """Coordinates at a parameter."""
        row = min(int(at), len(self.rows) - 2)
        share = at - row
        pairs = zip(self.rows[row], self.rows[row + 1], strict=True)
        return [a + share * (b - a) for a, b in pairs]

    def near(self, plane: CertifiedPlane) -> tuple[list[ExactFrame], list[Fraction]]:
        """Frames at the pose of a plane, and how far each coordinate gets from it."""
        start, end, at = plane.start, plane.end, plane.at
        if not 0 <= start <= at <= end <= len(self.rows) - 1:
            raise Fault(f"a piece from {float(start):g} is not on the motion")
        if at not in self.frames:
            self.frames[at] = self.chain.place(self.positions(at))
        key = start, end, at
        if key not in self.ways:
            middle = self.positions(at)
            inside = self.rows[int(start) + 1 : -int(-end // 1)]
            others = [self.positions(start), self.positions(end), *inside]
            columns = zip(*others, strict=True)
            self.ways[key] = [
                max(abs(one - here) for one in column)
                for column, here in zip(columns, middle, strict=True)
            ]
        return self.frames[at], self.ways[key]

    def way(self, capsule: _Capsule, closer: bool, behind: int, ways: list[Fraction]) -> Fraction:
        """Bound of the way of a capsule's corners beside the frame ``behind``, [unit]."""
        key = id(capsule), closer, behind
        if key not in self.levers:
            points, _ = capsule.corners(closer)
            self.levers[key] = self.chain.levers(points, capsule.frame, behind)
        pairs = zip(self.levers[key], ways, strict=True)
        return sum((lever * way for lever, way in pairs), Fraction(0))


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
    motion = _JointMotion(chain, _rows(certificate, section, chain))
    _check_ends(motion, scene)
    check_tool_points(section, partial(_tool, chain), _tolerance(chain, motion.rows))
    capsules = _capsules(certificate, chain, scene)
    pairs = _pairs(certificate, len(capsules))
    bodies = _bodies(capsules)
    check_corners(scene.robot, chain, bodies)
    ends = [motion.rows[k] for k in (0, len(motion.rows) // 2, -1)]
    allowed = allowed_contacts(certificate, scene, obstacles, chain, bodies, ends)
    _check_all_named(capsules, pairs, allowed)
    if section.get("allowed") != certificate.get("allowed"):
        raise Fault("the plan lists other contacts that are allowed")
    in_hand = [capsule.frame == chain.frames[scene.arm.tool] for capsule in capsules]
    touchable = [scene.arm.grasping and behind for behind in in_hand]
    links = {one.link for one, touches in zip(capsules, touchable, strict=True) if touches}
    if {*section.get("apart_only", links)} != links:
        raise Fault("the plan names other links that need only be apart from obstacles")
    planes = planes_of(ARM, certificate, partial(_key, len(capsules)))
    span = Fraction(0), Fraction(len(motion.rows) - 1)
    floor = ExactFloor(min(Fraction(scene.arm.base[2]), Fraction(scene.workspace.min[2])))
    for number, capsule in enumerate(capsules):
        least = partial(_least, motion, capsule)
        distance = Fraction(0) if touchable[number] else margin
        for k, obstacle in enumerate(obstacles):
            if (capsule.link, k) not in allowed:
                label = f"{capsule.link} and obstacle {k + 1}"
                check_apart(label, planes.get((number, k), []), least, span, obstacle, distance)
        if (capsule.link, "floor") not in allowed:
            label = f"{capsule.link} and floor"
            check_apart(label, planes.get((number, "floor"), []), least, span, floor)
    for i, j in pairs:
        label = f"{capsules[j].link} and {capsules[i].link}"
        apart = partial(_apart, motion, capsules[i], capsules[j])
        check_apart(label, planes.get((j, -1 - i), []), apart, span, None)
    _check_outside(motion, capsules, obstacles, allowed)
    held = scene.arm.held_axis or _claimed_axis(scene, section)
    kept = ""
    if held is not None:
        kept = check_held_at_samples(held, chain, scene.arm.tool, motion.rows, section)
    count = sum(map(len, planes.values()))
    words = words_of(margin, scene.unit)
    if scene.arm.grasping:
        words += ", those behind the last joint only apart from it"
    left_out = _left_out(certificate)
    return (
        f"{words}, and clear of the floor and each other ({len(pairs)} pairs), by {count} "
        f"directions{kept}{left_out}"
    )


def _claimed_axis(scene: Scene, section: dict[str, Any]) -> HeldAxis | None:
    """What a plan claims of a direction that is held exactly at samples; None for nothing."""
    if scene.arm.exact_axis is None or section.get("axis") is None:
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


def _bodies(capsules: Sequence[_Capsule]) -> dict[str, list[LinkPiece]]:
    """Pieces of each link, in floating point."""
    found: dict[str, list[LinkPiece]] = {}
    for capsule in capsules:
        ends, points = (np.array(one, dtype=np.float64) for one in (capsule.ends, capsule.points))
        body = LinkPiece(ends, float(capsule.radius), points, float(capsule.rounding))
        found.setdefault(capsule.link, []).append(body)
    return found


def _check_all_named(
    capsules: Sequence[_Capsule],
    pairs: Sequence[tuple[int, int]],
    allowed: Container[tuple[str, Other]],
) -> None:
    """Raise if two links are neither kept apart nor allowed to touch."""
    apart = {frozenset(pair) for pair in pairs}
    for (i, first), (j, second) in itertools.combinations(enumerate(capsules), 2):
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
    step = (len(rows) - 1) // max(len(wanted) - 1, 1)
    if step < 1 or rows[::step] != wanted:
        raise Fault("its positions are not those of the motion")
    exact = [[Fraction(number) for number in row] for row in rows]
    for name, column, (low, high) in zip(
        chain.coordinates, zip(*exact, strict=True), chain.limits, strict=True
    ):
        if min(column) < low - _PAST or max(column) > high + _PAST:
            raise Fault(f"{name} is past its limit")
    return exact


def _check_ends(motion: _JointMotion, scene: Scene) -> None:
    """Raise unless the arm moves from start to goal, as requested at both."""
    chain, length = motion.chain, _length(motion.chain)
    metres = METRES[scene.unit]
    slides = {one.name for one in scene.robot.joints if one.kind == "prismatic"}
    for name, row in zip(ENDS, (motion.rows[0], motion.rows[-1]), strict=True):
        frame, end = chain.place(row)[-1], getattr(scene.arm, name)
        place, _ = frame.place(_ORIGIN)
        allowed = _REACHED * length + Fraction(0 if end is None else end.position_tolerance)
        allowed += _ROUNDED * max(map(abs, place))
        if max(map(abs, sub(place, vector(getattr(scene, name))))) > allowed:
            raise Fault(f"the tool tip is not at the {name}")
        if end is not None and end.is_pose and _turned(frame, end.wxyz) > end.angle_tolerance:
            raise Fault(f"the tool tip is turned otherwise at the {name}")
        for joint, asked in (scene.arm.joints_at(name, metres) or {}).items():
            at = float(row[chain.coordinates.index(joint)])
            if abs(at - (asked / metres if joint in slides else asked)) > _ASKED:
                raise Fault(f"the joints are not those asked for at the {name}")


def _length(chain: ExactChain) -> Fraction:
    """Bound of the chain's length from its first joint to the tip, [unit]."""
    above = chain.above(chain.before[-1])
    return sum((sum(map(abs, chain.origins[k].origin)) for k in (*above[:-1], -1)), Fraction(0))


def _tool(chain: ExactChain, row: Sequence[Fraction]) -> Vec3:
    """The tool tip at positions of the joints, [unit], world."""
    return chain.place(row)[-1].place(_ORIGIN)[0]


def _tolerance(chain: ExactChain, rows: Sequence[Sequence[Fraction]]) -> Fraction:
    """Accepted error of the stated tool position, [unit]: that of floating point."""
    far = max(map(abs, _tool(chain, rows[0])))
    strokes = max(abs(at) for row in rows for at in row)
    return _TOLD * (_length(chain) + far + strokes)


def _turned(frame: ExactFrame, wxyz: Quaternion) -> float:
    """Angle between a frame and an orientation, less the accepted error, [rad]."""
    origin, *axes = (frame.place(vector(one))[0] for one in ((0, 0, 0), *np.eye(3).tolist()))
    turn = np.array([[float(part) for part in sub(axis, origin)] for axis in axes]).T
    turn /= np.linalg.norm(turn, axis=0)
    cosine = (np.trace(turn @ rotation(wxyz).T) - 1) / 2
    return math.acos(min(max(cosine, -1.0), 1.0)) - _ASKED


def _check_outside(
    motion: _JointMotion,
    capsules: Sequence[_Capsule],
    obstacles: list[ExactSolid | ExactMesh],
    allowed: Container[tuple[str, Other]],
) -> None:
    """Raise if a capsule, clear of all triangles, is inside a closed mesh."""
    frames = motion.chain.place(motion.rows[0])
    for capsule in capsules:
        point = capsule.points[0]
        if capsule.frame >= 0:
            point, _ = frames[capsule.frame].place(point)
        for k, obstacle in enumerate(obstacles):
            if (capsule.link, k) in allowed:
                continue
            if isinstance(obstacle, ExactMesh) and obstacle.inside(point):
                raise Fault(f"{capsule.link} is inside a mesh")


def _range(
    frames: list[ExactFrame], capsule: _Capsule, plane: CertifiedPlane
) -> tuple[Fraction, Fraction]:
    """Bounds of the products of a plane's direction with a capsule's corners at a pose."""
    points = capsule.corners(plane.closer)[0]
    if capsule.frame >= 0:
        return frames[capsule.frame].products(points, plane.normal)
    products = [dot(plane.normal, point) for point in points]
    return min(products), max(products)


def _least(motion: _JointMotion, capsule: _Capsule, plane: CertifiedPlane) -> Fraction:
    """Lower bound of a plane's product with a capsule all along its piece."""
    frames, ways = motion.near(plane)
    way = motion.way(capsule, plane.closer, -1, ways) + capsule.corners(plane.closer)[1]
    return _range(frames, capsule, plane)[0] - times_length(way, plane.normal)


def _apart(
    motion: _JointMotion, first: _Capsule, second: _Capsule, plane: CertifiedPlane
) -> Fraction:
    """Lower bound of a plane's product with a capsule that it must keep apart from another."""
    frames, ways = motion.near(plane)
    _, highest = _range(frames, first, plane)
    least, _ = _range(frames, second, plane)
    common = motion.chain.meeting(first.frame, second.frame)
    way = sum(motion.way(one, plane.closer, common, ways) for one in (first, second))
    way += first.corners(plane.closer)[1] + second.corners(plane.closer)[1]
    if least - highest <= times_length(way, plane.normal):
        raise Fault(f"the piece from {float(plane.start):g} is not separated")
    return least


def _capsules(certificate: dict[str, Any], chain: ExactChain, scene: Scene) -> list[_Capsule]:
    capsules = []
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
        capsules.append(_Capsule(link, frame, (low, high), radius, (*points,), rounding))
    held = {capsule.link for capsule in capsules}
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
