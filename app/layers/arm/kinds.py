"""Table of the kinds of arms: what each looks like, and its other poses and regions.

A new kind of arm is a module with what :class:`app.layers.arm.arm_nodes.ArmKind` lists, and a line
here.
"""

from __future__ import annotations

from abi.robot.any_arm import AnyArm
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.robot.urdf_arm import UrdfArm
from app.layers.arm import paper_poses, urdf_poses
from app.layers.arm.arm_nodes import ArmKind

KINDS: dict[type[AnyArm], ArmKind] = {PaperArm: paper_poses, UrdfArm: urdf_poses}


def kind_of(arm: AnyArm) -> ArmKind:
    """The kind of an arm."""
    return KINDS[type(arm)]
