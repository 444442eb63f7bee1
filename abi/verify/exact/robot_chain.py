"""The chain of a robot in exact numbers, as its URDF says.

Its matrices, read as floating-point numbers, are only nearly rotations; they are taken as they are,
and checked not to change any length by more than 2^-40 of it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from fractions import Fraction

import numpy as np

from abi.robot.urdf.couplings import require_followed
from abi.robot.urdf.held_joints import NOT_HELD, held_in_metres
from abi.robot.urdf.joint import Joint
from abi.robot.urdf.robot import Robot, joints_to
from abi.verify.exact.chain import ExactChain
from abi.verify.exact.frame import Exact, fractions, rounded, turned
from abi.verify.exact.solids import in_body
from abi.verify.fault import Fault

_NEARLY = Fraction(1, 1 << 45)


def exact_chain(
    robot: Robot,
    tip: str,
    base: Sequence[float],
    units: int,
    wxyz: Sequence[float] = (1, 0, 0, 0),
    held: Mapping[str, float] = NOT_HELD,
) -> ExactChain:
    """The chain from a robot's root, which stands at ``base`` [unit], to a tip.

    Args:
        robot: the robot.
        tip: name of a link.
        base: position of the root, [unit], world.
        units: [unit] in one metre.
        wxyz: rotation of the root, as a quaternion of any length but zero.
        held: positions of joints beside the chain, [rad] or [unit]; the others rest nearest to 0.

    Raises:
        Fault: a matrix is no rotation, or an axis no unit vector.
        SceneError: links move otherwise than they are posed.
    """
    return _exact_tree(robot, _moving_joints(robot, tip), tip, (base, wxyz), units, held)


def exact_joints(
    robot: Robot,
    names: tuple[str, ...],
    base: Sequence[float],
    units: int,
    wxyz: Sequence[float] = (1, 0, 0, 0),
    held: Mapping[str, float] = NOT_HELD,
) -> ExactChain:
    """All joints that move with those of some names, as of two arms; the last has the tip's frame.

    Args:
        robot: the robot.
        names: joints that move by themselves.
        base: position of the root, [unit], world.
        units: [unit] in one metre.
        wxyz: rotation of the root, as a quaternion of any length but zero.
        held: positions of other joints, [rad] or [unit]; the others rest nearest to 0.

    Raises:
        Fault: a matrix is no rotation, or an axis no unit vector.
        SceneError: links move otherwise than they are posed.
    """
    joints = tuple(
        joint for joint in robot.joints if joint.kind != "fixed" and joint.coordinate in names
    )
    tip = joints[-1].child
    return _exact_tree(robot, (joints, names), tip, (base, wxyz), units, held)


def _exact_tree(
    robot: Robot,
    moving: tuple[tuple[Joint, ...], tuple[str, ...]],
    tip: str,
    stands: tuple[Sequence[float], Sequence[float]],
    units: int,
    held: Mapping[str, float],
) -> ExactChain:
    (joints, names), (base, wxyz) = moving, stands
    by_name = {joint.name: joint for joint in robot.joints}
    require_followed(robot, names, held_in_metres(robot, held, 1 / units))
    positions = _at_rest(robot, names, held, units)
    root = fractions(np.eye(4))
    root[:3, :3] = [in_body(axis, wxyz) for axis in root[:3, :3]]
    root[:3, 3] = fractions(np.array(base))
    frames = {robot.root: (-1, root)}
    before, origins = [-1] * len(joints), [root] * len(joints)
    for joint in robot.joints:
        frame, pose = frames[joint.parent]
        pose = pose @ _matrix(joint, units)
        if joint in joints:
            axis = fractions(joint.axis)
            if abs(axis @ axis - 1) > _NEARLY:
                raise Fault(f"the axis of {joint.name} is no direction")
            number = joints.index(joint)
            before[number], origins[number] = frame, pose
            frame, pose = number, fractions(np.eye(4))
        elif joint.kind != "fixed":
            pose = _moved(pose, joint, positions[joint.name], units)
        frames[joint.child] = frame, pose
    last, pose = frames[tip]
    coordinates = [by_name[name] for name in names]
    slides = tuple(joint.kind == "prismatic" for joint in coordinates)
    limits = tuple(
        (scale * Fraction(joint.low), scale * Fraction(joint.high))
        for joint, scale in ((j, units if j.kind == "prismatic" else 1) for j in coordinates)
    )
    return ExactChain(
        *(joints, (*before, last), (*origins, pose), names),
        {link: frame for link, (frame, _) in frames.items()},
        {link: place for link, (_, place) in frames.items()},
        *(Fraction(units), limits, slides),
    )


def _moving_joints(robot: Robot, tip: str) -> tuple[tuple[Joint, ...], tuple[str, ...]]:
    """Joints that move with the coordinates of a tip, and the names of these."""
    way = tuple(joint for joint in joints_to(robot, tip) if joint.kind != "fixed")
    names = {joint.coordinate: None for joint in way}
    beside = [
        joint
        for joint in robot.joints
        if joint.kind != "fixed" and joint not in way
        if joint.coordinate in names
    ]
    return (*way, *beside), (*names,)


def _at_rest(
    robot: Robot, names: Collection[str], held: Mapping[str, float], units: int
) -> dict[str, Fraction]:
    """Positions of the joints that stand still, [rad] or [m]."""
    found: dict[str, Fraction] = {}
    for joint in robot.joints:
        if joint.follows is None and joint.name not in names:
            found[joint.name] = Fraction(min(max(0.0, joint.low), joint.high))
            if joint.name in held:
                scale = units if joint.kind == "prismatic" else 1
                found[joint.name] = Fraction(held[joint.name]) / scale
    for joint in robot.joints:
        if joint.follows in found:
            at = found[joint.follows]
            found[joint.name] = Fraction(joint.factor) * at + Fraction(joint.offset)
    return found


def _moved(pose: Exact, joint: Joint, position: Fraction, units: int) -> Exact:
    """A pose behind a joint that stands still, whose turn is rounded as those in a URDF are."""
    motion = fractions(np.eye(4))
    if joint.kind == "prismatic":
        motion[:3, 3] = fractions(joint.axis) * position * units
    else:
        motion[:3, :3] = rounded(turned(joint, position)[0])
    return np.asarray(pose @ motion)


def _matrix(joint: Joint, units: int) -> Exact:
    """Pose of a joint in the frame of its parent, (4, 4), [unit]."""
    origin = fractions(joint.origin)
    turn = origin[:3, :3]
    if (abs(turn @ turn.T - np.eye(3, dtype=object)) > _NEARLY).any():
        raise Fault(f"the origin of {joint.name} is no rotation")
    origin[:3, 3] *= units
    return origin
