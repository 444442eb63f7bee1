"""Contacts of an arm that count for nothing, each by a rule that one can read.

No pair of bodies is left out in silence: whatever is not kept apart is listed here with its reason.
"""

from __future__ import annotations

import itertools
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np

from abi.arrays import IntArray, read_only
from abi.robot.bodies.always_touching import always_touch
from abi.robot.bodies.chain_capsules import place
from abi.robot.bodies.finer_links import fitted_capsules
from abi.robot.bodies.link_bodies import Body
from abi.robot.bodies.never_touching import never_touch
from abi.robot.bodies.sampled_bodies import near_pairs, overlapping_pairs, sampled_poses
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.held_joints import NOT_HELD
from abi.robot.urdf.robot import Robot, meet

Reason = Literal["adjacent", "always", "never", "srdf", "mount", "asked", "grasp"]
Other = str | int
"""What a link may touch: a link or ``floor`` by name, an obstacle by its number from 0."""

SAMPLES = 1500
"""Random poses in which it is looked for links that are apart."""


class AllowedContact(NamedTuple):
    """A pair that may touch, and why.

    Attributes:
        link: name of a link.
        other: name of another link, ``floor``, number of an obstacle from 0, or ``obstacles`` for
            all of them.
        reason: ``adjacent``: no joint moves one beside the other, or one joint does and joins them;
            ``always``: they, not just their bodies, overlap in every random pose; ``never``: only
            their bodies do, and they are proven to be apart in all poses; ``srdf``: the robot's
            SRDF says so; ``mount``: the link stands still on it; ``asked``: the scene's
            ``arm.allowed`` says so; ``grasp``: it holds the object, or is fixed to what does.
    """

    link: str
    other: Other
    reason: Reason


@lru_cache(maxsize=16)
def link_pairs(
    robot: Robot,
    tip: str,
    held: tuple[tuple[str, float], ...] = (),
    asked: frozenset[frozenset[Other]] = frozenset(),
) -> tuple[IntArray, tuple[AllowedContact, ...]]:
    """Decide which links of a robot must keep apart.

    Args:
        robot: the robot.
        tip: name of the link that is the tool.
        held: joints beside the chain, each with its position, [rad] or [m].
        asked: pairs of links that the scene lets touch.

    Returns:
        Numbers of two capsules that must keep apart, (k, 2), and the pairs of links that may touch.
    """
    chain = Chain.of(robot, tip, held=dict(held) if held else NOT_HELD)
    capsules = fitted_capsules(chain)
    numbers: dict[str, list[int]] = {}
    for number, capsule in enumerate(capsules):
        numbers.setdefault(capsule.link, []).append(number)
    poses = sampled_poses(chain, SAMPLES)
    ends = place(capsules, chain.unpacked(poses))
    apart: list[tuple[int, int]] = []
    allowed: list[AllowedContact] = []
    for first, second in itertools.combinations(numbers, 2):
        pairs = [*itertools.product(numbers[first], numbers[second])]
        reason = _known_reason(chain, robot, asked, capsules[pairs[0][0]], capsules[pairs[0][1]])
        if reason is None:
            # in every pose a piece of one link is to overlap one of the other
            near = near_pairs(capsules, ends, pairs)
            always = (
                near.any(axis=1).all()
                and overlapping_pairs(chain, capsules, poses, pairs, near).any(axis=1).all()
            )
            reason = _constant_reason(chain, first, second) if always else None
        if reason is None:
            apart += pairs
        else:
            allowed.append(AllowedContact(first, second, reason))
    return read_only(np.array(sorted(apart), np.int32).reshape(-1, 2)), tuple(allowed)


def _constant_reason(chain: Chain, first: str, second: str) -> Literal["always", "never"] | None:
    """Reason for which two links whose bodies overlap in every pose need no proof in each.

    Args:
        chain: the joints that move.
        first: name of a link.
        second: name of another.
    """
    if always_touch(chain, first, second):
        return "always"
    return "never" if never_touch(chain, first, second) else None


def _known_reason(
    chain: Chain,
    robot: Robot,
    asked: frozenset[frozenset[Other]],
    first: Body,
    second: Body,
) -> Reason | None:
    """Reason for which the links of two capsules may touch whatever their bodies are."""
    links = first.link, second.link
    if reason := tree_reason(chain, links, (first.frame, second.frame)):
        return reason
    if frozenset(links) in robot.may_touch:
        return "srdf"
    return "asked" if frozenset(links) in asked else None


def tree_reason(
    chain: Chain, links: tuple[str, str], frames: tuple[int, int]
) -> Literal["adjacent", "grasp"] | None:
    """Reason for which two links may touch by their places in the robot's tree.

    What is fixed beside a joint, as a post at the rail of a carriage, is not joined by it; nor is
    an object that is held.

    Args:
        chain: the joints that move.
        links: names of the links.
        frames: number of the joint that moves each, -1 where it stands still.
    """
    robot, (first, second) = chain.robot, frames
    between = {*chain.behind(first)} ^ {*chain.behind(second)}
    if robot.attached in links:
        return None if between else "grasp"
    joined = not between or (len(between) == 1 and meet(robot, *links))
    return "adjacent" if joined else None
