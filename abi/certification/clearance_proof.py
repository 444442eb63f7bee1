"""Proofs that convex bodies of a robot keep clear while its joints follow polynomials of time.

Theorem. Let the joints stay within w_j of a pose on a stretch of the motion, each coordinate j, so
that every point of a body, the convex hull of points P with a radius r around it, moves by at most
W = sum of lever_j w_j from where it is at the pose. Let O be a compact convex set with the support
function h, and let abs(n) = 1. If min over P of n·p at the pose - h(n) > m + r + W, then the body
stays farther than m from O all along.

Proof. As in :mod:`abi.arm_planning.certificates.chain_certificate`, with as many points as the body
has instead of the ends of a segment. Between waypoints a joint is a polynomial of time; on a part
of it its values lie between those of its Bézier points there, so w_j is the largest distance of
these from the pose.

If no direction separates a pair, both halves of the stretch are tried. Rounding: an extra 2^-40 of
the largest coordinate is required. :mod:`abi.verify.verify_motion` checks it in exact arithmetic.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from abi import arguments
from abi.arm_planning.world.collision_world import FLOOR, CollisionWorld
from abi.arm_planning.world.mount import beneath
from abi.arm_planning.world.row_table import RowTable, own_world
from abi.arrays import BoolArray, FloatArray, IntArray, ShortRepr, flat, read_only
from abi.certification.convex_bodies import body_pairs, hulls_apart, robot_bodies
from abi.certification.posed_hulls_kernels import nearest_obstacle
from abi.certification.robot_motion import RobotMotion
from abi.certification.separate_motion_kernels import separate_motion
from abi.curves.clearance.certificate import Certificate
from abi.curves.clearance.separation_kernels import REFUTED, SPENT
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import METRES
from abi.robot.bodies.allowed_contacts import AllowedContact
from abi.robot.bodies.capsule_table import Bodies
from abi.robot.bodies.floor_contacts import floor_notes, on_floor
from abi.robot.bodies.held_links import held_notes, mount_notes
from abi.robot.bodies.link_bodies import Body
from abi.robot.bodies.link_solids import LinkSolids
from abi.robot.kinematics.chain import Chain
from abi.scene.scene import Scene

MOST_TRIES = 4_000_000
"""Default number of pairs that are tried before the rest counts as undecided: a few seconds."""
PARTS = 1024
"""Parts of a motion; stretches shorter than one are not halved where bodies overlap."""


@dataclass(frozen=True, eq=False, repr=False)
class MotionProblem(ShortRepr):
    """A motion, the convex bodies that it moves, and what they keep clear of.

    Attributes:
        motion: the motion.
        chain: its joints, with limits that hold wherever it goes, [m].
        bodies: the b bodies, those that stand still first, [m].
        around: obstacles and the floor.
        under: numbers of the obstacles that the robot stands on.
        asked: links, and numbers of obstacles that the scene lets them touch.
        metres: one [unit] in metres.
    """

    motion: RobotMotion
    chain: Chain
    bodies: tuple[Body, ...]
    around: CollisionWorld
    under: tuple[int, ...]
    asked: tuple[tuple[str, int], ...]
    metres: float

    @cached_property
    def pairs(self) -> tuple[IntArray, tuple[AllowedContact, ...]]:
        """Numbers of two bodies that must stay apart, (p, 2), and links that may touch."""
        return body_pairs(self.chain, self.bodies)

    @cached_property
    def hulls(self) -> Bodies:
        """The bodies in the format of the kernels, for coordinates in [rad] and [m]."""
        return hulls_apart(self.chain, self.bodies, self.pairs[0], self.metres)

    @cached_property
    def solids(self) -> tuple[LinkSolids, ...]:
        """The exact shape of each obstacle."""
        return tuple(LinkSolids((shape,)) for shape in self.around.obstacles)

    @property
    def allowed(self) -> tuple[AllowedContact, ...]:
        """Allowed contacts: pairs of links, and links that stand still."""
        still = dict.fromkeys(body.link for body in self.bodies if body.frame < 0)
        standing = on_floor(self.chain, self.bodies, self.around.floor * self.metres)
        return (
            *self.pairs[1],
            *(AllowedContact(link, "obstacles", "mount") for link in still),
            *(AllowedContact(*pair, "asked") for pair in self.asked if pair[0] in still),
            *(AllowedContact(link, "floor", "mount") for link in standing),
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences on how the motion was read, and on what is not compared."""
        return (*self.motion.notes, *self.not_compared)

    @cached_property
    def not_compared(self) -> tuple[str, ...]:
        """Sentences on links that are below the floor, or held in others."""
        standing = [one.link for one in self.allowed if one.other == "floor"]
        floor = self.around.floor * self.metres
        mounts = {number: self.around.obstacles[number] for number in self.under}
        return (
            *floor_notes(self.chain, standing, floor),
            *held_notes(self.chain, floor),
            *mount_notes(self.chain, mounts, self.metres),
        )

    def named(self, number: int) -> int | str:
        """Number of an obstacle, or name of another link or of the floor."""
        if number >= 0:
            return number
        return "floor" if number == FLOOR else self.bodies[-number - 2].link


class UndecidedPair(NamedTuple):
    """A link, what it may touch, and the stretches on which no direction separates them.

    Attributes:
        link: name of the link.
        other: number of an obstacle, name of another link, or ``floor``.
        left: first and last parameter of each stretch, in order, and a pose on it, (k, 3).
        overlaps: whether bodies of theirs overlap at that pose, (k,).
        spent: whether the tries ended before all was decided.
    """

    link: str
    other: int | str
    left: FloatArray
    overlaps: BoolArray
    spent: bool


def problem_of(
    motion: RobotMotion, scene: Scene, closely: Collection[str] = frozenset()
) -> MotionProblem:
    """Bodies and collision world of a motion in a scene; ``closely`` as for ``robot_bodies``."""
    low = np.minimum(motion.chain.limits[:, 0], motion.points.min(axis=(0, 1)))
    high = np.maximum(motion.chain.limits[:, 1], motion.points.max(axis=(0, 1)))
    # a motion may pass limits; levers hold where it goes
    chain = replace(motion.chain, limits=read_only(np.stack([low, high], axis=1)))
    bodies = robot_bodies(chain, closely)
    around, metres = _around(chain, bodies, scene), METRES[scene.unit]
    under = beneath(np.array(scene.arm.base), scene.arm.base_wxyz, metres, around.obstacles)
    asked = tuple((link, k) for link, k in scene.arm.allowed if not isinstance(k, str))
    return MotionProblem(motion, chain, bodies, around, under, asked, metres)


def separation(
    problem: MotionProblem, margin: float, most_tries: int = MOST_TRIES, to_the_end: bool = True
) -> Certificate | tuple[UndecidedPair, ...]:
    """Prove that a motion keeps more than a margin from obstacles, or find what is undecided.

    Args:
        problem: the motion.
        margin: distance to keep from obstacles, at least 0, [unit]; from floor and other links 0.
        most_tries: pairs to try at most.
        to_the_end: whether to go on once something is left.
    """
    points = problem.motion.points
    planes, left, outcomes = separate_motion(
        problem.chain.table,
        problem.hulls,
        flat(points),
        points.shape[1],
        problem.around.beyond(margin),
        min(1.0, len(points) / PARTS),
        most_tries,
        to_the_end,
    )
    if len(left):
        return _undecided(problem, left, outcomes)
    bodies, others = _numbers(problem, planes[:, 2])
    return Certificate(
        margin=margin if len(problem.around.obstacles) else math.inf,
        pieces=read_only(planes[:, :2].copy()),
        poses=read_only(planes[:, 6].copy()),
        capsule=bodies,
        obstacle=others,
        directions=read_only(planes[:, 3:6].copy()),
    )


def _undecided(
    problem: MotionProblem, left: FloatArray, outcomes: FloatArray
) -> tuple[UndecidedPair, ...]:
    """What is left of a motion by pairs, in the order in which these begin.

    Args:
        problem: the motion.
        left: rows of the kernel, (k, 7).
        outcomes: their outcomes, (k,).
    """
    bodies, others = _numbers(problem, left[:, 2])
    links, of_link = np.unique([body.link for body in problem.bodies], return_inverse=True)
    numbers, of_number = np.unique(others, return_inverse=True)
    names = [problem.named(one) for one in numbers.tolist()]
    known = {name: number for number, name in enumerate(dict.fromkeys(names))}
    of_other = np.array([known[name] for name in names], dtype=np.int64)[of_number]
    keys = of_link[bodies] * len(known) + of_other
    order, spent = np.lexsort((left[:, 0], keys)), bool((outcomes == SPENT).any())
    found = []
    for chosen in np.split(order, np.flatnonzero(np.diff(keys[order])) + 1):
        link, other = divmod(int(keys[chosen[0]]), len(known))
        rows, overlaps = left[chosen][:, [0, 1, 6]], outcomes[chosen] == REFUTED
        found.append(UndecidedPair(str(links[link]), [*known][other], rows, overlaps, spent))
    return tuple(sorted(found, key=lambda pair: float(pair.left[0, 0])))


def nearest(
    problem: MotionProblem, parameters: FloatArray
) -> tuple[float, tuple[str, int, float] | None]:
    """Find where the bodies are nearest to an obstacle at parameters (k,).

    Returns:
        The distance, [unit], and its link, obstacle and time, [s]; inf and None without obstacles.
    """
    parameters = arguments.numbers("parameters", parameters, (-1,))
    joints = flat(problem.motion.positions_at(parameters))
    distance, pair, sample = nearest_obstacle(
        problem.chain.table,
        problem.hulls,
        joints,
        len(problem.chain.names),
        problem.around.beyond(0.0),
    )
    if sample < 0:
        return distance, None
    body, row = divmod(pair, len(problem.around.numbers))
    time = problem.motion.time_at(float(parameters[sample]))
    link = problem.bodies[body].link
    return distance, (link, int(problem.around.numbers[row]), time)


def _numbers(problem: MotionProblem, pairs: FloatArray) -> tuple[IntArray, IntArray]:
    """Numbers of the bodies of pairs (k,), and of what each is separated from."""
    numbers, count = pairs.astype(np.int64), len(problem.around.numbers)
    behind = numbers - len(problem.bodies) * count
    own, apart = behind >= 0, problem.pairs[0]
    links = apart[np.where(own, behind, 0)] if own.any() else np.zeros((len(numbers), 2), int)
    bodies = np.where(own, links[:, 1], numbers // count)
    others = np.where(own, -2 - links[:, 0], problem.around.numbers[numbers % count])
    return read_only(bodies.astype(np.int32)), read_only(others.astype(np.int32))


def _around(chain: Chain, bodies: Sequence[Body], scene: Scene) -> CollisionWorld:
    """Obstacles and floor, without links that stand still."""
    metres, floor = METRES[scene.unit], min(scene.arm.base[2], scene.workspace.min[2])
    standing = on_floor(chain, bodies, floor * metres)
    frames = np.array([body.frame for body in bodies])
    stands = np.array([body.link in standing for body in bodies])
    reach = 2 * chain.table.reach / metres
    points = max(float(np.abs(body.points).max()) for body in bodies) / metres
    size = float(np.abs(scene.arm.base).max()) + reach + points
    numbers = np.array([FLOOR], dtype=np.int32)
    own = own_world(read_only(np.zeros(0)), numbers, ~stands[:, None], floor, size)
    world = RowTable()(ObstacleSet(scene.obstacles), own)
    return replace(world, asked=read_only(world.asked & (frames >= 0)[:, None]))
