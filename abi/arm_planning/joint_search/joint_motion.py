"""Motions along a joint-space curve: their timing, samples and clearance."""

from __future__ import annotations

import numpy as np
import scipy

from abi.arm_planning.joint_search.joint_spline import JointSpline
from abi.arm_planning.motion.arm_clearance import ArmClearance, is_clear
from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arm_planning.motion.urdf_motion import ChainJointPath
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arrays import FloatArray, read_only
from abi.curves.bspline import clamped
from abi.curves.cubic_profile import PathProfile
from abi.robot.urdf_arm import UrdfArm

_GRID = 1201
_FINE = 4801
"""Points by which the curve is measured."""
_DRAWN = 400
"""Edges of the polyline that stands for the tool's path."""
_RAMP = 0.25
"""Fraction of a slow part over which the speed falls at its beginning and rises at its end."""
_FINER = (1, 2, 4)
"""Factors for the number of samples that are tried until a motion is proven clear."""
TURN = 0.25
"""Distance that a turn by 1 rad counts as, over the arm's reach."""


def slow_rates(places: FloatArray, part: tuple[float, float], factor: float) -> FloatArray:
    """Factors (k,) by which the distance grows faster at parameters (k,) of a curve.

    Args:
        places: the parameters, from 0 to 1.
        part: those at which the slow part begins and ends, in which the factors rise and fall
            smoothly.
        factor: the largest, at least 1.
    """
    begin, end = part
    ramp = _RAMP * (end - begin) + 1e-12
    # a motion that begins or ends in the part has no other speed to come from
    up = np.ones_like(places) if begin <= 0 else (places - begin) / ramp
    down = np.ones_like(places) if end >= 1 else (end - places) / ramp
    share = np.clip(np.minimum(up, down), 0.0, 1.0)
    return np.asarray(1 + (factor - 1) * share**2 * (3 - 2 * share))


def passage_of(
    spline: JointSpline,
    arm: UrdfArm,
    slow: tuple[float, float] = (0.0, 1.0),
    factor: float = 1.0,
) -> ChainJointPath:
    """Parametrise a joint-space curve, whose ends differ, by distance.

    Where the tool moves by dx and the joints by dq, the distance grows by the root of dx² + r² dq²,
    r being a quarter of the arm's reach: a tool that stands still while the joints turn takes time,
    too, and none moves faster than the distance does. In a slow part it grows faster still.

    Args:
        spline: the curve.
        arm: the arm.
        slow: parameters between which it is passed more slowly.
        factor: by which the distance grows faster there, at least 1.
    """
    places = np.linspace(0.0, 1.0, _FINE)
    positions = spline(places)
    tool = arm.tool(positions)
    turned = np.diff(positions, axis=0) * np.where(arm.chain.slides, 1.0, TURN * arm.reach)
    moved = np.diff(tool, axis=0)
    steps = np.sqrt((moved**2).sum(1) + (turned**2).sum(1))
    if factor > 1:
        steps *= slow_rates((places[1:] + places[:-1]) / 2, slow, factor)
    passed = np.concatenate([[0.0], np.cumsum(steps)])
    goes_on = np.concatenate([[True], np.diff(passed) > 1e-12 * passed[-1]])
    back = scipy.interpolate.PchipInterpolator(passed[goes_on], places[goes_on])
    equal = np.clip(back(np.linspace(0.0, passed[-1], _GRID)), 0.0, 1.0)
    equal[-1] = 1.0
    curve = clamped(tool[:: (_FINE - 1) // _DRAWN], 1)
    met = read_only(np.zeros(_GRID))
    return ChainJointPath(curve, None, arm, read_only(spline(equal)), met, float(passed[-1]))


def proven_motion(
    passage: ChainJointPath,
    profile: PathProfile,
    samples: int,
    collision_world: CollisionWorld,
    required: float,
) -> tuple[ArmMotion, ArmClearance]:
    """Motion by a profile and its clearance, with more samples if it is not proven clear otherwise.

    Between samples the joints go straight, which takes them off the curve: past an obstacle that
    this nearly touches, only samples that are near enough to each other keep clear.

    Args:
        passage: the way of the joints.
        profile: of the motion.
        samples: at least so many.
        collision_world: everything around the arm.
        required: distance that the links are to keep from obstacles, [unit].

    Returns:
        The first motion that is proven clear, or the last that was tried.
    """
    for times in _FINER:
        motion = passage.motion(profile, times * (samples - 1) + 1)
        clearance = passage.clearance(motion, collision_world, required)
        if is_clear(motion, clearance):
            break
    return motion, clearance
