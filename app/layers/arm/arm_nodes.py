"""Scene nodes of an arm: a node for each joint in that of the joint before it, and the links."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, TypeVar

import numpy as np
import viser
import viser.transforms

from abi.arrays import FloatArray
from abi.robot.any_arm import AnyArm
from abi.scene.scene import Scene
from app.ui import node_poses

A = TypeVar("A", bound=AnyArm)


@dataclass(frozen=True, eq=False)
class JointNode:
    """Scene node of a joint: its place in the parent link, and its axis.

    Attributes:
        frame: the node.
        column: of the joint's position among all.
        prismatic: whether it slides along the axis instead of turning about it.
        axis: (3,), in the joint's frame.
        origin: the joint's frame in the parent link's.
    """

    frame: viser.FrameHandle
    column: int
    prismatic: bool
    axis: FloatArray
    origin: viser.transforms.SE3

    @cached_property
    def played(self) -> dict[str, object]:
        """The joint as the page moves it; there the time is the first column."""
        rotation = self.origin.rotation()
        return {
            "name": self.frame.name,
            "column": self.column + 1,
            "wxyz": rotation.wxyz.tolist(),
            "position": self.origin.translation().tolist(),
            # to slide along in the parent node, or to turn about in its own
            "axis": (rotation @ self.axis if self.prismatic else self.axis).tolist(),
            "prismatic": self.prismatic,
        }

    def forget_pose(self) -> None:
        """Have the next move sent, as the page has moved the node by itself."""
        node_poses.forget(self.frame)

    def move(self, positions: FloatArray) -> None:
        """Pose the node at the positions (m,) of all joints, [rad] and [unit]."""
        value = float(positions[self.column])
        place, rotation = self.origin.translation(), self.origin.rotation()
        if self.prismatic:
            place = self.origin @ (self.axis * value)
        else:
            rotation = rotation @ viser.transforms.SO3.exp(self.axis * value)
        self.frame.position, self.frame.wxyz = place, rotation.wxyz


class LinkBody:
    """A link as it looks, and in red once it has touched something."""

    def __init__(self, scene: viser.SceneApi, name: str, glb: bytes, red: bytes) -> None:
        self._scene, self._name = scene, name
        self._own = scene.add_glb(f"{name}/mesh", glb)
        self._red_glb = red
        self._red: viser.GlbHandle | None = None

    def redden(self, on: bool) -> None:
        """Draw it in red, or in its own colours."""
        if on and self._red is None:
            self._red = self._scene.add_glb(f"{self._name}/red", self._red_glb)
        if self._red is not None:
            self._red.visible = on
        self._own.visible = not on


class ArmNodes(ABC, Generic[A]):
    """Nodes of one kind of arm; one place of the scene is for each kind.

    Attributes:
        root: node that all others are in, and that is seen where the arm is.
        joint_nodes: parents before their children; another list for another arm.
    """

    def __init__(self, scene: viser.SceneApi, name: str, base: str) -> None:
        """Begin without an arm; ``name`` and ``base`` of the root and the base's node in it."""
        self._scene, self._base_name = scene, f"{name}/{base}"
        self.root = scene.add_frame(name, show_axes=False)
        self.joint_nodes: list[JointNode] = []
        self._base: viser.FrameHandle | None = None
        self._bodies: list[tuple[str, LinkBody]] = []
        self._look: object = None
        self._touching: frozenset[str] = frozenset()

    def place(self, arm: A) -> None:
        """Put an arm on its base; build its nodes anew where it looks otherwise."""
        if (look := self._look_of(arm)) != self._look or self._base is None:
            if self._base is not None:
                self._base.remove()
            self._base = self._scene.add_frame(self._base_name, show_axes=False)
            self._look, self._touching = look, frozenset()
            self.joint_nodes, self._bodies = [], []
            self._build(arm)
        self._base.position, self._base.wxyz = arm.base, np.array(arm.wxyz)

    def redden(self, links: frozenset[str]) -> bool:
        """Draw links in red, and the others in their own colours; whether that is new."""
        if links == self._touching:
            return False
        self._touching = links
        for link, body in self._bodies:
            body.redden(link in links)
        return True

    @abstractmethod
    def rest_pose(self, arm: A, scene: Scene) -> FloatArray:
        """Positions (n,) in which an arm stands that has no motion, [rad] and [unit]."""

    @abstractmethod
    def values(self, positions: FloatArray) -> FloatArray:
        """Positions (k, m) of the joints that have nodes, of those (k, n) of a motion."""

    @abstractmethod
    def _look_of(self, arm: A) -> object:
        """Values that the nodes depend on."""

    @abstractmethod
    def _build(self, arm: A) -> None:
        """Add the joints and bodies of an arm to the base's node."""

    def _add_joint(
        self,
        name: str,
        origin: viser.transforms.SE3,
        axis: FloatArray,
        column: int,
        prismatic: bool,
    ) -> None:
        """Add a joint's node; arguments as for :class:`JointNode`."""
        frame = self._scene.add_frame(
            name,
            show_axes=False,
            wxyz=origin.rotation().wxyz,
            position=origin.translation(),
        )
        self.joint_nodes.append(JointNode(frame, column, prismatic, axis, origin))

    def _add_body(self, link: str, name: str, glbs: tuple[bytes, bytes]) -> None:
        """Add a body made by :func:`app.layers.arm.link_body.link_glbs` to the node of a name."""
        self._bodies.append((link, LinkBody(self._scene, name, *glbs)))
