"""Branches of an arm, and its joints along a curve: of the paper's arm, or of one from a URDF."""

from __future__ import annotations

from abi.arm_planning.branch.chain_branch import ChainBranch
from abi.arm_planning.branch.elbow_branch import ElbowBranch
from abi.arm_planning.branch.paper_arm_joint_path import PaperArmJointPath
from abi.arm_planning.motion.urdf_motion import ChainJointPath

ArmBranch = ElbowBranch | ChainBranch
"""Nodes, edges and curves that an arm allows on one branch, such as an elbow of the paper's."""

JointPath = PaperArmJointPath | ChainJointPath
"""Joint positions of an arm along its tool's curve, for one elbow side or one start pose."""
