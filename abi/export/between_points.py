"""What a controller makes of a motion between its points, beside the straight way that is proven.

A ``joint_trajectory_controller`` joins points that have velocities and accelerations by quintic
polynomials, and points without by straight ways of the joints.
"""

from __future__ import annotations

import itertools

import numpy as np

from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arrays import FloatArray
from abi.obstacles.pose import METRES
from abi.planner.plan import Plan
from abi.robot.bodies.chain_capsules import lever
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.robot import LinkShape

_DEGREE = 5
_FIRST, _LAST = slice(None, -1), slice(1, None)


def polynomials_are_clear(plan: Plan) -> bool:
    """Check whether quintic polynomials between the points keep clear of obstacles as well.

    They do where no point of the arm leaves what is proven, the straight way of the joints or the
    curve of the paper's arm, by as much as the distance that is proven for it.

    Args:
        plan: with a motion that is proven clear.
    """
    return all(
        leg.arm_clearance is not None
        and leg.arm_clearance.distance > _departure(leg) + _from_curve(leg)
        for leg in plan.legs or (plan,)
    )


def rows_warning(plan: Plan) -> str:
    """Sentence for the paper's arm, where its poses are too few to go straight from one to another.

    It is proven clear along its curve; straight ways of the joints leave that. Empty where that is
    by less than the distance that is proven, and for arms whose straight ways are proven.
    """
    motion, clearance = plan.motion, plan.arm_clearance
    if motion is None or clearance is None or not clearance.certified:
        return ""
    if _from_curve(plan) < clearance.distance:
        return ""
    return (
        "It is clear along its curve, but that is not proven for straight ways of the joints "
        f"between its {len(motion.positions)} poses: raise motion.samples."
    )


def _from_curve(plan: Plan) -> float:
    """Distance by which straight ways of the joints leave the curve of the paper's arm, [unit].

    It is overestimated, as if every other pose were missing; 0 for arms whose straight ways are
    proven.
    """
    motion, arm = plan.motion, plan.arm
    if arm is None or motion is None or plan.scene.arm.model == "urdf" or len(motion.positions) < 3:
        return 0.0
    chords = (motion.positions[:-2] + motion.positions[2:]) / 2
    there, straight = arm.placed(motion.positions[1:-1]), arm.placed(chords)
    return max(
        float(np.linalg.norm(one.ends - other.ends, axis=-1).max())
        for one, other in zip(there, straight, strict=True)
    )


def _departure(plan: Plan) -> float:
    """Bound of the distance from the straight way of any point of the arm, [unit]."""
    assert plan.arm is not None
    assert plan.motion is not None
    metres, motion = METRES[plan.scene.unit], plan.motion
    scale = np.array([metres if slides else 1.0 for slides in motion.slides])
    between = _between(motion) * scale
    return float((between @ _levers(plan.arm.chain).T).max(initial=0.0)) / metres


def _between(motion: ArmMotion) -> FloatArray:
    """Bound of each joint's departure from the straight way between two samples, (m - 1, n).

    By the control points of the polynomial and of the straight way, whose hulls hold both.
    """
    steps = np.diff(motion.time)[:, None]
    ends = motion.positions[:-1], motion.positions[1:]
    by_speed = [steps * motion.joint_velocities[part] / _DEGREE for part in (_FIRST, _LAST)]
    by_growth = [
        steps**2 * motion.joint_accelerations[part] / (_DEGREE * (_DEGREE - 1))
        for part in (_FIRST, _LAST)
    ]
    chord = (ends[1] - ends[0]) / _DEGREE
    begin, end = by_speed[0] - chord, chord - by_speed[1]
    found = [begin, 2 * begin + by_growth[0], 2 * end + by_growth[1], end]
    bound: FloatArray = np.abs(found).max(axis=0)
    return bound


def _levers(chain: Chain) -> FloatArray:
    """Bound of the motion of each link's points per unit of each coordinate, (k, n), [m]."""
    rows = [np.zeros(len(chain.names))]
    for carried in chain.carried:
        shapes = chain.robot.links[carried.link].shapes
        points = [_corners(shape) for shape in shapes if carried.frame >= 0]
        if points:
            corners = np.concatenate(points) @ carried.pose[:3, :3].T + carried.pose[:3, 3]
            rows.append(lever(chain, carried.frame, corners, -1))
    return np.array(rows)


def _corners(shape: LinkShape) -> FloatArray:
    """Points whose hull holds a shape, (k, 3), in its link's frame, [m]."""
    a, b, c = shape.size
    half = {"box": (a / 2, b / 2, c / 2), "sphere": (a, a, a), "cylinder": (a, a, b / 2)}
    points = shape.vertices
    if shape.kind != "mesh":
        points = np.array([*itertools.product((-1.0, 1.0), repeat=3)]) * half[shape.kind]
    return points @ shape.pose[:3, :3].T + shape.pose[:3, 3]
