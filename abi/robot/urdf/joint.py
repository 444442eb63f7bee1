"""A joint of a robot, which may follow another; lengths in [m], angles in [rad]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import scipy

from abi import arguments
from abi.arrays import FloatArray, ShortRepr
from abi.errors import ArgumentError

JointKind = Literal["revolute", "continuous", "prismatic", "fixed"]


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
        follows: name of the joint that it follows; None for one that moves by itself.
        factor, offset: its position is ``factor`` times that of the joint that it follows, and
            ``offset``, [rad] or [m]; 1 and 0 where it moves by itself.
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
    follows: str | None = None
    factor: float = 1.0
    offset: float = 0.0

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
        arguments.number("factor", self.factor)
        arguments.number("offset", self.offset)
        arguments.keep(
            self,
            origin=arguments.pose("origin", self.origin),
            axis=arguments.direction("axis", self.axis),
        )

    @property
    def coordinate(self) -> str:
        """Name of the joint whose position moves it: its own, or the one that it follows."""
        return self.name if self.follows is None else self.follows

    def position(self, coordinate: float) -> float:
        """Its position where the joint that moves it is at ``coordinate``, [rad] or [m]."""
        return self.factor * coordinate + self.offset

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
