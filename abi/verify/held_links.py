"""Links that held joints carry, by their own triangles: what of them no proof compares."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Container, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from abi.scene.scene import Scene
from abi.verify.allowed_contacts import in_frame, placed_at, usual_range
from abi.verify.exact.chain import ExactChain
from abi.verify.exact.mesh import ExactMesh
from abi.verify.exact.robot_chain import exact_joints
from abi.verify.exact.solids import ExactSolid
from abi.verify.fault import Fault
from abi.verify.link_contact import LinkTriangles, boxes_overlap, solid_triangles, touch
from abi.verify.plumb_line import is_beneath

_SUNK = 2e-3
"""Depth below the floor, or in what is beneath the base, that is told, [m]."""
_DEEP = -1e-9
"""Depth in an obstacle from which on links touch it, over the size of both, as a nearness."""
_PAIRS = 400_000_000
"""Pairs of triangles of two links that are compared, at most."""
_POSITIONS = 8
_MOST = 6


def held_below_floor(scene: Scene, chain: ExactChain) -> list[str]:
    """Links that stand still below the floor because a joint holds them there, in order."""
    floor = min(scene.arm.base[2], scene.workspace.min[2]) - _SUNK * float(chain.units)
    carried = _carriers(scene, chain)
    found = []
    for name, one in _shaped(scene, chain).items():
        lowest = (one.corners[..., 2].min(axis=1) - one.radii).min()
        if chain.frames[name] < 0 and carried[name] and lowest < floor:
            found.append(name)
    return sorted(found)


def held_in_each_other(
    scene: Scene, chain: ExactChain, allowed: Collection[Collection[str | int]] = ()
) -> str:
    """What is said of links that touch where joints hold them, as a sentence's end.

    Those that touch wherever these joints are, ``allowed`` pairs and those of the SRDF are no such
    links, nor are they where a joint that is planned moves one beside the other.
    """
    carried, shaped = _carriers(scene, chain), _shaped(scene, chain)
    attached = scene.robot.attached
    may_touch = {*scene.robot.may_touch, *map(frozenset, allowed)}
    may_touch |= {frozenset(one.ends) for one in scene.robot.couplings}
    found, left = [], []
    for first, second in itertools.combinations(shaped, 2):
        between = {*carried[first]} ^ {*carried[second]}
        apart = chain.frames[first] != chain.frames[second] or not between
        one, other = shaped[first], shaped[second]
        if apart or {first, second} in may_touch or not boxes_overlap(one, other):
            continue
        if attached in (first, second):
            holding, name = carried[attached], first if second == attached else second
            if carried[name][:-1] == holding:
                continue  # as fingers, which what holds the object carries by one joint
        if len(one.corners) * len(other.corners) > _PAIRS:
            left.append(f"{second} and {first}")
        elif touch(one, other) and not _always_touch(scene, chain, between, (first, second)):
            found.append(f"{second} and {first}")
    words = _listed("touching where they are held", found)
    return words + _listed("too finely divided to compare where they are held", left)


def held_in_mounts(
    scene: Scene,
    chain: ExactChain,
    obstacles: Sequence[ExactSolid | ExactMesh],
    asked: Container[tuple[str, int | str]],
) -> str:
    """What is said of links that joints hold in what the robot stands on, as a sentence's end.

    They are compared a little above where they are, so that what stands on it is apart; ``asked``
    pairs are not.
    """
    carried, units = _carriers(scene, chain), float(chain.units)
    up = np.array(chain.places[scene.robot.root][:3, 2], dtype=np.float64)
    raised = {
        name: one.placed(np.eye(3), _SUNK * units * up)
        for name, one in _still(scene, chain).items()
        if carried[name]
    }
    found = [
        f"{name} in obstacle {number + 1}"
        for name, number in _in_obstacles(scene, chain, raised, obstacles, asked, beneath=True)
    ]
    return _listed("held in what the robot stands on", found)


def check_still(
    scene: Scene,
    chain: ExactChain,
    obstacles: Sequence[ExactSolid | ExactMesh],
    asked: Container[tuple[str, int | str]],
) -> None:
    """Raise if a link that stands still is in an obstacle that is not beneath the base.

    But for ``asked`` pairs.
    """
    still = {name: in_frame(name, scene.robot, chain, around=True) for name in _still(scene, chain)}
    for name, number in _in_obstacles(scene, chain, still, obstacles, asked, beneath=False):
        raise Fault(f"{name} stands in obstacle {number + 1}")


def _in_obstacles(
    scene: Scene,
    chain: ExactChain,
    links: Mapping[str, LinkTriangles],
    obstacles: Sequence[ExactSolid | ExactMesh],
    asked: Container[tuple[str, int | str]],
    beneath: bool,
) -> list[tuple[str, int]]:
    """Links, and numbers of obstacles that they touch and may not, beneath the base or not."""
    arm, found = scene.arm, []
    for number, obstacle in enumerate(obstacles):
        solid = solid_triangles(obstacle, around=not beneath)
        near = [
            name
            for name, one in links.items()
            if (name, number) not in asked and boxes_overlap(one, solid)
        ]
        stands = near and is_beneath(
            obstacle, np.array(arm.base), arm.base_wxyz, float(chain.units)
        )
        if near and stands == beneath:
            found += [(name, number) for name in near if touch(links[name], solid, _DEEP)]
    return found


def _always_touch(
    scene: Scene, chain: ExactChain, between: Collection[str], links: tuple[str, str]
) -> bool:
    """Check whether two links touch wherever the joints between them are, at some positions."""
    by_name = {joint.name: joint for joint in scene.robot.joints}
    names = tuple({by_name[name].coordinate: None for name in between})
    if {*names} & {*chain.coordinates}:
        return False
    robot, units = replace(scene.robot, couplings=()), int(chain.units)
    held = {name: at for name, at in scene.arm.gripper.items() if name not in names}
    moved = exact_joints(robot, names, (0, 0, 0), units, held=held)
    triangles = {name: in_frame(name, robot, moved) for name in links}
    low, high = (np.array(ends) for ends in usual_range(moved))
    for numbers in np.random.default_rng(7).uniform(low, high, (_POSITIONS, len(low))).tolist():
        row = [Fraction(number) for number in numbers]
        one, other = placed_at(triangles, moved, row).values()
        if not touch(one, other):
            return False
    return True


def _carriers(scene: Scene, chain: ExactChain) -> dict[str, tuple[str, ...]]:
    """Names of the joints, but for fixed ones, between the root and each link."""
    found: dict[str, tuple[str, ...]] = {scene.robot.root: ()}
    for joint in scene.robot.joints:
        own = () if joint.kind == "fixed" else (joint.name,)
        found[joint.child] = found[joint.parent] + own
    return {name: found[name] for name in chain.frames}


def _shaped(scene: Scene, chain: ExactChain) -> dict[str, LinkTriangles]:
    """Triangles of each link in the frame that moves it."""
    robot = scene.robot
    names = (name for name in chain.frames if robot.links[name].shapes)
    return {name: in_frame(name, robot, chain) for name in names}


def _still(scene: Scene, chain: ExactChain) -> dict[str, LinkTriangles]:
    """Triangles of each link that stands still, world, [unit]."""
    return {name: one for name, one in _shaped(scene, chain).items() if chain.frames[name] < 0}


def _listed(what: str, names: Sequence[str]) -> str:
    """The first of some names, and how many more there are, as a sentence's end."""
    more = f" and {len(names) - _MOST} more" if len(names) > _MOST else ""
    return f"; {what}: {', '.join(names[:_MOST])}{more}" if names else ""
