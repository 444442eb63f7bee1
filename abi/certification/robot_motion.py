"""A motion as the robot of a scene carries it out: its joints in order, and polynomials of time."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, ShortRepr, read_only
from abi.certification.motion import Motion
from abi.certification.stated_poses import (
    check_followers,
    check_start,
    check_state,
    unused_state,
)
from abi.errors import AbiError, SceneError
from abi.obstacles.pose import METRES
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.couplings import require_followed
from abi.robot.urdf.held_joints import held_in_metres, planned_joints
from abi.robot.urdf.joint import Joint
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.urdf_joints import some_of
from abi.scene.scene import Scene

_PAST, _TURN, _TURNS = 1.0, 2 * math.pi, 6 * math.pi
"""Angle past a limit, and angle of such a joint and of a continuous one, from which on degrees are
suspected, [rad]."""


@dataclass(frozen=True, eq=False, repr=False)
class RobotMotion(ShortRepr):
    """A motion of a robot's joints; all others stand still.

    The parameter of the k-th waypoint is k; between two of them it is the share of the time.

    Attributes:
        motion: with the joints in the order of the chain's coordinates.
        chain: the joints that move, standing in the world, [m].
        points: Bézier points of each piece, shape (m - 1, degree + 1, n), [rad] or [m].
        notes: sentences on what was assumed.
    """

    motion: Motion
    chain: Chain
    points: FloatArray
    notes: tuple[str, ...]

    def __post_init__(self) -> None:
        shape = len(self.motion.times) - 1, -1, len(self.chain.names)
        arguments.keep(self, points=arguments.numbers("points", self.points, shape))

    @property
    def degree(self) -> int:
        """Degree of the polynomials."""
        return int(self.points.shape[1]) - 1

    def time_at(self, parameter: float) -> float:
        """Time of a parameter, [s], or number of the waypoint if no times are known."""
        times = self.motion.times
        return float(np.interp(parameter, np.arange(len(times)), times))

    def positions_at(self, parameters: FloatArray) -> FloatArray:
        """Joint positions at parameters (k,), shape (k, n), [rad] or [m]."""
        parameters = arguments.numbers("parameters", parameters, (-1,))
        piece = np.clip(parameters.astype(int), 0, len(self.points) - 1)
        return on_curves(self.points[piece], parameters - piece)

    def rates_at(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Joint positions, speeds and accelerations at parameters (k,), each of shape (k, n).

        Where a speed jumps, at the waypoints of a straight motion, it is that of the later piece.
        """
        piece = np.clip(parameters.astype(int), 0, len(self.points) - 1)
        points, found = self.points[piece], []
        spans = np.diff(self.motion.times)[piece][:, None, None]
        for _ in range(3):
            found.append(on_curves(points, parameters - piece))
            degree = points.shape[1] - 1
            points = degree * np.diff(points, axis=1) / spans if degree else 0 * points
        return found[0], found[1], found[2]


def on_curves(points: FloatArray, shares: FloatArray) -> FloatArray:
    """Places (k, n) on Bézier curves with points (k, d + 1, n), at shares (k,) of them."""
    while points.shape[1] > 1:
        points = points[:, :-1] + shares[:, None, None] * (points[:, 1:] - points[:, :-1])
    return np.asarray(points[:, 0])


def robot_motion(
    motion: Motion, scene: Scene, start: Mapping[str, float] | None = None
) -> RobotMotion:
    """Match a motion with the robot of a scene.

    Args:
        motion: the motion.
        scene: with the robot, where it stands, and joints of its gripper that are held.
        start: positions of joints that the robot stands at, [rad] or [m]; None if not known.

    Raises:
        AbiError: a joint is unknown or missing, angles look like degrees, the first waypoint is
            far from the start, a joint is not where one that it follows takes it, or the robot's
            state in the file is another than the scene's; names row, joint and unit.
    """
    robot, given = scene.robot, motion
    motion, notes = _matched(motion, robot, scene.arm.tool)
    _suspect_degrees(motion, robot)
    notes += _long_turns(motion, robot)
    if start is None:
        start = {name: at for name, at in motion.start.joints.items() if name in motion.joints}
    notes += check_start(motion, robot, start)
    held = held_in_metres(robot, scene.arm.gripper, METRES[scene.unit])
    held = {name: at for name, at in held.items() if name not in motion.joints}
    metres = METRES[scene.unit]
    x, y, z = scene.arm.base
    place = x * metres, y * metres, z * metres
    try:
        chain = Chain.moved_by(robot, motion.joints, place, scene.arm.base_wxyz, held)
        require_followed(robot, chain.names, held)
    except SceneError as error:
        raise AbiError(error.message) from None
    notes += [*check_followers(given, motion, chain), *check_state(motion, chain, scene)]
    notes += [*_standing(chain), *unused_state(motion, robot)]
    if scene.obstacles:
        notes.append(f"The robot stands at ({x:g}, {y:g}, {z:g}) {scene.unit}.")
    return RobotMotion(motion, chain, read_only(bezier_points(motion)), (*motion.notes, *notes))


def bezier_points(motion: Motion) -> FloatArray:
    """Bézier points (m - 1, degree + 1, n) of the polynomials between waypoints.

    They have the positions, velocities and accelerations at both ends (Hermite interpolation).
    """
    p, spans = motion.positions, np.diff(motion.times)[:, None]
    a, b = p[:-1], p[1:]
    if motion.velocities is None:
        return np.stack([a, b], axis=1)
    u, v = motion.velocities[:-1] * spans, motion.velocities[1:] * spans
    if motion.accelerations is None:
        return np.stack([a, a + u / 3, b - v / 3, b], axis=1)
    f, g = (one * spans**2 for one in (motion.accelerations[:-1], motion.accelerations[1:]))
    inner = a + u / 5, a + 2 * u / 5 + f / 20, b - 2 * v / 5 + g / 20, b - v / 5
    return np.stack([a, *inner, b], axis=1)


def _matched(motion: Motion, robot: Robot, tip: str) -> tuple[Motion, list[str]]:
    """The motion of the robot's own coordinates, from the root on, and what was left out."""
    by_name = {joint.name: joint for joint in robot.joints if joint.kind != "fixed"}
    free = [name for name, joint in by_name.items() if joint.follows is None]
    for name in motion.joints:
        if name not in by_name:
            like = difflib.get_close_matches(name, free, 1)
            hint = f"Did you mean {like[0]}?" if like else f"It has {some_of(free, 8)}."
            raise AbiError(f"The robot has no joint {name} that moves.", hint)
    notes = [
        f"{name} follows {by_name[name].coordinate}, so its own column is not used."
        for name in motion.joints
        if name not in free
    ]
    kept = [name for name in free if name in motion.joints]
    if missing := _missing(robot, tip, kept):
        hint = " ".join(("Give its positions, too.", *motion.notes))  # what was left out, too
        raise AbiError(f"The motion does not say where {missing} is.", hint)
    columns = [motion.joints.index(name) for name in kept]
    rates = [
        None if table is None else table[:, columns]
        for table in (motion.velocities, motion.accelerations)
    ]
    positions = motion.positions[:, columns]
    kept_motion = replace(
        motion,
        joints=tuple(kept),
        positions=positions,
        velocities=rates[0],
        accelerations=rates[1],
    )
    return kept_motion, notes


def _missing(robot: Robot, tip: str, given: Sequence[str]) -> str:
    """First joint on the way to the tip or to one that is given that is not; empty if none.

    What a plan of the arm holds on another branch, on which the tip's way follows a joint by its
    ``<mimic>``, stands still here, too.
    """
    arm = planned_joints(robot, tip)
    wanted = set(arm) if set(arm) & set(given) else set()
    parents = {joint.child: joint for joint in robot.joints}
    by_name = {joint.name: joint for joint in robot.joints}
    for name in {*given}.difference(arm):
        joint: Joint | None = by_name[name]
        while joint is not None:
            if joint.kind != "fixed":
                wanted.add(joint.coordinate)
            joint = parents.get(joint.parent)
    return next((one.name for one in robot.joints if one.name in wanted - set(given)), "")


def _suspect_degrees(motion: Motion, robot: Robot) -> None:
    """Raise where angles are far past their limits and large, and all would fit in degrees.

    What is smaller is judged as it is given, and so are a few turns of a continuous joint.
    """
    joints = {joint.name: joint for joint in robot.joints}
    turning = [k for k, name in enumerate(motion.joints) if joints[name].kind != "prismatic"]
    if not turning:
        return
    named = [joints[motion.joints[k]] for k in turning]
    limits = np.array([(joint.low, joint.high) for joint in named])
    most = np.array([_TURNS if joint.kind == "continuous" else _TURN for joint in named])
    angles = motion.positions[:, turning]
    past = np.maximum(limits[:, 0] - angles, angles - limits[:, 1])
    past = np.where(np.abs(angles) > most, past, 0.0)
    row, k = np.unravel_index(int(past.argmax()), past.shape)
    fits = np.radians(angles)
    if past[row, k] > _PAST and ((fits >= limits[:, 0]) & (fits <= limits[:, 1])).all():
        name, angle = motion.joints[turning[k]], float(angles[row, k])
        limit = float(limits[k, 1] if angle > limits[k, 1] else limits[k, 0])
        raise AbiError(
            f"In row {row + 1} {name} is at {angle:g} rad, past its limit of {limit:.4g} rad; all "
            "rows would fit in degrees.",
            f"Convert them to radians, or name the unit in a CSV's header: {name} [deg].",
        )


def _long_turns(motion: Motion, robot: Robot) -> list[str]:
    """Sentences on continuous joints that turn by more than half a turn between two waypoints."""
    found, kinds = [], {joint.name: joint.kind for joint in robot.joints}
    for name, column in zip(motion.joints, motion.positions.T, strict=True):
        turns = np.abs(np.diff(column))
        if kinds[name] == "continuous" and turns.max() > math.pi:
            row = int(turns.argmax()) + 1
            found.append(
                f"Between rows {row} and {row + 1} {name} turns by {turns[row - 1]:.4g} rad, as "
                "its numbers say; a controller that takes the shorter turn moves otherwise."
            )
    return found


def _standing(chain: Chain) -> list[str]:
    """A sentence on the joints that the motion does not move; none if there are none."""
    slides = {joint.name: "m" for joint in chain.robot.joints if joint.kind == "prismatic"}
    own = {joint.name for joint in chain.robot.joints if joint.follows is None}
    still = [
        f"{name} at {at:.4g} {slides.get(name, 'rad')}"
        for name, at in chain.held.items()
        if name in own
    ]
    return (
        [f"Joints that the motion does not name stand still: {some_of(still, 8)}."] if still else []
    )
