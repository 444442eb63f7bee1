"""A joint of a robot, which may follow another; lengths in [m], angles in [rad]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple, get_args

import numpy as np
import scipy

from abi import arguments
from abi.arrays import FloatArray, ShortRepr
from abi.errors import ArgumentError

JointKind = Literal["revolute", "continuous", "prismatic", "fixed"]


class Mimic(NamedTuple):
    """A joint that follows another: its position is ``factor`` times the other's + ``offset``."""

    joint: str
    factor: float
    offset: float


@dataclass(frozen=True, eq=False, repr=False)
class Joint(ShortRepr):
    """A joint between two links.

    Attributes:
        name: of the joint.
        kind: how it moves.
        parent, child: names of its links.
        origin: parent link from joint, shape (4, 4).
        axis: unit vector in the joint's frame, shape (3,).
        low, high: limits, [rad] or [m]; those of a continuous joint are ±2π.
        speed: largest at which those that follow it keep their own limits, too, [rad/s] or [m/s];
            inf where the file gives none.
        effort: largest torque or force, [N·m] or [N]; inf where the file gives none.
        mimic: the joint that it follows; None for one that moves by itself.
    """

    name: str
    kind: JointKind
    parent: str
    child: str
    origin: FloatArray
    axis: FloatArray
    low: float
    high: float
    speed: float
    effort: float
    mimic: Mimic | None

    def __post_init__(self) -> None:
        """Check its pose and its numbers.

        Raises:
            ArgumentError: a number makes no sense, or an array has another shape.
        """
        if self.kind not in get_args(JointKind):
            raise ArgumentError("kind", self.kind, f"one of {', '.join(get_args(JointKind))}")
        arguments.ranges("low and high", [[self.low, self.high]], 1)
        arguments.number("speed", self.speed, 0.0, infinite=True)
        arguments.number("effort", self.effort, 0.0, infinite=True)
        if self.mimic is not None:
            arguments.number("mimic.factor", self.mimic.factor)
            arguments.number("mimic.offset", self.mimic.offset)
        arguments.keep(
            self,
            origin=arguments.pose("origin", self.origin),
            axis=arguments.direction("axis", self.axis),
        )

    @property
    def coordinate(self) -> str:
        """Name of the joint whose position moves it: its own, or the one that it follows."""
        return self.name if self.mimic is None else self.mimic.joint

    def motion(self, position: float) -> FloatArray:
        """Pose of its child beside that at position 0, (4, 4), [m].

        Args:
            position: of the joint, [rad] or [m].
        """
        pose = np.eye(4)
        if self.kind == "prismatic":
            pose[:3, 3] = self.axis * position
        elif self.kind != "fixed":
            turn = scipy.spatial.transform.Rotation.from_rotvec(position * self.axis)
            pose[:3, :3] = turn.as_matrix()
        return pose
