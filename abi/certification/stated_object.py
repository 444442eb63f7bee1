"""Objects that a robot holds by the file of its motion, compared with the one of a scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy

from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import Obstacle
from abi.obstacles.pose import Quaternion, Vec3
from abi.obstacles.primitives import Box, Cylinder, Sphere
from abi.robot.urdf.robot import Robot

_SIDES = 300
"""Places around two objects from which their distances are compared."""
_AWAY = 3.0
"""Distance of these places from the middle of an object, over half its size."""


_KINDS = (1, "box"), (2, "sphere"), (3, "cylinder")
"""Numbers of ``shape_msgs/msg/SolidPrimitive``."""
_TURN = 1e-100, 1e100
"""Least and largest entry of a quaternion, whose square has to be a number."""
_LARGEST = 10**300
_SIZES = 1e-9, 1e6
"""Least and largest size of an object, [m]."""


def is_turn(quaternion: Sequence[float]) -> bool:
    """Whether a quaternion of finite numbers can be one of length 1."""
    low, high = _TURN
    return low <= max(map(abs, quaternion)) <= high


class StatedObject(NamedTuple):
    """An object that a robot holds by a message.

    Attributes:
        name: of the object.
        link: that holds it.
        solid: the kind of its only solid, the sizes of this, and its place in the link's frame as
            position and quaternion x, y, z, w, [m]; None where the message has another shape.
    """

    name: str
    link: str
    solid: tuple[str, tuple[float, ...], tuple[float, ...]] | None

    @classmethod
    def of(cls, message: object) -> StatedObject:
        """Read a ``moveit_msgs/msg/AttachedCollisionObject``."""
        outer = message if isinstance(message, dict) else {}
        inner = outer.get("object")
        part: Mapping[str, Any] = inner if isinstance(inner, dict) else {}
        link = str(outer.get("link_name", ""))
        return cls(str(part.get("id", "")), link, _solid(part, link))

    def distance(self, held: Obstacle, metres: float, robot: Robot, tip: str) -> float | None:
        """How far its surface is from that of another object at most, [m]; None if not known.

        Args:
            held: the object that a scene has, in the frame of its tip.
            metres: one [unit] of the scene in metres.
            robot: the robot.
            tip: the link that holds the scene's.
        """
        if self.solid is None or {self.link, tip} - robot.links.keys():
            return None
        (root, there), (other, here) = _rigid(robot, self.link), _rigid(robot, tip)
        if root != other:
            return None
        kind, sizes, place = self.solid
        pose = np.linalg.inv(here) @ there @ _matrix(place)
        x, y, z, w = scipy.spatial.transform.Rotation.from_matrix(pose[:3, :3]).as_quat().tolist()
        px, py, pz = pose[:3, 3].tolist()
        stated = _shape(kind, sizes, (px, py, pz), (w, x, y, z))
        low, high = held.bounds()
        middle, half = metres * (low + high) / 2, metres * float(np.linalg.norm(high - low)) / 2
        turn = np.arange(_SIDES) * np.pi * (3 - 5**0.5)
        level = 1 - (2 * np.arange(_SIDES) + 1) / _SIDES
        round_ = np.sqrt(1 - level**2)
        sides = np.stack([round_ * np.cos(turn), round_ * np.sin(turn), level], axis=1)
        around = middle + _AWAY * half * sides
        own, others = stated.signed_distance(around), held.signed_distance(around / metres)
        return float(np.abs(own - metres * others).max())


def _solid(
    part: Mapping[str, Any], link: str
) -> tuple[str, tuple[float, ...], tuple[float, ...]] | None:
    """The only solid of a ``moveit_msgs/msg/CollisionObject``, if that is a box, ball or rod."""
    solids, places = part.get("primitives") or [], part.get("primitive_poses") or []
    header = part.get("header")
    frame = header.get("frame_id") if isinstance(header, dict) else None
    others = any(part.get(name) for name in ("meshes", "planes"))
    if others or frame not in (None, "", link) or not isinstance(solids, list):
        return None
    if len(solids) != 1 or not isinstance(solids[0], dict) or not isinstance(places, list):
        return None
    kind = next((name for number, name in _KINDS if solids[0].get("type") == number), None)
    sizes = _numbers(solids[0].get("dimensions"))
    outer, inner = (_place(one) for one in (part.get("pose"), *(places[:1] or [None])))
    if kind is None or outer is None or inner is None or not sizes:
        return None
    if not _SIZES[0] <= min(sizes) <= max(sizes) <= _SIZES[1]:
        return None
    if len(sizes) != {"box": 3, "sphere": 1, "cylinder": 2}[kind]:
        return None
    pose = _matrix(outer) @ _matrix(inner)
    turned = scipy.spatial.transform.Rotation.from_matrix(pose[:3, :3]).as_quat().tolist()
    return kind, sizes, (*pose[:3, 3].tolist(), *turned)


def _place(pose: object) -> tuple[float, ...] | None:
    """Numbers of a ``geometry_msgs/msg/Pose``; one that is not given is at the origin."""
    if pose is None:
        return (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    if not isinstance(pose, dict):
        return None
    position, turned = pose.get("position") or {}, pose.get("orientation") or {}
    if not isinstance(position, dict) or not isinstance(turned, dict):
        return None
    at = _numbers([position.get(axis, 0.0) for axis in "xyz"])
    turn = _numbers([turned.get(axis, 0.0) for axis in "xyzw"])
    if at is None or turn is None:
        return None
    turn = turn if any(turn) else (0.0, 0.0, 0.0, 1.0)
    is_near = max(map(abs, at)) <= _SIZES[1]
    return (*at, *turn) if is_near and is_turn(turn) else None


def _numbers(values: object) -> tuple[float, ...] | None:
    """Finite numbers of a list; None for anything else."""
    if not isinstance(values, Sequence) or isinstance(values, str):
        return None
    numbers = [one for one in values if type(one) in (int, float) and abs(one) <= _LARGEST]
    return tuple(map(float, numbers)) if len(numbers) == len(values) else None


def _shape(kind: str, sizes: tuple[float, ...], position: Vec3, wxyz: Quaternion) -> Obstacle:
    if kind == "box":
        width, depth, height = sizes
        return Box(size=(width, depth, height), position=position, wxyz=wxyz)
    if kind == "sphere":
        return Sphere(radius=sizes[0], position=position, wxyz=wxyz)
    return Cylinder(height=sizes[0], radius=sizes[1], position=position, wxyz=wxyz)


def _matrix(place: tuple[float, ...]) -> FloatArray:
    """Pose (4, 4) of a position and a quaternion x, y, z, w."""
    pose = np.eye(4)
    pose[:3, :3] = scipy.spatial.transform.Rotation.from_quat(place[3:]).as_matrix()
    pose[:3, 3] = place[:3]
    return pose


def _rigid(robot: Robot, link: str) -> tuple[str, FloatArray]:
    """The first link that a link is fixed to, and the pose of the one in that, (4, 4), [m]."""
    parents, pose = {joint.child: joint for joint in robot.joints}, np.eye(4)
    while link in parents and parents[link].kind == "fixed":
        pose, link = parents[link].origin @ pose, parents[link].parent
    return link, pose
