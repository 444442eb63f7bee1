"""Check of the certificate of a motion that was planned elsewhere, in exact numbers.

The proof is that of :mod:`abi.certification.clearance_proof`. The motion, the bodies and the pairs
that must keep apart are checked as written. That the bodies hold the corners of the links'
collision shapes is checked, too, and that pairs of links which are left out may be.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Container, Sequence
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

from abi.errors import SceneError
from abi.obstacles.pose import METRES
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.scene.scene import Scene
from abi.verify.allowed_contacts import (
    check_insides,
    contacts_of_motion,
    may_touch_floor,
    name_of,
    not_compared,
)
from abi.verify.certificate import MOTION, planes_of, words_of
from abi.verify.exact.chain import ExactChain
from abi.verify.exact.link_corners import check_corners, has_own_shape
from abi.verify.exact.mesh import ExactMesh
from abi.verify.exact.robot_chain import exact_joints
from abi.verify.exact.solids import ExactFloor, ExactSolid, LinkPiece, MovedHull
from abi.verify.exact_path import exact_path, positions_at
from abi.verify.fault import Fault
from abi.verify.held_direction import check_held_in_motion
from abi.verify.held_links import (
    check_still,
    held_below_floor,
    held_in_each_other,
    held_in_mounts,
)
from abi.verify.joint_motion import JointMotion
from abi.verify.plan_fields import finite, list_of, mapping, vector_of
from abi.verify.plan_obstacles import obstacles_of
from abi.verify.separation import check_apart

_CLEAR = "Proven clear: "
_SMALLER = ", the object then a millimetre smaller on each side"
_NUMBER = re.compile(r"\d+(\.\d+)?(e[+-]?\d+)?")


def verify_motion(data: dict[str, Any], folder: Path | MeshSource | None = None) -> str:
    """Check the certificate of a motion, and return what it proves as the end of a sentence.

    Args:
        data: what ``abi certify`` writes.
        folder: source of the scene's mesh files and robot.

    Raises:
        Fault: it does not prove what is claimed.
        SceneError: a field has the wrong form.
    """
    if data.get("verdict") != "clear":
        raise Fault("the motion is not said to be clear")
    scene = Scene.from_dict(data.get("scene"), folder)
    if scene.arm.model != "urdf":
        raise SceneError("scene.arm.model", scene.arm.model, "urdf")
    obstacles = obstacles_of(scene)
    certificate = mapping(MOTION, data.get("certificate"))
    margin = _margin(data, certificate, obstacles)
    motion = _motion(mapping("motion", data.get("motion")), scene)
    bodies = _bodies(certificate, motion.chain)
    pieces: dict[str, list[LinkPiece]] = {name: [] for name in scene.robot.links}
    for body in bodies:
        pieces[body.link].append((body,))
    check_corners(scene.robot, motion.chain, pieces)
    if not has_own_shape(motion.chain, scene.robot):
        raise Fault("no link of the robot that moves has a shape")
    few = [positions_at(motion.path, Fraction(k * len(motion.path), 4)) for k in range(5)]
    allowed = contacts_of_motion(data, scene, motion.chain, few)
    pairs = _pairs(certificate, len(bodies))
    planes = planes_of(MOTION, certificate, partial(_key, len(bodies)))
    span = Fraction(0), Fraction(len(motion.path))
    floor = ExactFloor(min(Fraction(scene.arm.base[2]), Fraction(scene.workspace.min[2])))
    links = {body.link for body in bodies}
    standing = {one for one in links if may_touch_floor(one, scene, motion.chain)}
    stated = {one.get("link") for one in data["allowed"] if one.get("other") == "floor"}
    stated |= {bodies[number].link for number, other in planes if other == "floor"}
    sunk = sorted(one for one in standing if motion.chain.frames[one] >= 0)
    if unsaid := [one for one in sunk if one not in stated]:
        raise Fault(f"it does not say that {unsaid[0]} is not compared with the floor")
    for number, body in enumerate(bodies):
        least = partial(motion.least, body)
        for k, obstacle in enumerate(obstacles if body.frame >= 0 else ()):
            label = f"{body.link} and obstacle {k + 1}"
            group = planes.get((number, k), [])
            check_apart(label, group, least, span, obstacle, margin)
        if body.link not in standing:
            group = planes.get((number, "floor"), [])
            check_apart(f"{body.link} and floor", group, least, span, floor)
    for i, j in pairs:
        label = f"{bodies[j].link} and {bodies[i].link}"
        apart = partial(motion.apart, bodies[i], bodies[j])
        check_apart(label, planes.get((j, -1 - i), []), apart, span, None)
    _check_outside(motion, bodies, obstacles)
    asked = {(one["link"], one["other"]) for one in data["allowed"] if one["reason"] == "asked"}
    check_still(scene, motion.chain, obstacles, asked)
    moving: list[tuple[str, int | str]] = [
        (link, k)
        for link in sorted(links)
        for k in range(len(obstacles))
        if motion.chain.frames[link] >= 0
    ]
    moving += sorted({(bodies[i].link, bodies[j].link) for i, j in pairs})
    check_insides(scene.robot, motion.chain, few[0], obstacles, moving)
    _check_pairs(allowed, bodies, pairs)
    _check_told(data, scene)
    direction = check_held_in_motion(data, scene, motion.chain, motion.path)
    count = sum(map(len, planes.values()))
    kept = words_of(margin, scene.unit, "its moving links")
    if scene.arm.grasping and scene.arm.attached is not None:
        kept += _SMALLER
    return (
        f"{kept}, and clear of the floor and each other "
        f"({len(pairs)} pairs), by {count} directions{direction}; {_excepted(data)}"
        f"{not_compared([*sunk, *held_below_floor(scene, motion.chain)])}"
        f"{held_in_each_other(scene, motion.chain)}"
        f"{held_in_mounts(scene, motion.chain, obstacles, asked)}"
    )


def _check_told(data: dict[str, Any], scene: Scene) -> None:
    """Raise if the verdict states more or other in words and stretches than that it is clear."""
    if data.get("touches") or data.get("undecided") or data.get("depth") is not None:
        raise Fault("it lists what touches or is not decided")
    stretches = [mapping("stretches", one) for one in list_of("stretches", data.get("stretches"))]
    if not stretches or any(one.get("state") != "clear" for one in stretches):
        raise Fault("its stretches are not all clear")
    motion = data["motion"]
    ends = [motion["times"][0], *(one.get("last") for one in stretches)]
    if [one.get("first") for one in stretches] != ends[:-1] or ends[-1] != motion["times"][-1]:
        raise Fault("its stretches are not the whole motion")
    rates = sum(motion.get(name) is not None for name in ("velocities", "accelerations"))
    if data.get("interpolation") != ("linear", "cubic", "quintic")[rates]:
        raise Fault("its joints move otherwise between waypoints than it says")
    if not _is_said(str(data.get("sentence")), data.get("clearance"), scene):
        raise Fault("its sentence says something else")


def _is_said(sentence: str, margin: float | None, scene: Scene) -> bool:
    """Check that a sentence is one of those that ``abi certify`` has for what is clear."""
    if margin is None:
        least = "the robot touches neither itself nor the floor at any time"
        return sentence in (f"{_CLEAR}{least}.", f"{_CLEAR}{least}, but for what the notes tell.")
    smaller = _SMALLER if scene.arm.grasping and scene.arm.attached is not None else ""
    if margin == 0:
        return sentence == f"{_CLEAR}its moving links touch nothing{smaller}."
    rest = f" {scene.unit} from every obstacle{smaller}."
    number = sentence.removeprefix(f"{_CLEAR}its moving links keep ").removesuffix(rest)
    if sentence != f"{_CLEAR}its moving links keep {number}{rest}":
        return False
    return _NUMBER.fullmatch(number) is not None and 0.999 * margin <= float(number) <= margin


def _margin(
    data: dict[str, Any], certificate: dict[str, Any], obstacles: Sequence[ExactSolid | ExactMesh]
) -> Fraction | None:
    """Distance that is claimed, [unit]; None without obstacles."""
    given, stated = certificate.get("margin"), data.get("clearance")
    if (given is None) != (not obstacles) or given != stated:
        raise Fault("its margin is not the clearance stated")
    margin = None if given is None else Fraction(finite(f"{MOTION}.margin", given))
    if margin is not None and margin < 0:
        raise Fault("its margin is negative")
    return margin


def _motion(motion: dict[str, Any], scene: Scene) -> JointMotion:
    """The motion of the scene's robot, the limits of whose chain are wide enough for it."""
    robot, units = scene.robot, round(1 / METRES[scene.unit])
    names = list_of("motion.joints", motion.get("joints"))
    free = {one.name: one for one in robot.joints if one.kind != "fixed" and one.follows is None}
    if not all(isinstance(name, str) and name in free for name in names):
        raise Fault("its joints are not the robot's")
    if not 0 < len(names) == len(set(names)):
        raise Fault("its joints are not named once each")
    held = {name: at for name, at in scene.arm.gripper.items() if name not in names}
    stands = scene.arm.base, units, scene.arm.base_wxyz, held
    chain = exact_joints(robot, tuple(names), *stands)
    path = exact_path(motion, [units if slides else 1 for slides in chain.slides])
    columns = [*zip(*(row for piece in path for row in piece), strict=True)]
    limits = tuple(
        (min(low, *column), max(high, *column))
        for (low, high), column in zip(chain.limits, columns, strict=True)
    )
    return JointMotion(chain.within(limits), path)


def _bodies(certificate: dict[str, Any], chain: ExactChain) -> list[MovedHull]:
    """Bodies as written, each of a link and moved by its joint."""
    bodies = []
    label = f"{MOTION}.bodies"
    for entry in list_of(label, certificate.get("bodies")):
        data = mapping(label, entry)
        link, radius = data.get("link"), Fraction(finite(f"{label}.radius", data.get("radius")))
        points = [
            vector_of(f"{label}.points", one)
            for one in list_of(f"{label}.points", data.get("points"))
        ]
        if not isinstance(link, str) or link not in chain.frames or radius < 0 or not points:
            raise Fault("a body has no link, or no extent")
        if data.get("joint") != chain.frames[link]:
            raise Fault(f"{link} is moved by another joint")
        bodies.append(MovedHull(link, chain.frames[link], tuple(points), radius))
    return bodies


def _pairs(certificate: dict[str, Any], bodies: int) -> list[tuple[int, int]]:
    pairs = []
    for entry in list_of(f"{MOTION}.pairs", certificate.get("pairs")):
        pair = list_of(f"{MOTION}.pairs", entry)
        if len(pair) != 2 or any(type(one) is not int or not 0 <= one < bodies for one in pair):
            raise Fault("a pair is not of two bodies")
        pairs.append((int(pair[0]), int(pair[1])))
    return pairs


def _check_pairs(
    allowed: Container[frozenset[str]],
    bodies: Sequence[MovedHull],
    pairs: Sequence[tuple[int, int]],
) -> None:
    """Raise if two links neither stay apart nor are allowed to touch."""
    kept = {frozenset(pair) for pair in pairs}
    for (i, first), (j, second) in itertools.combinations(enumerate(bodies), 2):
        links = frozenset((first.link, second.link))
        if len(links) == 2 and links not in allowed and frozenset((i, j)) not in kept:
            names = f"{first.link} and {second.link}"
            raise Fault(f"{names} are neither kept apart nor said to be allowed")


def _excepted(data: dict[str, Any]) -> str:
    """Allowed contacts of links that are not adjacent, as the end of a sentence."""
    usual = ("adjacent", "grasp", "mount")
    others = [one for one in data["allowed"] if one.get("reason") not in usual]
    names = [f"{one.get('link')} and {name_of(one.get('other'))}" for one in others]
    return f"allowed to touch are {', '.join(names)}" if names else "only neighbours may touch"


def _check_outside(
    motion: JointMotion, bodies: Sequence[MovedHull], obstacles: Sequence[ExactSolid | ExactMesh]
) -> None:
    """Raise if a body, clear of all triangles, is inside a closed mesh."""
    frames = motion.chain.place(positions_at(motion.path, Fraction(0)))
    for body in bodies:
        if body.frame >= 0:
            point, _ = frames[body.frame].place(body.points[0])
            for obstacle in obstacles:
                if isinstance(obstacle, ExactMesh) and obstacle.inside(point):
                    raise Fault(f"{body.link} is inside a mesh")


def _key(bodies: int, entry: dict[str, Any]) -> tuple[int, int | str]:
    """Body, and number of an obstacle, ``floor``, or another body: -1 less its number."""
    body, obstacle, other = entry.get("body"), entry.get("obstacle"), entry.get("other")
    if type(body) is not int or not 0 <= body < bodies:
        raise Fault("a direction belongs to no body")
    if type(other) is int and 0 <= other < bodies:
        return body, -1 - other
    if obstacle == "floor" or (type(obstacle) is int and obstacle >= 0):
        return body, obstacle
    raise Fault("a direction belongs to no obstacle")
