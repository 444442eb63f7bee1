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

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from abi import arguments
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arm_planning.world.solid_rows import FLOOR, Own, RowTable
from abi.arrays import FloatArray, IntArray, ShortRepr, flat, read_only
from abi.certification.convex_bodies import RobotBodies, robot_bodies
from abi.certification.posed_hulls_kernels import nearest_obstacle
from abi.certification.robot_motion import RobotMotion
from abi.certification.separate_motion_kernels import separate_motion
from abi.curves.clearance.separation_kernels import REFUTED, SPENT
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import METRES
from abi.obstacles.primitive_kernels import BOUNDS, WIDTH
from abi.obstacles.primitive_tree_kernels import TREE
from abi.scene.scene import Scene

MOST_TRIES = 4_000_000
"""Default number of pairs that are tried before the rest counts as undecided: a few seconds."""
PARTS = 1024
"""Parts of a motion; stretches shorter than one are not halved where bodies overlap."""


@dataclass(frozen=True, eq=False, repr=False)
class Separation(ShortRepr):
    """What separating directions prove of a motion, and the stretches that remain.

    Attributes:
        margin: distance that the bodies were to keep from obstacles, [unit].
        pieces: first and last parameter of each direction, (k, 2).
        poses: parameter of the pose around which each holds, (k,).
        bodies: number of its body, (k,).
        others: number of its obstacle, ``FLOOR``, or -2 less the number of another body, (k,).
        directions: unit vectors towards the body, (k, 3), world.
        left: first and last parameter of each stretch and pair without a direction, and a pose on
            it, (l, 3).
        left_bodies, left_others: the same of these, (l,).
        touching: whether a pair of bodies, or a body and an obstacle, overlap at that pose, (l,).
        spent: whether the budget ended.
    """

    margin: float
    pieces: FloatArray
    poses: FloatArray
    bodies: IntArray
    others: IntArray
    directions: FloatArray
    left: FloatArray
    left_bodies: IntArray
    left_others: IntArray
    touching: IntArray
    spent: bool

    @property
    def proven(self) -> bool:
        """Whether nothing remains."""
        return len(self.left) == 0


@dataclass(frozen=True, eq=False, repr=False)
class MotionProblem(ShortRepr):
    """A motion, the bodies that move, and what they keep clear of.

    Attributes:
        motion: the motion.
        bodies: the bodies.
        around: obstacles and the floor.
        obstacles: the obstacles.
    """

    motion: RobotMotion
    bodies: RobotBodies
    around: CollisionWorld
    obstacles: ObstacleSet


def problem_of(
    motion: RobotMotion, scene: Scene, closely: Collection[str] = frozenset()
) -> MotionProblem:
    """Bodies and collision world of a motion in a scene; ``closely`` as for ``robot_bodies``."""
    metres = METRES[scene.unit]
    low = np.minimum(motion.chain.limits[:, 0], motion.points.min(axis=(0, 1)))
    high = np.maximum(motion.chain.limits[:, 1], motion.points.max(axis=(0, 1)))
    # a motion may pass limits; levers hold where it goes
    chain = replace(motion.chain, limits=read_only(np.stack([low, high], axis=1)))
    floor = min(scene.arm.base[2], scene.workspace.min[2])
    bodies = robot_bodies(chain, metres, closely, floor * metres)
    obstacles = ObstacleSet(scene.obstacles)
    return MotionProblem(motion, bodies, _around(bodies, obstacles, floor, scene), obstacles)


def separation(
    problem: MotionProblem, margin: float, most_tries: int = MOST_TRIES, to_the_end: bool = True
) -> Separation:
    """Prove as much of a motion as can be proven to keep more than a margin from obstacles.

    Args:
        problem: the motion.
        margin: distance to keep from obstacles, at least 0, [unit]; from floor and other links 0.
        most_tries: pairs to try at most.
        to_the_end: whether to go on once something is left.
    """
    points = problem.motion.points
    finest = min(1.0, len(points) / PARTS)
    planes, left, outcomes = separate_motion(
        problem.bodies.chain.table,
        problem.bodies.hulls,
        flat(points),
        points.shape[1],
        problem.around.beyond(margin),
        finest,
        most_tries,
        to_the_end,
    )
    bodies, others = _numbers(problem, planes[:, 2])
    left_bodies, left_others = _numbers(problem, left[:, 2])
    return Separation(
        margin=margin,
        pieces=read_only(planes[:, :2].copy()),
        poses=read_only(planes[:, 6].copy()),
        bodies=bodies,
        others=others,
        directions=read_only(planes[:, 3:6].copy()),
        left=read_only(left[:, [0, 1, 6]]),
        left_bodies=left_bodies,
        left_others=left_others,
        touching=read_only((outcomes == REFUTED).astype(np.int32)),
        spent=bool((outcomes == SPENT).any()),
    )


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
        problem.bodies.chain.table,
        problem.bodies.hulls,
        joints,
        len(problem.bodies.chain.names),
        problem.around.beyond(0.0),
    )
    if sample < 0:
        return distance, None
    body, row = divmod(pair, len(problem.around.numbers))
    time = problem.motion.time_at(float(parameters[sample]))
    link = problem.bodies.bodies[body].link
    return distance, (link, int(problem.around.numbers[row]), time)


def _numbers(problem: MotionProblem, pairs: FloatArray) -> tuple[IntArray, IntArray]:
    """Numbers of the bodies of pairs (k,), and of what each is separated from."""
    numbers, count = pairs.astype(np.int64), len(problem.around.numbers)
    behind = numbers - len(problem.bodies.bodies) * count
    own, apart = behind >= 0, problem.bodies.pairs[0]
    links = apart[np.where(own, behind, 0)] if own.any() else np.zeros((len(numbers), 2), int)
    bodies = np.where(own, links[:, 1], numbers // count)
    others = np.where(own, -2 - links[:, 0], problem.around.numbers[numbers % count])
    return read_only(bodies.astype(np.int32)), read_only(others.astype(np.int32))


def _around(
    bodies: RobotBodies, obstacles: ObstacleSet, floor: float, scene: Scene
) -> CollisionWorld:
    """Obstacles and floor, without links that stand still."""
    frames = np.array([body.frame for body in bodies.bodies])
    stands = np.array([body.link in bodies.on_floor for body in bodies.bodies])
    own = Own(read_only(np.zeros(0)), np.array([FLOOR], dtype=np.int32), ~stands[:, None])
    solids = RowTable()(obstacles, own)
    asked = np.zeros((len(frames), len(solids.numbers)), dtype=np.bool_)
    asked[:, solids.outer] = (frames >= 0)[:, None]
    asked[:, -1] = ~stands
    corners = solids.rows.reshape(-1, WIDTH)[solids.outer[:-1], BOUNDS:TREE]
    reach = 2 * bodies.chain.table.reach / bodies.metres
    points = max(float(np.abs(body.points).max()) for body in bodies.bodies) / bodies.metres
    size = float(np.abs(scene.arm.base).max()) + reach + points
    size += float(np.abs(corners).max(initial=0.0))
    return CollisionWorld(solids, read_only(asked), floor, size)
