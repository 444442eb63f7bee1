"""The arms that there are: the paper's, and those of URDFs; both have what everyone but the planner
asks for."""

from __future__ import annotations

from abi.robot.paper_arm.paper_arm import PaperArm
from abi.robot.urdf_arm import UrdfArm

AnyArm = PaperArm | UrdfArm
"""An arm: its chain of joints, and the capsules around its links."""
