"""Scene nodes of an arm, one a joint and each in that of the joint before it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import viser
import viser.transforms

from abi.arm.any_arm import AnyArm
from abi.arrays import FloatArray
from abi.planner.plan import Plan
from app.layers.arm_playback import JointPose


@dataclass
class JointNode:
    """Scene node of a joint: its place in the parent link, and its axis.

    Attributes:
        frame: the node.
        column: of the joint's position among all; None where it is fixed.
        prismatic: whether it slides along the axis instead of turning about it.
        axis: (3,), in the joint's frame.
        origin: the joint's frame in the parent link's.
    """

    frame: viser.FrameHandle
    column: int | None
    prismatic: bool
    axis: FloatArray
    origin: viser.transforms.SE3

    @property
    def pose(self) -> JointPose | None:
        """Motion of the node with its joint; None where it is fixed."""
        if self.column is None:
            return None
        rotation = self.origin.rotation()
        return JointPose(
            name=self.frame.name,
            column=self.column,
            wxyz=np.asarray(rotation.wxyz, float),
            position=np.asarray(self.origin.translation(), float),
            axis=np.asarray(rotation @ self.axis if self.prismatic else self.axis, float),
            prismatic=self.prismatic,
        )

    def move(self, positions: FloatArray) -> None:
        """Pose the node at the positions (m,) of all joints, [rad] and [unit]."""
        if self.column is None:
            return
        value = float(positions[self.column])
        if self.prismatic:
            self.frame.position = self.origin @ (self.axis * value)
        else:
            rotation = viser.transforms.SO3.exp(self.axis * value)
            self.frame.wxyz = (self.origin.rotation() @ rotation).wxyz


class ArmNodes(Protocol):
    """Nodes of one kind of arm; one place of the scene is for each kind."""

    @property
    def root(self) -> viser.FrameHandle:
        """Node that all others are in, and that is seen where the arm is."""

    @property
    def joint_nodes(self) -> list[JointNode]:
        """One for each joint, parents before their children; another list for another arm."""

    def place(self, arm: AnyArm) -> None:
        """Put an arm on its base; build its nodes anew where it looks otherwise."""

    def rest_pose(self, plan: Plan) -> FloatArray:
        """Positions (n,) in which the arm of a plan without a motion stands, [rad] and [unit]."""

    def values(self, positions: FloatArray) -> FloatArray:
        """Positions (k, m) of the joints that have nodes, of those (k, n) of a motion."""

    def redden(self, links: frozenset[str]) -> None:
        """Draw links in red, and the others in their own colours."""
