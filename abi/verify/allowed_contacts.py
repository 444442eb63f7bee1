"""Contacts that a certificate of a URDF arm allows, each checked for its reason.

What may be left out: two links that no joint moves beside each other, or that one joins; an object
that is held and what holds it, or is fixed to that; pairs that the SRDF or the scene names; links
whose own shapes touch in random poses and in some of the motion, or are apart in all positions of
the joints between them; the floor for what stands on it; an obstacle beneath the base for links
that stand still. Nothing else may be missing.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from abi.robot.urdf.robot import Robot
from abi.scene.scene import Scene
from abi.verify.certificate import ARM
from abi.verify.exact.chain import ExactChain
from abi.verify.exact.link_corners import has_own_shape
from abi.verify.exact.mesh import ExactMesh
from abi.verify.exact.robot_chain import exact_joints
from abi.verify.exact.solids import ExactSolid
from abi.verify.fault import Fault
from abi.verify.link_contact import LinkTriangles, holds, link_triangles, solid_triangles, touch
from abi.verify.never_touching import never_touch
from abi.verify.plan_fields import list_of, mapping
from abi.verify.plumb_line import is_beneath

Other = str | int
Row = Sequence[Fraction]
"""Coordinates of a chain, [rad] or [unit]."""

_NEAR = 1e-6
"""Height over the floor at which a link counts as touching it, [unit]."""
_UPRIGHT = 1e-6
"""Tilt of an axis that counts as zero, [rad]."""
_THIN = 1e-3
"""Radius of the lines that stand for links without shapes, [m]."""
_POSES = 64
"""Random poses in which links that are said to touch always have to."""


def allowed_contacts(
    certificate: dict[str, Any],
    scene: Scene,
    obstacles: Sequence[ExactSolid | ExactMesh],
    chain: ExactChain,
    rows: Sequence[Row],
) -> frozenset[tuple[str, Other]]:
    """Links, each with what it may touch; for two links in both directions.

    ``rows`` are coordinates of the motion at which links that touch always are tested, too.

    Raises:
        Fault: a contact may not be left out.
        SceneError: a field has the wrong form.
    """
    found: set[tuple[str, Other]] = set()
    always: list[tuple[str, str]] = []
    for link, other, reason in _entries(f"{ARM}.allowed", certificate.get("allowed", []), chain):
        if isinstance(other, str) and other in chain.frames:
            if reason == "always":
                always.append((link, other))
            elif not _may_touch(link, other, reason, scene, chain):
                raise Fault(f"{link} and {other} are no pair that may touch")
            found |= {(link, other), (other, link)}
        elif other == "floor" or (type(other) is int and 0 <= other < len(obstacles)):
            if not _may_stand(link, other, reason, scene, obstacles, chain):
                raise Fault(f"{link} may not touch {name_of(other)}")
            found.add((link, other))
        else:
            raise Fault(f"{link} is allowed to touch nothing that is there")
    _check_touching(always, scene.robot, chain, rows)
    return frozenset(found)


def contacts_of_motion(
    data: dict[str, Any], scene: Scene, chain: ExactChain, rows: Sequence[Row]
) -> frozenset[frozenset[str]]:
    """Pairs of links that a motion from elsewhere allows to touch, each for a valid reason.

    ``rows`` are coordinates of the motion at which links that touch always are tested, too.

    Raises:
        Fault: a contact may not be left out.
        SceneError: a field has the wrong form.
    """
    found: set[frozenset[str]] = set()
    always: list[tuple[str, str]] = []
    for link, other, reason in _entries("allowed", data.get("allowed"), chain):
        if isinstance(other, str) and other in chain.frames:
            if reason == "always":
                always.append((link, other))
            elif reason not in ("adjacent", "grasp", "srdf") or not _may_touch(
                link, other, reason, scene, chain
            ):
                raise Fault(f"{link} and {other} are no pair that may touch")
            found.add(frozenset((link, other)))
        elif reason == "asked" and type(other) is int and (link, other) in scene.arm.allowed:
            continue
        elif reason != "mount" or not (
            may_touch_floor(link, scene, chain)
            if other == "floor"
            else other == "obstacles" and chain.frames[link] < 0
        ):
            raise Fault(f"{link} may not touch {other}")
    _check_touching(always, scene.robot, chain, rows)
    return frozenset(found)


def _entries(
    field: str, entries: object, chain: ExactChain
) -> Iterator[tuple[str, object, object]]:
    """Each contact's link of the chain, what it may touch, and the stated reason."""
    pairs = set()
    for entry in list_of(field, entries):
        contact = mapping(field, entry)
        link = contact.get("link")
        if not isinstance(link, str) or link not in chain.frames:
            raise Fault("a contact is allowed of no link")
        # as text with its kind: a link may be named as an obstacle is numbered
        pair = frozenset((repr(link), repr(contact.get("other"))))
        if pair in pairs:
            raise Fault("a contact is allowed twice")
        pairs.add(pair)
        yield link, contact.get("other"), contact.get("reason")


def name_of(other: Other) -> str:
    """An obstacle, the floor or a link in words."""
    if isinstance(other, int):
        return f"obstacle {other + 1}"
    return "the floor" if other == "floor" else other


def _may_touch(link: str, other: str, reason: object, scene: Scene, chain: ExactChain) -> bool:
    """Check the stated reason for which a pair of links may touch."""
    pair, robot = {link, other}, scene.robot
    if reason in ("adjacent", "grasp"):
        return reason == ("grasp" if _is_held(robot, pair) else "adjacent") and are_joined(
            robot, chain, link, other
        )
    if reason == "never":
        return never_touch(robot, chain, link, other)
    if reason == "srdf":
        return frozenset(pair) in robot.may_touch
    return reason == "asked" and any(pair == set(one) for one in scene.arm.allowed)


def are_joined(robot: Robot, chain: ExactChain, link: str, other: str) -> bool:
    """Check whether two links do not move relative to each other, or are joined by one joint.

    It joins no object that is held, no links between which there is one with a shape, none that a
    third link carries, and none between which there is another joint, which is held.
    """
    between = {*chain.above(chain.frames[link])} ^ {*chain.above(chain.frames[other])}
    if len(between) != 1 or _is_held(robot, {link, other}):
        return not between
    moved = (joint for joint in robot.joints if joint.kind != "fixed")
    free = {joint.child for joint in moved if joint.follows is not None or joint.low < joint.high}
    parents: dict[str, list[str]] = {joint.child: [joint.parent] for joint in robot.joints}
    reached = {link: [*parents.get(link, ())], other: [*parents.get(other, ())]}
    for way in reached.values():
        while way and way[-1] in parents and not robot.links[way[-1]].shapes:
            way += parents[way[-1]]
    for low, high in ((link, other), (other, link)):
        if high in reached[low]:
            way = [low, *reached[low][: reached[low].index(high)]]
            return len(free.intersection(way)) <= 1
    return False


def _is_held(robot: Robot, pair: set[str]) -> bool:
    return robot.attached in pair


def _may_stand(
    link: str,
    other: Other,
    reason: object,
    scene: Scene,
    obstacles: Sequence[ExactSolid | ExactMesh],
    chain: ExactChain,
) -> bool:
    """Check the stated reason for which a link may touch the floor or an obstacle."""
    frame = chain.frames[link]
    if isinstance(other, str):
        return reason == "mount" and may_touch_floor(link, scene, chain)
    if reason == "asked":
        return (link, other) in scene.arm.allowed
    arm, metre = scene.arm, float(chain.units)
    return (
        reason == "mount"
        and frame < 0
        and is_beneath(obstacles[other], np.array(arm.base), arm.base_wxyz, metre)
    )


def not_compared(links: Sequence[str]) -> str:
    """What is said of links that are not compared with the floor, as a sentence's end."""
    return f"; not compared with the floor: {', '.join(links)}" if links else ""


def may_touch_floor(link: str, scene: Scene, chain: ExactChain) -> bool:
    """Check whether a link stands still, or the first joint brings it no nearer to the floor.

    Such a joint turns about an upright axis or slides level; or the link touches the floor wherever
    it takes it.
    """
    if chain.frames[link] != 0:
        return chain.frames[link] < 0
    axis = chain.origins[0][:3, :3].astype(float) @ chain.joints[0].axis
    if (abs(axis[2]) if chain.joints[0].kind == "prismatic" else np.hypot(*axis[:2])) <= _UPRIGHT:
        return True
    floor = min(scene.arm.base[2], scene.workspace.min[2])
    low, high = (np.array(one) for one in usual_range(chain))
    if scene.robot.links[link].shapes:
        own = in_frame(link, scene.robot, chain)
        corners, radii = own.corners.reshape(-1, 3), np.repeat(own.radii, 3)
    elif has_own_shape(chain, scene.robot):
        return False
    else:  # lines stand for it
        lines = zip(chain.before, chain.origins, strict=True)
        ends = [pose[:3, 3].astype(np.float64) for frame, pose in lines if frame == 0]
        corners, radii = np.array([np.zeros(3), *ends]), np.array([_THIN * float(chain.units)])
    coordinate = chain.coordinates.index(chain.joints[0].coordinate)
    row = np.clip(0.0, low, high)
    for value in np.linspace(low[coordinate], high[coordinate], _POSES):
        row[coordinate] = value
        frame = chain.place([Fraction(number) for number in row.tolist()])[0]
        up, origin = (np.array(part[2] / 2.0**200, dtype=np.float64) for part in frame[:2])
        if (corners @ up - radii).min() + origin > floor + _NEAR:
            return False
    return True


def _check_touching(
    pairs: Sequence[tuple[str, str]],
    robot: Robot,
    chain: ExactChain,
    rows: Sequence[Row],
) -> None:
    """Raise if links that are said to touch always are apart in one of some poses.

    These are random ones, others at each end of each coordinate's range, and ``rows``.
    """
    if not pairs:
        return
    links = {*itertools.chain(*pairs)}
    if bare := sorted(name for name in links if not robot.links[name].shapes):
        raise Fault(f"{bare[0]} has no shape, and touches nothing")
    triangles = {name: in_frame(name, robot, chain) for name in links}
    for row in itertools.chain(rows, _random_rows(chain)):
        placed = placed_at(triangles, chain, row)
        for first, second in pairs:
            if not touch(placed[first], placed[second]):
                raise Fault(f"{first} and {second}, said to touch always, are apart in some pose")
    for first, second in pairs:
        if (wider := _with_held(robot, chain, first, second)) is None:
            continue
        both = {name: in_frame(name, robot, wider) for name in (first, second)}
        for row in _random_rows(wider):
            placed = placed_at(both, wider, row)
            if not touch(placed[first], placed[second]):
                why = "said to touch always, are apart where joints between are held elsewhere"
                raise Fault(f"{first} and {second}, {why}")


def _with_held(robot: Robot, chain: ExactChain, first: str, second: str) -> ExactChain | None:
    """The chain in which joints that are held between two links move, too; None without any."""
    above = {joint.child: joint for joint in robot.joints}
    ways: list[dict[str, str]] = [{}, {}]
    for link, way in zip((first, second), ways, strict=True):
        while link in above:
            way |= {link: above[link].coordinate} if above[link].kind != "fixed" else {}
            link = above[link].parent
    # by joints: what two of them follow in different ways is between, too
    names = {(ways[0] | ways[1])[child] for child in ways[0].keys() ^ ways[1].keys()}
    if names <= {*chain.coordinates}:
        return None
    free = replace(robot, couplings=())
    moved = exact_joints(free, tuple(sorted(names)), (0, 0, 0), int(chain.units))
    own = dict(zip(chain.coordinates, chain.limits, strict=True))  # a motion may have passed them
    others = zip(moved.coordinates, moved.limits, strict=True)
    return moved.within(tuple(own.get(name, ends) for name, ends in others))


def check_insides(
    robot: Robot,
    chain: ExactChain,
    row: Row,
    obstacles: Sequence[ExactSolid | ExactMesh],
    pairs: Iterable[tuple[str, Other]],
) -> None:
    """Raise if something is wholly inside a link where a motion begins.

    Pieces of a link may leave its inside out, into which nothing gets but through its surface.

    Args:
        robot: the robot.
        chain: its chain.
        row: coordinates there.
        obstacles: the obstacles.
        pairs: links, and what each has to keep clear of.

    Raises:
        Fault: it is.
    """
    links = {
        name: in_frame(name, robot, chain) for name in chain.frames if robot.links[name].shapes
    }
    placed: dict[Other, LinkTriangles] = dict(placed_at(links, chain, row).items())
    placed |= {number: solid_triangles(one) for number, one in enumerate(obstacles)}
    for link, other in pairs:
        if link in placed and other in placed:
            both = placed[link], placed[other]
            inside = isinstance(other, str) and holds(both[1], both[0])
            if inside or holds(*both):
                raise Fault(f"{link} and {name_of(other)} are inside each other")


def placed_at(
    triangles: Mapping[str, LinkTriangles], chain: ExactChain, row: Row
) -> dict[str, LinkTriangles]:
    """Triangles of links, given in the frames that move them, where these are at coordinates."""
    frames, placed = chain.place(row), {}
    for name, one in triangles.items():
        turn, origin = np.eye(3), np.zeros(3)
        if chain.frames[name] >= 0:
            frame = frames[chain.frames[name]]
            turn, origin = (part.astype(float) / 2.0**200 for part in frame[:2])
        placed[name] = one.placed(turn, origin)
    return placed


def in_frame(name: str, robot: Robot, chain: ExactChain, around: bool = False) -> LinkTriangles:
    """Triangles of a link in the frame that moves it, [unit]; in its cylinders, or around them."""
    pose = chain.places[name].astype(np.float64)
    turn, origin = pose[:3, :3], pose[:3, 3]
    return link_triangles(robot.links[name], float(chain.units), around).placed(turn, origin)


def _random_rows(chain: ExactChain) -> Iterator[list[Fraction]]:
    """Random coordinates, and random ones at each end of the range of each of them."""
    low, high = (np.array(one) for one in usual_range(chain))
    random = np.random.default_rng(0)
    rows = random.uniform(low, high, (_POSES, len(low)))
    for column, ends in enumerate(zip(low, high, strict=True)):
        at_ends = random.uniform(low, high, (2, len(low)))
        at_ends[:, column] = ends
        rows = np.concatenate([rows, at_ends])
    return ([Fraction(number) for number in row] for row in rows.tolist())


def usual_range(chain: ExactChain) -> tuple[list[float], list[float]]:
    """Lowest and highest positions of random poses: of a turning joint one turn near that about 0.

    It is all of its limits where what follows it is not as before after a turn.
    """
    found = []
    for number, (name, ends) in enumerate(zip(chain.coordinates, chain.limits, strict=True)):
        low, high = map(float, ends)
        moved = [joint for joint in chain.joints if joint.coordinate == name]
        whole = all(joint.factor % 1 == 0 for joint in moved)
        slides = chain.slides[number] or any(joint.kind == "prismatic" for joint in moved)
        if whole and not slides and low <= 0 <= high:
            low = max(low, min(-np.pi, high - 2 * np.pi))
            high = min(high, low + 2 * np.pi)
        found.append((low, high))
    return [low for low, _ in found], [high for _, high in found]
