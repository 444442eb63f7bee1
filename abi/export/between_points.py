"""What a controller makes of a motion between its points, beside the straight way that is proven.

A ``joint_trajectory_controller`` joins points that have velocities and accelerations by quintic
polynomials, and points without by straight ways of the joints.
"""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Iterator, Sequence

import numpy as np

from abi.arm_planning.motion.arm_clearance import distance_from_itself
from abi.arm_planning.motion.trajectory import Quantity, Violation
from abi.arrays import FloatArray
from abi.certification.clearance_proof import problem_of, separation
from abi.certification.joint_limits import joint_limits
from abi.certification.motion import Motion
from abi.certification.robot_motion import RobotMotion, bezier_points
from abi.curves.clearance.certificate import Certificate
from abi.errors import AbiError
from abi.explain.arm_faults import limit_sentence
from abi.planner.plan import Plan
from abi.robot.any_arm import AnyArm
from abi.robot.bodies.chain_capsules import lever
from abi.robot.kinematics.chain import Chain
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.robot.urdf.link import LinkShape
from abi.scene.scene import Scene

_NOTICED = 1.001
"""A limit that is passed by less than this factor, as by rounding of differences, is let pass."""


def polynomials_are_clear(plan: Plan) -> bool:
    """Check whether quintic polynomials between the points are proven to keep clear as well.

    They keep clear of obstacles, the floor and the arm itself, and within limits of position, and
    of speed where the motion does. Those of a URDF arm are proven as :func:`abi.certify` does it.
    Those of the paper's arm do where no point of it leaves the curve by as much as the distance
    that is proven, and that measured of it.

    Args:
        plan: with a motion that is proven clear.
    """
    for leg, moves in _legs(plan):
        if moves is None or _leave_limits(leg, joint_limits(moves).passed):
            return False
        if (paper_arm := leg.paper_arm) is not None:
            clearance, away = leg.arm_clearance, _departure(paper_arm, moves)
            if clearance is None or clearance.distance <= away + _from_curve(leg):
                return False
            if _own_distance(leg, paper_arm) <= away:
                return False
        elif not _is_proven(moves, leg.scene):
            return False
    return True


def growth_warning(plan: Plan) -> str:
    """Sentence on the worst acceleration of such polynomials beyond a limit that the samples keep.

    Where accelerations jump, as those of the fastest motion do, polynomials swing beyond. Empty
    where none is passed, and without a motion.
    """
    motion = plan.motion
    if motion is None or motion.error is not None:
        return ""
    found = []
    for leg, moves in _legs(plan):
        if moves is None:
            return ""  # its samples pass limits, which is told
        passed = joint_limits(moves, leg.scene.motion.joint_acceleration).passed
        if _leave_limits(leg, passed):
            return ""  # the points have positions alone
        found += _beyond(leg, "acceleration", passed)
    if not found:
        return ""
    worst = max(found, key=lambda one: one.value / one.limit)
    return (
        "Quintic polynomials between its points pass a limit that the points keep: "
        f"{limit_sentence(worst, motion, 'm')} With motion.law: jerk_limited accelerations do not "
        "jump."
    )


def _leave_limits(leg: Plan, passed: Sequence[Violation]) -> bool:
    """Check whether polynomials pass a limit for which straight ways are better."""
    return any(one.quantity == "position" for one in passed) or bool(_beyond(leg, "speed", passed))


def _beyond(leg: Plan, quantity: Quantity, passed: Sequence[Violation]) -> list[Violation]:
    """Those of some limits of rates that the samples of a leg keep and its polynomials do not."""
    if leg.joint_rates is None or leg.joint_rates.nominal:
        return []
    known = {(one.joint, one.quantity) for one in leg.limits_passed}
    return [
        one
        for one in passed
        if one.quantity == quantity
        and (one.joint, quantity) not in known
        and one.value / one.limit > _NOTICED
    ]


def _legs(plan: Plan) -> Iterator[tuple[Plan, RobotMotion | None]]:
    """Each leg of a plan with its polynomials, and the plan itself if it has none.

    There are none of a leg whose joints are faster than can be judged.
    """
    first = 0
    for leg in plan.legs or (plan,):
        assert leg.motion is not None
        last = first + len(leg.motion.time) - 1  # where the next leg begins
        moves = None
        with contextlib.suppress(AbiError):
            moves = _polynomials(plan, leg, slice(first, last + 1))
        yield leg, moves
        first = last


def _polynomials(plan: Plan, leg: Plan, rows: slice) -> RobotMotion:
    """Quintic polynomials between the points of a leg of a motion, [rad] and [m].

    Its arm has what that leg holds, and its gripper as on that leg.
    """
    motion, arm = plan.motion, leg.arm
    assert motion is not None
    assert arm is not None
    tables = motion.positions, motion.joint_velocities, motion.joint_accelerations
    q, v, a = (one[rows] / arm.scales for one in tables)
    given = Motion(arm.chain.names, motion.time[rows], q, v, a)
    return RobotMotion(given, arm.chain, bezier_points(given), ())


def _is_proven(moves: RobotMotion, scene: Scene) -> bool:
    """Check whether a motion is proven clear, but for what the scene lets touch."""
    asked = {frozenset(pair) for pair in scene.arm.allowed}
    closely: frozenset[str] = frozenset()
    for _ in range(2):
        found = separation(problem_of(moves, scene, closely), 0.0)
        if isinstance(found, Certificate):
            return True
        left = {(one.link, one.other) for one in found}
        left = {pair for pair in left if frozenset(pair) not in asked}
        if not left:
            return True
        closely = frozenset(one for pair in left for one in pair if isinstance(one, str))
    return False


def rows_warning(plan: Plan) -> str:
    """Sentence for the paper's arm, where its poses are too few to go straight from one to another.

    It is proven clear along its curve; straight ways of the joints leave that. Empty where that is
    by less than the distance that is proven, and for arms whose straight ways are proven.
    """
    motion, clearance = plan.motion, plan.arm_clearance
    if motion is None or clearance is None or not clearance.certified:
        return ""
    arm = plan.paper_arm
    if arm is None or (_from_curve(plan) < clearance.distance and _own_distance(plan, arm) > 0):
        return ""
    return (
        "It is clear along its curve, but that is not proven for straight ways of the joints "
        f"between its {len(motion.positions)} poses: raise motion.samples."
    )


def _from_curve(plan: Plan) -> float:
    """Distance by which straight ways of the joints leave the curve of the paper's arm, [unit].

    It is overestimated, as if every other pose were missing.
    """
    motion, arm = plan.motion, plan.arm
    if arm is None or motion is None or len(motion.positions) < 3:
        return 0.0
    chords = (motion.positions[:-2] + motion.positions[2:]) / 2
    away = arm.place(motion.positions[1:-1]) - arm.place(chords)
    return float(np.linalg.norm(away, axis=-1).max())


def _own_distance(plan: Plan, arm: PaperArm) -> float:
    """Bound of the paper's arm's distance from floor and column on straight ways, [unit].

    No point is farther from the nearest pose than half the way between two.
    """
    motion = plan.motion
    assert motion is not None
    half = _farthest(arm, np.abs(np.diff(motion.positions / arm.scales, axis=0))) / 2
    return distance_from_itself(motion, arm, plan.scene.workspace.min[2]) - half


def _departure(arm: AnyArm, moves: RobotMotion) -> float:
    """Bound of the distance of any point of an arm from the straight way, [unit].

    By the control points of the polynomial and of the straight way, whose hulls hold both.
    """
    points = moves.points
    shares = np.linspace(0.0, 1.0, points.shape[1])[:, None]
    straight = points[:, :1] + shares * (points[:, -1:] - points[:, :1])
    return _farthest(arm, np.abs(points - straight).max(axis=1))


def _farthest(arm: AnyArm, ways: FloatArray) -> float:
    """Bound of how far a point of an arm gets, [unit], by ways of its joints (k, n), [rad], [m]."""
    in_metres = float((ways @ _levers(arm.chain).T).max(initial=0.0))
    return in_metres / arm.metres


def _levers(chain: Chain) -> FloatArray:
    """Bound of the motion of each link's points per unit of each coordinate, (k, n), [m]."""
    rows = [np.zeros(len(chain.names))]
    for link, frame in chain.frames.items():
        shapes, pose = chain.robot.links[link].shapes, chain.places[link]
        points = [_corners(shape) for shape in shapes if frame >= 0]
        if points:
            corners = np.concatenate(points) @ pose[:3, :3].T + pose[:3, 3]
            rows.append(lever(chain, frame, corners, -1))
    return np.array(rows)


def _corners(shape: LinkShape) -> FloatArray:
    """Points whose hull holds a shape, (k, 3), in its link's frame, [m]."""
    a, b, c = shape.size
    half = {"box": (a / 2, b / 2, c / 2), "sphere": (a, a, a), "cylinder": (a, a, b / 2)}
    points = shape.vertices
    if shape.kind != "mesh":
        points = np.array([*itertools.product((-1.0, 1.0), repeat=3)]) * half[shape.kind]
    return points @ shape.pose[:3, :3].T + shape.pose[:3, 3]
