"""A chain of a robot's joints, from its base to the tip that is the tool, and what it carries.

Every link is posed from the full state of the joints: one beside the chain that follows one of the
chain, directly or not, moves with it; all others are held.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, ShortRepr, flat, read_only
from abi.obstacles.pose import UNTURNED, Quaternion, Vec3, rotation
from abi.robot.kinematics.chain_kernels import POSE, ChainTable, chain_poses
from abi.robot.kinematics.chain_table import checked_table
from abi.robot.kinematics.follow_path_kernels import follow_path
from abi.robot.urdf.held_joints import NOT_HELD, planned_joints, positions_held
from abi.robot.urdf.joint import Joint
from abi.robot.urdf.robot import Robot, joints_to

_MOST_ITERATIONS = 40
_PART = 250
"""Points of a path that are followed in one call, at most 20 ms."""


@dataclass(frozen=True, eq=False, repr=False)
class Chain(ShortRepr):
    """Joints between a base and a tip, standing in the world; lengths in [m].

    Attributes:
        robot: the robot that it belongs to.
        joints: the m joints that move: those between base and tip, from the base on, then those
            beside them that follow one of the n coordinates, parents before children.
        names: names of the n coordinates.
        table: the chain in the format of the kernels.
        limits: lowest and highest of each coordinate, shape (n, 2).
        speeds: largest of each, (n,), [1/s]; inf where none is known.
        efforts: largest torque or force of each, (n,); inf where none is known.
        slides: which coordinates are lengths, (n,).
        frames: number of the joint that moves each link of the robot, -1 where it stands still, by
            the link's name, parents before children.
        places: pose of each link in that frame, in the world where it stands still, (4, 4), [m].
        held: positions of the joints that can move but stand still, [rad] or [m].
    """

    robot: Robot
    joints: tuple[Joint, ...]
    names: tuple[str, ...]
    table: ChainTable
    limits: FloatArray
    speeds: FloatArray
    efforts: FloatArray
    slides: tuple[bool, ...]
    frames: Mapping[str, int]
    places: Mapping[str, FloatArray]
    held: Mapping[str, float]

    def __post_init__(self) -> None:
        """Check what kernels read.

        Raises:
            ArgumentError: an array has another shape or type, or makes no sense.
        """
        count, moving = len(self.names), len(self.joints)
        for link, frame in self.frames.items():
            arguments.integer(f"frame of {link}", frame, -1, moving - 1)
        checked = {link: arguments.pose("places", self.places[link]) for link in self.frames}
        places = {link: arguments.owned(pose) for link, pose in checked.items()}
        arguments.flags("slides", self.slides, (count,))
        rates = {
            name: arguments.within(name, values, (count,), 0.0, math.inf, infinite=True)
            for name, values in (("speeds", self.speeds), ("efforts", self.efforts))
        }
        arguments.keep(
            self,
            table=checked_table(self.table, moving, count),
            limits=arguments.ranges("limits", self.limits, count),
            places=places,
            **rates,
        )

    @classmethod
    def of(
        cls,
        robot: Robot,
        tip: str,
        position: Vec3 = (0.0, 0.0, 0.0),
        axis: Vec3 | None = None,
        wxyz: Quaternion = UNTURNED,
        held: Mapping[str, float] = NOT_HELD,
    ) -> Self:
        """The chain from the robot's root to a tip.

        Args:
            robot: the robot.
            tip: name of the link whose origin is the tool.
            position: of the root, world, [m].
            axis: direction that the tip's z axis is held to, world; None for any.
            wxyz: how the root is turned, as a quaternion.
            held: positions of joints beside the chain, by name, [rad] or [m]; the others rest
                nearest to 0.

        Raises:
            SceneError: there is no such tip, no joint moves it, or a joint cannot be held there.
        """
        way = tuple(joint for joint in joints_to(robot, tip) if joint.kind != "fixed")
        names = planned_joints(robot, tip)
        beside = (one for one in robot.joints if one.kind != "fixed" and one not in way)
        joints = (*way, *(joint for joint in beside if joint.coordinate in names))
        still = positions_held(robot, names, held)
        frames, places = _links(robot, joints, still, _pose(position, wxyz))
        last = places[tip]
        origins = [*_origins(way, places), last]
        reach = sum(float(np.linalg.norm(pose[:3, 3])) for pose in origins[1:])
        reach += strokes(robot, way)
        return cls._of_links(
            *(robot, joints, names, still, (frames, places), reach),
            length=len(way),
            tip=last,
            axis=axis,
        )

    @classmethod
    def moved_by(
        cls,
        robot: Robot,
        names: tuple[str, ...],
        position: Vec3 = (0.0, 0.0, 0.0),
        wxyz: Quaternion = UNTURNED,
        held: Mapping[str, float] = NOT_HELD,
    ) -> Self:
        """All joints of a robot that are moved by some of them, as of two arms; it has no tool.

        Args:
            robot: the robot.
            names: joints that move by themselves, in the order of the coordinates.
            position: of the root, world, [m].
            wxyz: how the root is turned, as a quaternion.
            held: positions of other joints by name, [rad] or [m]; the others rest nearest to 0.

        Raises:
            SceneError: a joint cannot be held there.
        """
        joints = tuple(
            one for one in robot.joints if one.kind != "fixed" and one.coordinate in names
        )
        still = positions_held(robot, names, held)
        links = _links(robot, joints, still, _pose(position, wxyz))
        reach = sum(float(np.linalg.norm(pose[:3, 3])) for pose in _origins(joints, links[1]))
        reach += strokes(robot, joints)
        return cls._of_links(
            *(robot, joints, names, still, links, reach),
            length=len(joints),
            tip=np.eye(4),
            axis=None,
        )

    @classmethod
    def _of_links(
        cls,
        robot: Robot,
        joints: tuple[Joint, ...],
        names: tuple[str, ...],
        still: Mapping[str, float],
        links: tuple[Mapping[str, int], Mapping[str, FloatArray]],
        reach: float,
        *,
        length: int,
        tip: FloatArray,
        axis: Vec3 | None,
    ) -> Self:
        """The chain of joints that move links.

        Args:
            robot: the robot.
            joints: those that move; those between base and tip come first.
            names: of the coordinates.
            still: positions of the joints that stand still, [rad] or [m].
            links: the joint that moves each link, and the link's pose in the frame of that.
            reach: length that errors of place are compared with, [m].
            length: number of joints between base and tip.
            tip: its pose behind the last of these, (4, 4), [m].
            axis: direction that its z axis is held to, world; None for any.
        """
        (frames, places), by_name = links, {joint.name: joint for joint in robot.joints}
        moving = [by_name[name] for name in names]
        limits = np.array([(joint.low, joint.high) for joint in moving])
        direction = np.array(axis or (0.0, 0.0, 1.0))
        before = [frames[joint.parent] for joint in joints]
        table = ChainTable(
            length=length,
            before=read_only(np.array(before, dtype=np.int32)),
            origins=flat(np.stack([_packed(pose) for pose in [*_origins(joints, places), tip]])),
            axes=flat(np.stack([joint.axis for joint in joints])),
            slides=read_only(np.array([joint.kind == "prismatic" for joint in joints])),
            source=read_only(
                np.array([names.index(joint.coordinate) for joint in joints], dtype=np.int32)
            ),
            factor=read_only(np.array([joint.factor for joint in joints])),
            offset=read_only(np.array([joint.offset for joint in joints])),
            limits=flat(limits),
            direction=read_only(direction / np.linalg.norm(direction)),
            aims=axis is not None,
            reach=max(reach, 1e-6),
        )
        return cls(
            robot=robot,
            joints=joints,
            names=names,
            table=table,
            limits=read_only(limits),
            speeds=read_only(np.array([joint.speed for joint in moving])),
            efforts=read_only(np.array([joint.effort for joint in moving])),
            slides=tuple(joint.kind == "prismatic" for joint in moving),
            frames=frames,
            places=places,
            held=still,
        )

    def behind(self, frame: int) -> tuple[int, ...]:
        """Numbers of the joints that move a frame, the last one first; none for -1."""
        found = []
        while frame >= 0:
            found.append(frame)
            frame = int(self.table.before[frame])
        return tuple(found)

    def usual_range(self) -> FloatArray:
        """Positions that random poses are drawn from, (n, 2): of a turning joint one turn.

        That is the turn within its limits that is nearest to the one about 0. It is all of its
        limits where these do not contain 0, or where what follows the joint is not as before after
        a turn: a joint that slides, or turns by no whole number of turns.
        """
        low, high = self.limits.T
        begin = np.maximum(low, np.minimum(-np.pi, high - 2 * np.pi))
        turn = np.stack([begin, np.minimum(high, begin + 2 * np.pi)], axis=1)
        recurs = np.full(len(self.names), True)
        again = ~self.table.slides & (self.table.factor % 1 == 0)
        recurs[self.table.source[~again]] = False
        return np.where((recurs & (low <= 0) & (high >= 0))[:, None], turn, self.limits)

    def poses(self, positions: FloatArray) -> FloatArray:
        """World from frame behind each joint and of the tip.

        Args:
            positions: coordinates, shape (k, n).

        Returns:
            Shape (k, m + 1, 3, 4), [m].
        """
        return self.unpacked(self.packed_poses(positions))

    def unpacked(self, packed: FloatArray) -> FloatArray:
        """Poses (k, m + 1, 3, 4), [m], in the format of the kernels (12 (m + 1) k,)."""
        packed = packed.reshape(-1, len(self.joints) + 1, POSE)
        turns = packed[..., :9].reshape(*packed.shape[:2], 3, 3)
        return np.concatenate([turns, packed[..., 9:, None]], axis=-1)

    def packed_poses(self, positions: FloatArray) -> FloatArray:
        """Poses of all frames in the format of the kernels, flat (12 (m + 1) k,), [m]."""
        positions = arguments.numbers("positions", positions, (-1, len(self.names)))
        found = np.empty(len(positions) * POSE * (len(self.joints) + 1))
        chain_poses(self.table, flat(positions), len(self.names), found)
        return found

    def follow(
        self,
        start: FloatArray,
        targets: FloatArray,
        home: FloatArray | None = None,
        still: int | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """Move the tip along points, solving for each from the one before.

        Args:
            start: coordinates to begin with, (n,), within the limits.
            home: coordinates that redundant joints drift to, (n,); ``start`` by default.
            targets: points in the order they are passed, shape (k, 3), [m], world.
            still: number of a coordinate that stays where it is; None for none.

        Returns:
            Coordinates (k, n), within the limits, and the error at each point, (k,): its distance
            divided by the reach, or the angle [rad] by which the tip's direction is off if larger.
        """
        count = len(self.names)
        start = arguments.numbers("start", start, (count,))
        home = start if home is None else arguments.numbers("home", home, (count,))
        targets = arguments.points("targets", targets)
        joints, errors = np.empty(len(targets) * count), np.empty(len(targets))
        table = self.table
        if still is not None:
            limits = table.limits.reshape(-1, 2).copy()
            limits[arguments.integer("still", still, 0, count - 1)] = start[still]
            table = table._replace(limits=flat(limits))
        along = table, flat(start), flat(home), flat(targets)
        for first in range(0, len(targets), _PART):  # a result may become unwanted between two
            part = first, min(first + _PART, len(targets))
            follow_path(*along, part, _MOST_ITERATIONS, joints, errors)
        return joints.reshape(-1, count), errors


def _pose(position: Vec3, wxyz: Quaternion) -> FloatArray:
    """Pose (4, 4) of a position and a rotation."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation(wxyz), position
    return pose


def _links(
    robot: Robot, joints: tuple[Joint, ...], still: Mapping[str, float], base: FloatArray
) -> tuple[dict[str, int], dict[str, FloatArray]]:
    """The joint that moves each link of a robot, -1 for none, and the link's pose in its frame.

    Parents come before children.

    Args:
        robot: the robot.
        joints: those that move.
        still: positions of the others, but for fixed ones, [rad] or [m].
        base: world from root, (4, 4), [m].
    """
    frames, places = {robot.root: -1}, {robot.root: read_only(base)}
    for joint in robot.joints:
        frame, pose = frames[joint.parent], places[joint.parent] @ joint.origin
        if joint in joints:
            frame, pose = joints.index(joint), np.eye(4)
        elif joint.name in still:
            pose = pose @ joint.motion(still[joint.name])
        frames[joint.child], places[joint.child] = frame, read_only(pose)
    return frames, places


def _origins(joints: Iterable[Joint], places: Mapping[str, FloatArray]) -> list[FloatArray]:
    """Pose of each joint at position 0 in the frame that carries it, (4, 4), [m]."""
    return [places[joint.parent] @ joint.origin for joint in joints]


def _packed(pose: FloatArray) -> FloatArray:
    return np.concatenate([pose[:3, :3].ravel(), pose[:3, 3]])


def strokes(robot: Robot, joints: Iterable[Joint]) -> float:
    """Sum of how far slides among joints are out, or go from end to end if that is more, [m]."""
    ends, length = {one.name: (one.low, one.high) for one in robot.joints}, 0.0
    for joint in joints:
        if joint.kind == "prismatic":
            low, high = map(joint.position, ends[joint.coordinate])
            length += max(abs(high - low), abs(low), abs(high))
    return length
