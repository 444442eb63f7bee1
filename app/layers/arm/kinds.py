"""Table of the kinds of arms: what each looks like, and its other poses and regions.

A new kind of arm is a module, and a line here.
"""

from __future__ import annotations

from typing import Any, Protocol

import viser

from abi.arm_planning.branch.followed import Followed
from abi.arrays import FloatArray
from abi.planner.plan import Plan
from abi.robot.any_arm import AnyArm
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.robot.urdf_arm import UrdfArm
from app.layers.arm import paper_poses, urdf_poses
from app.layers.arm.arm_nodes import ArmNodes


class ArmKind(Protocol):
    """What is drawn of a kind of arm beside its motion's pose, and its nodes: the kind's module."""

    def nodes(self, scene: viser.SceneApi) -> ArmNodes[Any]:
        """Its nodes in a tab's scene."""

    def bodies(self, arm: Any) -> object:
        """Make the bodies of its links, which all tabs share."""

    @property
    def SLOW_REGIONS(self) -> bool:
        """Whether its regions take longer than a frame where the start is another."""

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


KINDS: dict[type[AnyArm], ArmKind] = {PaperArm: paper_poses, UrdfArm: urdf_poses}


def kind_of(arm: AnyArm) -> ArmKind:
    """The kind of an arm."""
    return KINDS[type(arm)]
