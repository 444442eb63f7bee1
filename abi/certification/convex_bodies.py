"""Convex bodies that contain a robot's collision shapes, and pairs of them that must stay apart."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from abi.arrays import FloatArray, IntArray, ShortRepr, flat, read_only
from abi.certification.posed_hulls_kernels import hulls_touch
from abi.errors import MotionError
from abi.robot.bodies.allowed_contacts import AllowedContact, Reason, tree_reason
from abi.robot.bodies.always_touching import always_touch
from abi.robot.bodies.capsule_table import Bodies
from abi.robot.bodies.chain_capsules import (
    ChainCapsule,
    carried_bodies,
    hulls_of,
    lever,
    meeting,
)
from abi.robot.bodies.floor_contacts import on_floor
from abi.robot.bodies.link_bodies import Fit, link_bodies
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.robot import Robot

_SAMPLES, _ALWAYS = 200, 0.95


@dataclass(frozen=True, eq=False, repr=False)
class RobotBodies(ShortRepr):
    """Convex bodies of a robot whose joints move with a chain.

    Attributes:
        chain: the joints that move, [m].
        bodies: the b bodies, those that stand still first.
        metres: one [unit] of the scene in metres.
        floor: height of the floor, [m].
    """

    chain: Chain
    bodies: tuple[ChainCapsule, ...]
    metres: float
    floor: float = -math.inf

    @cached_property
    def pairs(self) -> tuple[IntArray, tuple[AllowedContact, ...]]:
        """Numbers of two bodies that must stay apart, (p, 2), and links that may touch."""
        held, numbers = tuple(sorted(self.chain.held.items())), self._numbers()
        links, allowed = _link_pairs(self.chain.robot, self.chain.names, held)
        apart = [
            pair
            for first, second in links
            for pair in itertools.product(numbers[first], numbers[second])
        ]
        return read_only(np.array(apart, dtype=np.int32).reshape(-1, 2)), allowed

    def link_pairs(self) -> tuple[tuple[tuple[str, str], ...], tuple[AllowedContact, ...]]:
        """Find links that must keep apart, and that may touch, by some hundred random poses."""
        numbers = self._numbers()
        apart, allowed = list[tuple[str, str]](), list[AllowedContact]()
        for first, second in itertools.combinations(numbers, 2):
            pairs = [*itertools.product(numbers[first], numbers[second])]
            reason = self._reason(first, second, pairs)
            if reason is not None:
                allowed.append(AllowedContact(first, second, reason))
            else:
                apart.append((first, second))
        return tuple(apart), tuple(allowed)

    @property
    def allowed(self) -> tuple[AllowedContact, ...]:
        """Allowed contacts: pairs of links, and links that stand still."""
        still = dict.fromkeys(body.link for body in self.bodies if body.frame < 0)
        return (
            *self.pairs[1],
            *(AllowedContact(link, "obstacles", "mount") for link in still),
            *(AllowedContact(link, "floor", "mount") for link in self.on_floor),
        )

    @cached_property
    def on_floor(self) -> tuple[str, ...]:
        """Names of the links that may touch the floor."""
        return on_floor(self.chain, self.bodies, self.floor)

    @cached_property
    def hulls(self) -> Bodies:
        """Their hulls in the format of the kernels, for coordinates in [rad] and [m]."""
        apart, chain = self.pairs[0], self.chain
        one = [lever(chain, body.frame, body.points, -1) for body in self.bodies]
        both = [self._pair_lever(int(i), int(j)) for i, j in apart]
        levers = np.array(one).reshape(-1) / self.metres
        pair_levers = np.array(both).reshape(-1) / self.metres
        return hulls_of(self.chain, self.bodies, self.metres)._replace(
            pairs=read_only(apart.reshape(-1)),
            point_levers=flat(levers),
            point_pair_levers=flat(pair_levers),
        )

    def _numbers(self) -> dict[str, list[int]]:
        """Numbers of each link's bodies."""
        numbers: dict[str, list[int]] = {}
        for number, body in enumerate(self.bodies):
            numbers.setdefault(body.link, []).append(number)
        return numbers

    def _pair_lever(self, i: int, j: int) -> FloatArray:
        """Bound of the motion of two bodies beside each other, per unit of each coordinate, [m]."""
        first, second = self.bodies[i], self.bodies[j]
        common = meeting(self.chain, first.frame, second.frame)
        levers = (lever(self.chain, one.frame, one.points, common) for one in (first, second))
        return np.asarray(sum(levers))

    def _reason(self, first: str, second: str, pairs: Sequence[tuple[int, int]]) -> Reason | None:
        """Reason why two links may touch; None if they must not.

        ``always`` means that they touch in all of some random poses, their bodies in nearly all.
        """
        chain, (one, other) = self.chain, pairs[0]
        frames = self.bodies[one].frame, self.bodies[other].frame
        if reason := tree_reason(chain, (first, second), frames):
            return reason
        if frozenset((first, second)) in chain.robot.may_touch:
            return "srdf"
        low, high = chain.usual_range().T
        poses = np.random.default_rng(0).uniform(low, high, (_SAMPLES, len(low)))
        few = flat(np.array(pairs, dtype=float)).astype(np.int32)
        hulls = hulls_of(self.chain, self.bodies, self.metres)._replace(pairs=read_only(few))
        touching = hulls_touch(chain.table, hulls, flat(poses), len(low))
        overlap = touching >= _ALWAYS * _SAMPLES
        return "always" if overlap and always_touch(chain, first, second) else None


@lru_cache(maxsize=32)
def _link_pairs(
    robot: Robot, names: tuple[str, ...], held: tuple[tuple[str, float], ...]
) -> tuple[tuple[tuple[str, str], ...], tuple[AllowedContact, ...]]:
    """Links of a robot that must keep apart, and that may touch, wherever it stands."""
    free = {joint.name for joint in robot.joints if joint.mimic is None}
    still = {name: at for name, at in held if name in free}
    return robot_bodies(Chain.moved_by(robot, names, held=still), 1.0).link_pairs()


def robot_bodies(
    chain: Chain,
    metres: float,
    closely: Collection[str] = frozenset(),
    floor: float = -math.inf,
) -> RobotBodies:
    """Bodies of all links with collision shapes.

    Args:
        chain: the joints that move; slides get no farther than its limits.
        metres: one [unit] of the scene in metres.
        closely: names of links that are held more closely, by more bodies with more corners.
        floor: height of the floor, [m].

    Raises:
        MotionError: no link has a shape.
    """
    bodies = list[ChainCapsule]()
    for carried in chain.carried:
        fit: Fit = "close" if carried.link in closely else "quick"
        bodies += carried_bodies(carried, link_bodies(chain.robot.links[carried.link], fit))
    if not any(body.frame >= 0 for body in bodies):
        raise MotionError(
            "No link that moves has a collision shape, so nothing can be proven.",
            "Give the URDF with its <collision> elements and their meshes.",
        )
    bodies.sort(key=lambda body: body.frame)
    return RobotBodies(chain, tuple(bodies), metres, floor)
