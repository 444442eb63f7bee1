"""Convex bodies that contain a robot's collision shapes, and pairs of them that must stay apart.

Those that stand still come first; lengths are in [m].
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from abi.arrays import FloatArray, IntArray, flat, read_only
from abi.certification.posed_hulls_kernels import hulls_touch
from abi.errors import AbiError
from abi.robot.bodies.allowed_contacts import AllowedContact, Reason, tree_reason
from abi.robot.bodies.always_touching import always_touch
from abi.robot.bodies.capsule_table import Bodies
from abi.robot.bodies.chain_capsules import (
    carried_bodies,
    has_own_shape,
    hulls_of,
    lever,
    meeting,
)
from abi.robot.bodies.link_bodies import Body, Fit, link_bodies
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.robot import Robot

_SAMPLES, _ALWAYS = 200, 0.95


def robot_bodies(chain: Chain, closely: Collection[str] = frozenset()) -> tuple[Body, ...]:
    """Bodies of all links with collision shapes.

    Args:
        chain: the joints that move; slides get no farther than its limits.
        closely: names of links that are held more closely, by more bodies with more corners.

    Raises:
        AbiError: no link has a shape.
    """
    bodies = list[Body]()
    for link in chain.frames:
        fit: Fit = "close" if link in closely else "quick"
        bodies += carried_bodies(chain, link, link_bodies(chain.robot.links[link], fit))
    if not has_own_shape(chain, bodies):
        raise AbiError(
            "No link that moves has a collision shape, so nothing can be proven.",
            "Give the URDF with its <collision> elements and their meshes.",
        )
    bodies.sort(key=lambda body: body.frame)
    return tuple(bodies)


def body_pairs(chain: Chain, bodies: Sequence[Body]) -> tuple[IntArray, tuple[AllowedContact, ...]]:
    """Numbers of two bodies that must stay apart, (p, 2), and links that may touch."""
    held, numbers = tuple(sorted(chain.held.items())), _numbers(bodies)
    links, allowed = _link_pairs(chain.robot, chain.names, held, chain.limits.tobytes())
    apart = [
        pair
        for first, second in links
        for pair in itertools.product(numbers[first], numbers[second])
    ]
    return read_only(np.array(apart, dtype=np.int32).reshape(-1, 2)), allowed


def hulls_apart(chain: Chain, bodies: Sequence[Body], apart: IntArray, metres: float) -> Bodies:
    """Hulls of bodies in the format of the kernels, for coordinates in [rad] and [m].

    Args:
        chain: the chain that moves them.
        bodies: the bodies.
        apart: pairs of them that must stay apart, (p, 2).
        metres: one [unit] in metres.
    """
    one = [lever(chain, body.frame, body.points, -1) for body in bodies]
    return hulls_of(chain, bodies, metres)._replace(
        pairs=read_only(apart.reshape(-1)),
        point_levers=flat(np.array(one).reshape(-1) / metres),
        point_pair_levers=flat(_pair_levers(chain, bodies, apart).reshape(-1) / metres),
    )


@lru_cache(maxsize=32)
def _link_pairs(
    robot: Robot, names: tuple[str, ...], held: tuple[tuple[str, float], ...], limits: bytes
) -> tuple[tuple[tuple[str, str], ...], tuple[AllowedContact, ...]]:
    """Links of a robot that must keep apart, and that may touch, wherever it stands.

    They are found by some hundred random poses within ``limits`` of the coordinates, which are
    wider than the robot's where its motion passes these.
    """
    free = {joint.name for joint in robot.joints if joint.follows is None}
    still = {name: at for name, at in held if name in free}
    ranges = read_only(np.frombuffer(limits).reshape(-1, 2))
    chain = replace(Chain.moved_by(robot, names, held=still), limits=ranges)
    bodies = robot_bodies(chain)
    numbers = _numbers(bodies)
    apart, allowed = list[tuple[str, str]](), list[AllowedContact]()
    for first, second in itertools.combinations(numbers, 2):
        pairs = [*itertools.product(numbers[first], numbers[second])]
        reason = _reason(chain, bodies, (first, second), pairs)
        if reason is not None:
            allowed.append(AllowedContact(first, second, reason))
        else:
            apart.append((first, second))
    return tuple(apart), tuple(allowed)


def _numbers(bodies: Sequence[Body]) -> dict[str, list[int]]:
    """Numbers of each link's bodies."""
    numbers: dict[str, list[int]] = {}
    for number, body in enumerate(bodies):
        numbers.setdefault(body.link, []).append(number)
    return numbers


def _pair_levers(chain: Chain, bodies: Sequence[Body], apart: IntArray) -> FloatArray:
    """Bounds of the motion of two bodies beside each other, per unit of each coordinate, (p, n)."""
    found = np.zeros((len(apart), len(chain.names)))
    common: dict[tuple[int, int], int] = {}
    levers: dict[tuple[int, int], FloatArray] = {}  # a body is in many pairs
    for row, pair in zip(found, apart.tolist(), strict=True):
        frames = bodies[pair[0]].frame, bodies[pair[1]].frame
        if frames not in common:
            common[frames] = meeting(chain, *frames)
        for number in pair:
            key = number, common[frames]
            if key not in levers:
                body = bodies[number]
                levers[key] = lever(chain, body.frame, body.points, key[1])
            row += levers[key]
    return found


def _reason(
    chain: Chain,
    bodies: Sequence[Body],
    links: tuple[str, str],
    pairs: Sequence[tuple[int, int]],
) -> Reason | None:
    """Reason why two links may touch; None if they must not.

    ``always`` means that they touch in all of some random poses, their bodies in nearly all.

    Args:
        chain: the joints that move.
        bodies: those of all links.
        links: names of the two.
        pairs: numbers of a body of the one and a body of the other.
    """
    one, other = pairs[0]
    if reason := tree_reason(chain, links, (bodies[one].frame, bodies[other].frame)):
        return reason
    if frozenset(links) in chain.robot.may_touch:
        return "srdf"
    low, high = chain.usual_range().T
    poses = np.random.default_rng(0).uniform(low, high, (_SAMPLES, len(low)))
    numbers, few = np.unique(pairs, return_inverse=True)
    of_both = hulls_of(chain, [bodies[k] for k in numbers.tolist()], 1.0)
    hulls = of_both._replace(pairs=read_only(few.reshape(-1).astype(np.int32)))
    may_part = _SAMPLES - math.ceil(_ALWAYS * _SAMPLES)
    # most links part in the first poses
    for some in (poses[: 2 * may_part], poses[2 * may_part :]):
        may_part -= len(some) - hulls_touch(chain.table, hulls, flat(some), len(low))
        if may_part < 0:
            return None
    return "always" if always_touch(chain, *links) else None
