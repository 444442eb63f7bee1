"""The verdict on a motion: proofs by separating directions, and contacts of the exact shapes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from operator import attrgetter, itemgetter

import numpy as np

from abi import arguments
from abi.arm_planning.motion.arm_clearance import Contact
from abi.arrays import BoolArray, FloatArray, IntArray
from abi.certification import exact_contact
from abi.certification.clearance_proof import (
    MOST_TRIES,
    MotionProblem,
    UndecidedPair,
    nearest,
    problem_of,
    separation,
)
from abi.certification.joint_limits import LimitsKept, joint_limits
from abi.certification.kept_direction import KeptDirection, kept_direction
from abi.certification.motion import Motion
from abi.certification.robot_motion import robot_motion
from abi.certification.verdict import Doubt, MotionVerdict, State, TimeStretch
from abi.curves.clearance.certificate import Certificate
from abi.obstacles.mesh_shape import MeshShape
from abi.robot.bodies.link_solids import link_solids
from abi.robot.kinematics.chain_kernels import chain_poses
from abi.scene.scene import Scene

_SHARES = (0.95, 0.8, 0.6, 0.4, 0.2)
"""Fractions of the least distance found that are tried to prove."""
_POSES, _PAIRS = 20, 12
"""Most poses of a pair, and most pairs, at which exact shapes are tested."""
_DEPTHS = 4
"""Most poses of a contact at which its depth is measured, besides both ends, ..."""
_HALVINGS = 3
"""... and how often the stretch around the deepest of them is halved."""
_ENDS_AND_BETWEEN = 5
"""Poses in which links that are said to touch always have to."""
_BISECTIONS = 18
_STATES: tuple[State, ...] = ("clear", "undecided", "touches")
_RIM = "A cylinder is compared by its edges: whoever stands nearer than its roundness has to move."
_FINEST = 1e-9
"""Distance below which shapes may touch or not by rounding, over the largest coordinate."""


def certify_motion(
    motion: Motion,
    scene: Scene,
    start: Mapping[str, float] | None = None,
    clearance: float = 0.0,
    acceleration: float | None = None,
    most_tries: int = MOST_TRIES,
) -> MotionVerdict:
    """Decide whether a motion keeps a scene's robot clear, and beside that limits and direction.

    Args:
        motion: the motion.
        scene: with the robot, where it stands, and the obstacles.
        start: positions of joints in which the robot stands, [rad] or [m]; None if not known.
        clearance: distance to keep from obstacles, [unit].
        acceleration: largest of each joint, [rad/s²], of sliding ones [m/s²]; None for no limit.
        most_tries: pairs of bodies and obstacles to try at most.

    Raises:
        AbiError: the motion is none of the robot's, or its first waypoint is far from the start.
        ArgumentError: an argument is out of range.
    """
    clearance = arguments.number("clearance", clearance, 0.0, math.inf)
    if acceleration is not None:
        acceleration = arguments.number("acceleration", acceleration, 0.0, math.inf)
    if start is not None:
        start = {name: arguments.number(f"start[{name!r}]", at) for name, at in start.items()}
    moves = robot_motion(motion, scene, start)
    beside = joint_limits(moves, acceleration), kept_direction(moves, scene)
    verdict = _verdict(problem_of(moves, scene), scene, beside, clearance, most_tries)
    if verdict.state != "undecided":
        return verdict
    # bodies of few corners, which are soon proven clear, may touch where the links do not
    links = {str(name) for one in verdict.doubts for name in (one.link, one.obstacle)}
    closely = links & {*moves.chain.robot.links}
    return _verdict(problem_of(moves, scene, closely), scene, beside, clearance, most_tries)


def _verdict(
    problem: MotionProblem,
    scene: Scene,
    beside: tuple[LimitsKept, KeptDirection | None],
    clearance: float,
    most_tries: int,
) -> MotionVerdict:
    """What the bodies prove; where they do not, what the exact shapes decide."""
    motion = problem.motion.motion
    found = separation(problem, clearance, most_tries)
    distance, least = nearest(problem, np.arange(0.0, len(motion.times) - 0.5, 0.5))
    standing_in, standing_near = _standing_in(problem)
    inside = [*_inside(problem), *standing_in]
    if isinstance(found, Certificate) and not inside:
        ends = _times(problem, 0.0, len(problem.motion.points))
        if apart := (*_apart_though_allowed(problem), *standing_near):
            whole = (TimeStretch(*ends, "undecided"),)
            return MotionVerdict(
                *("undecided", scene, problem, distance, least, (), apart, whole),
                *(*beside, None),
            )
        proof = _wider(problem, found, distance, most_tries)
        whole = (TimeStretch(*ends, "clear"),)
        return MotionVerdict(
            *("clear", scene, problem, proof.margin, least, (), (), whole), *(*beside, proof)
        )
    pairs = () if isinstance(found, Certificate) else found
    touches, doubts, stretches = _decided(problem, pairs, inside, clearance)
    state: State = "touches" if touches else "undecided"
    return MotionVerdict(
        *(state, scene, problem, distance, least, touches, doubts, stretches, *beside, None)
    )


def _inside(problem: MotionProblem) -> list[tuple[str, int]]:
    """Links that begin inside a closed mesh, whose surface alone is tested.

    Where a link touches no triangle, one of its points says whether all of it is inside.
    """
    found = []
    first = problem.motion.positions_at(np.array([0.0]))
    poses = problem.chain.poses(first)[0]
    for number, obstacle in enumerate(problem.around.obstacles):
        if obstacle.convex:
            continue
        for body in problem.bodies:
            if body.frame >= 0:
                frame = poses[body.frame]
                point = frame[:, :3] @ body.points[0] + frame[:, 3]
                if obstacle.signed_distance(point[None] / problem.metres)[0] < 0:
                    found.append((body.link, number))
    return list(dict.fromkeys(found))


def _standing_in(problem: MotionProblem) -> tuple[list[tuple[str, int]], list[Doubt]]:
    """Links that stand still, and the obstacles not beneath the base that they are, or may be, in.

    Whether the rim of a cylinder touches what its edges do not is not decided.
    """
    obstacles = problem.around.obstacles
    if not obstacles.obstacles:
        return [], []
    metres = problem.metres
    low, high = obstacles.bounds
    found: list[tuple[str, int]] = []
    doubts: list[Doubt] = []
    whole = _times(problem, 0.0, float(len(problem.motion.points)))
    for name, frame in problem.chain.frames.items():
        link, pose = problem.chain.robot.links[name], problem.chain.places[name]
        if frame >= 0 or not link.shapes:
            continue
        solids = link_solids(link, 1 / metres)
        first, second, radii = solids.edges
        reach = radii[:, None] + solids.bulge
        turn, origin = pose[:3, :3], pose[:3, 3] / metres
        ends = np.stack([first, second]) @ turn.T + origin
        near = (low <= (ends + reach).max(axis=(0, 1))).all(axis=1)
        near &= (high >= (ends - reach).min(axis=(0, 1))).all(axis=1)
        for number in np.flatnonzero(near).tolist():
            if number in problem.under or (name, number) in problem.asked:
                continue
            if exact_contact.touches(problem, 0.0, name, number):
                found.append((name, number))
            elif exact_contact.may_touch(problem, 0.0, name, number):
                away = max(exact_contact.distance(problem, 0.0, name, number), 0.0)
                doubts.append(Doubt(*whole, name, number, away, _RIM))
    return found, doubts


def _apart_though_allowed(problem: MotionProblem) -> tuple[Doubt, ...]:
    """Pairs that are said to touch always, and whose exact shapes are apart in some pose.

    No proof tells whether such a pair touches elsewhere.
    """
    always = [one for one in problem.pairs[1] if one.reason == "always"]
    if not always:
        return ()
    end, doubts = float(len(problem.motion.points)), []
    for link, other, _ in always:
        assert isinstance(other, str)
        for at in np.linspace(0.0, end, _ENDS_AND_BETWEEN).tolist():
            if not exact_contact.touches(problem, at, link, other):
                why = f"Convex pieces that fit {link} and {other} more closely would decide it."
                away = exact_contact.distance(problem, at, link, other)
                doubts.append(Doubt(*_times(problem, 0.0, end), link, other, away, why))
                break
    return tuple(doubts)


def _wider(
    problem: MotionProblem, proof: Certificate, distance: float, most_tries: int
) -> Certificate:
    """A proof for the largest possible of some fractions of the least distance found."""
    if not 0 < distance < math.inf:
        return proof
    for share in _SHARES:
        if share * distance <= proof.margin:
            break
        wider = separation(problem, share * distance, most_tries, to_the_end=False)
        if isinstance(wider, Certificate):
            return wider
    return proof


def _decided(
    problem: MotionProblem,
    pairs: Sequence[UndecidedPair],
    inside: Iterable[tuple[str, int]],
    clearance: float,
) -> tuple[tuple[Contact, ...], tuple[Doubt, ...], tuple[TimeStretch, ...]]:
    """Contacts, doubts, and stretches of time."""
    touches, doubts = [], []
    touching = np.zeros((0, 2))
    if len(pairs) > _PAIRS:  # more poses than are placed as fast without it
        chain_poses.compile()
    for link, obstacle in inside:
        first, last = _times(problem, 0.0, float(len(problem.motion.points)))
        deep = exact_contact.depth(problem, 0.0, link, obstacle)
        touches.append(Contact(link, obstacle, first, last, first, deep))
        touching = np.array([[0.0, float(len(problem.motion.points))]])
    for number, pair in enumerate(pairs):
        step = max(1, math.ceil(len(pair.left) / _POSES))
        rows = np.arange(0, len(pair.left), step, dtype=np.int32)
        # the last stretch is where a motion ends, and often deepest
        rows = np.union1d(rows, [len(pair.left) - 1])[: None if number < _PAIRS else 0]
        poses = pair.left[rows, 2].tolist()
        hit = np.array([_touches_at(problem, pair, at) for at in poses], dtype=bool)
        if hit.any():
            found = _touches(problem, pair, rows, hit)
            touches += found
            nearest_tested = np.searchsorted(rows, np.arange(len(pair.left)), "right") - 1
            spans = np.array([(one.first, one.last) for one in found])
            spans = np.interp(
                spans, problem.motion.motion.times, np.arange(len(problem.motion.points) + 1)
            )
            touching = np.concatenate([touching, pair.left[hit[nearest_tested], :2], spans])
        else:
            doubts.append(_doubt(problem, pair, clearance))
    touches.sort(key=attrgetter("first"))
    doubts.sort(key=attrgetter("first"))
    left = np.concatenate([np.zeros((0, 2)), *(pair.left[:, :2] for pair in pairs)])
    return tuple(touches), tuple(doubts), _stretches(problem, left, touching)


def _touches_at(problem: MotionProblem, pair: UndecidedPair, parameter: float) -> bool:
    """Decide whether the exact shapes of a pair touch at a parameter."""
    return exact_contact.touches(problem, parameter, pair.link, pair.other)


def _touches(
    problem: MotionProblem, pair: UndecidedPair, rows: IntArray, hit: BoolArray
) -> list[Contact]:
    """Contacts of a pair in order, each from its first time, found by bisection.

    Args:
        problem: the motion.
        pair: the pair.
        rows: numbers of its stretches that were tested, (k,).
        hit: whether it touches on these, (k,).
    """
    ends = np.maximum.accumulate(pair.left[:, 1])
    apart = np.concatenate([[0], np.cumsum(pair.left[1:, 0] > ends[:-1])])[rows]
    begins = hit & np.concatenate([[True], ~hit[:-1] | (apart[1:] != apart[:-1])])
    found = []
    for number, first in enumerate(np.flatnonzero(begins).tolist()):
        of_one = np.flatnonzero(hit & (np.cumsum(begins) == number + 1))
        low = float(pair.left[rows[first], 0])
        if first > 0 and apart[first - 1] == apart[first]:
            low = float(pair.left[rows[first - 1], 2])
        at = _first_contact(problem, pair, low, float(pair.left[rows[first], 2]))
        end = float(ends[rows[of_one[-1]]])
        few = of_one[:: math.ceil(len(of_one) / _DEPTHS)]
        deepest, depth = _deepest(problem, pair, [at, *pair.left[rows[few], 2].tolist(), end])
        first_time, last, deep = (problem.motion.time_at(one) for one in (at, end, deepest))
        found.append(Contact(pair.link, pair.other, first_time, last, deep, depth))
    return found


def _deepest(
    problem: MotionProblem, pair: UndecidedPair, poses: Sequence[float]
) -> tuple[float, float]:
    """Parameter at which a pair is deepest, near the deepest of some poses in order, and depth."""

    def measured(at: float) -> tuple[float, float]:
        return exact_contact.depth(problem, at, pair.link, pair.other), at

    tried = [measured(at) for at in poses]
    for _ in range(_HALVINGS):
        best = tried.index(max(tried))
        around = [at for _, at in tried[max(best - 1, 0) : best + 2]]
        halves = [measured((one + other) / 2) for one, other in itertools.pairwise(around)]
        tried = sorted([*tried, *halves], key=itemgetter(1))
    depth, deepest = max(tried)
    return deepest, depth


def _first_contact(problem: MotionProblem, pair: UndecidedPair, low: float, high: float) -> float:
    """The first parameter from ``low`` on at which a pair touches, which it does at ``high``."""
    if _touches_at(problem, pair, low):
        return low
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if _touches_at(problem, pair, middle):
            high = middle
        else:
            low = middle
    return high


def _doubt(problem: MotionProblem, pair: UndecidedPair, clearance: float) -> Doubt:
    """A pair that neither was found to touch nor is proven clear."""
    first, last = _times(problem, float(pair.left[0, 0]), float(pair.left[:, 1].max()))
    middle = float(pair.left[len(pair.left) // 2, 2])
    distance = exact_contact.distance(problem, middle, pair.link, pair.other)
    if pair.spent:
        why = "More tries would decide it."
    elif distance > max(clearance, _FINEST * problem.around.size) and pair.overlaps.any():
        why = _what_fits(problem, pair)
    elif distance < clearance:
        why = "It is nearer than the clearance asked for, and does not touch: ask for less."
    else:
        why = "Shapes so near to each other cannot be decided in floating point: keep away."
    return Doubt(first, last, pair.link, pair.other, distance, why)


def _what_fits(problem: MotionProblem, pair: UndecidedPair) -> str:
    """Sentence on what stands for a pair's shapes, is larger than these, and so decides nothing.

    A box is its own piece; a triangle of a mesh is in a flat box that is larger.
    """
    link, other = pair.link, pair.other
    links = problem.chain.robot.links
    named = [one for one in (link, other) if isinstance(one, str) and one in links]
    loose = [one for one in named if any(shape.kind != "box" for shape in links[one].shapes)]
    larger = []
    if isinstance(other, int) and isinstance(problem.around.obstacles[other], MeshShape):
        larger.append(f"smaller triangles of obstacle {other + 1}")
    if loose or not larger:
        fitting = " and ".join(loose or [link])
        larger.insert(0, f"convex pieces that fit {fitting} more closely")
    text = " or ".join(larger)
    return f"{text[0].upper()}{text[1:]} would decide it."


def _stretches(
    problem: MotionProblem, left: FloatArray, touching: FloatArray
) -> tuple[TimeStretch, ...]:
    """The motion in the order of time: what touches, what is undecided, and what is proven.

    Args:
        problem: the motion.
        left: parameters between which something is undecided, (k, 2).
        touching: those between which something touches, (l, 2).
    """
    ends = [0.0, float(len(problem.motion.points))]
    cuts = np.unique(np.concatenate([ends, left.ravel(), touching.ravel()]))
    middles = (cuts[1:] + cuts[:-1]) / 2
    number = np.where(_covered(middles, left), 1, 0)
    number[_covered(middles, touching)] = 2
    begins = np.flatnonzero(np.diff(number, prepend=-1))
    found = []
    for first, last in zip(begins.tolist(), [*begins[1:].tolist(), len(number)], strict=True):
        times = _times(problem, float(cuts[first]), float(cuts[last]))
        found.append(TimeStretch(*times, _STATES[number[first]]))
    return tuple(found)


def _covered(places: FloatArray, stretches: FloatArray) -> BoolArray:
    """Check which places (k,) are in any of some stretches (n, 2)."""
    begun = np.searchsorted(np.sort(stretches[:, 0]), places, "right")
    ended = np.searchsorted(np.sort(stretches[:, 1]), places, "left")
    return np.asarray(begun > ended)


def _times(problem: MotionProblem, first: float, last: float) -> tuple[float, float]:
    """Times of two parameters, [s]."""
    return problem.motion.time_at(first), problem.motion.time_at(last)
