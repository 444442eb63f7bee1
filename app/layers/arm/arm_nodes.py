"""Scene nodes of an arm: a node for each joint in that of the joint before it, and the links.

What differs from one kind of arm to another is in the kind's module.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
import viser
import viser.transforms

from abi.arm_planning.branch.followed import Followed
from abi.arrays import FloatArray
from abi.planner.plan import Plan
from abi.robot.any_arm import AnyArm
from abi.scene.scene import Scene
from app.ui import node_poses


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

    def move(self, positions: FloatArray) -> None:
        """Pose the node at the positions (m,) of all joints, [rad] and [unit]."""
        value = float(positions[self.column])
        place, rotation = self.origin.translation(), self.origin.rotation()
        if self.prismatic:
            place = self.origin @ (self.axis * value)
        else:
            rotation = rotation @ viser.transforms.SO3.exp(self.axis * value)
        self.frame.position, self.frame.wxyz = place, rotation.wxyz


class ArmKind(Protocol):
    """What is drawn of a kind of arm: its nodes, other poses and regions. A module is one."""

    @property
    def NODES(self) -> tuple[str, str]:
        """Name of the node that all others are in, and of the base's in it."""

    @property
    def SLOW_REGIONS(self) -> bool:
        """Whether its regions take longer than a frame where the start is another."""

    def bodies(self, arm: Any) -> object:
        """Make the bodies of its links, which all tabs share."""

    def look(self, arm: Any) -> object:
        """Values that the nodes of an arm depend on, but for where its base stands."""

    def build(self, nodes: ArmNodes, arm: Any, base: str) -> None:
        """Add joints and bodies of an arm to ``nodes``, below the base's node of that name."""

    def rest_pose(self, arm: Any, scene: Scene) -> FloatArray:
        """Positions (n,) in which an arm stands that has no motion, [rad] and [unit]."""

    def joint_values(self, arm: Any, positions: FloatArray) -> FloatArray:
        """Positions (k, m) of the joints that have nodes, of those (k, n) of a motion."""

    def end_pose(self, plan: Plan, arm: Any, end: str) -> FloatArray | None:
        """Pose (n,) with the tool at the ``start`` or ``goal``; None where that is out of reach."""

    def other_poses(self, plan: Plan, arm: Any, time: float) -> FloatArray:
        """Other poses (k, n) that put the tool where it is at a time [s]."""

    def other_joint_paths(self, plan: Plan, arm: Any) -> tuple[Followed, ...]:
        """Joint paths of the other poses, at the page's samples of the motion."""

    def region_start(self, plan: Plan, arm: Any) -> object:
        """What its regions depend on beside its settings; None where it has none."""

    def region(self, name: str, plan: Plan, arm: Any) -> FloatArray:
        """Triangles (n, 3, 3) of its ``shadow`` or ``reach``, [unit], world."""


class ArmNodes:
    """Nodes of one kind of arm; one place of the scene is for each kind.

    Attributes:
        root: node that all others are in, and that is seen where the arm is.
        joint_nodes: parents before their children; another list for another arm.
    """

    def __init__(self, scene: viser.SceneApi, kind: ArmKind) -> None:
        """Begin without an arm."""
        self._scene, self._kind = scene, kind
        name, base = kind.NODES
        self._base_name = f"{name}/{base}"
        self.root = scene.add_frame(name, show_axes=False)
        self.joint_nodes: list[JointNode] = []
        self._arm: AnyArm | None = None
        self._base: viser.FrameHandle | None = None
        self._bodies: dict[str, viser.GlbHandle] = {}
        self._red: dict[str, viser.GlbHandle] = {}
        self._red_glbs: dict[str, bytes] = {}
        self._look: object = None
        self._touching: frozenset[str] = frozenset()

    def place(self, arm: AnyArm) -> None:
        """Put an arm on its base; build its nodes anew where it looks otherwise."""
        self._arm = arm
        if (look := self._kind.look(arm)) != self._look or self._base is None:
            if self._base is not None:
                self._base.remove()
            self._base = self._scene.add_frame(self._base_name, show_axes=False)
            self._look, self._touching = look, frozenset()
            self.joint_nodes, self._bodies, self._red, self._red_glbs = [], {}, {}, {}
            self._kind.build(self, arm, self._base_name)
        self._base.position, self._base.wxyz = arm.base, np.array(arm.wxyz)

    def values(self, positions: FloatArray) -> FloatArray:
        """Positions (k, m) of the joints that have nodes, of those (k, n) of a motion."""
        return self._kind.joint_values(self._arm, positions)

    def move(self, positions: FloatArray) -> None:
        """Pose all joints at positions (n,) of a motion."""
        values = self.values(positions[None])[0]
        for node in self.joint_nodes:
            node.move(values)

    def rest(self, scene: Scene) -> None:
        """Pose all joints as without a motion."""
        self.move(self._kind.rest_pose(self._arm, scene))

    def forget_poses(self) -> None:
        """Have the next move of every joint sent, as the page has moved them by itself."""
        for node in self.joint_nodes:
            node_poses.forget(node.frame)

    def redden(self, links: frozenset[str]) -> bool:
        """Draw links in red, and the others in their own colours; whether that is new."""
        if links == self._touching:
            return False
        self._touching = links
        for link in links & self._red_glbs.keys():
            name = self._bodies[link].name.removesuffix("mesh")
            self._red[link] = self._scene.add_glb(f"{name}red", self._red_glbs.pop(link))
        for link, body in self._bodies.items():
            body.visible = link not in links
        for link, body in self._red.items():
            body.visible = link in links
        return True

    def add_joint(
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

    def add_body(self, link: str, name: str, glbs: tuple[bytes, bytes]) -> None:
        """Add a link's body, by :func:`app.layers.arm.link_body.link_glbs`, to the node of a name.

        In red it is not sent before it touches something.
        """
        own, self._red_glbs[link] = glbs
        self._bodies[link] = self._scene.add_glb(f"{name}/mesh", own)

    def add_frame(self, name: str, height: float) -> None:
        """Add a node without a body, at a height along the z axis of the one that it is in."""
        self._scene.add_frame(name, show_axes=False, position=(0.0, 0.0, height))
