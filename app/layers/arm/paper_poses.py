"""The paper's arm as it is drawn: its poses beside that of its motion, and its regions."""

from __future__ import annotations

import numpy as np

from abi.arm_planning.branch.followed import Followed
from abi.arm_planning.exclusion.paper_arm_regions import reachable, shadow
from abi.arm_planning.world.arm_worlds import paper_arm_world
from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.plan import Plan
from abi.robot.paper_arm.inverse_kinematics import solve
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.scene.arm_settings import Elbow
from app.drawing.lines import rows_at
from app.layers.arm import paper_arm
from app.layers.arm.arm_playback import samples_of

SLOW_REGIONS = False
NODES = ("/arm", "links")
bodies, look, build = paper_arm.bodies, paper_arm.look, paper_arm.build
rest_pose, joint_values = paper_arm.rest_pose, paper_arm.joint_values


def end_pose(plan: Plan, arm: PaperArm, end: str) -> FloatArray:
    """Pose (6,) with the tool at the ``start`` or ``goal``."""
    pose: FloatArray = _poses(arm, np.array([getattr(plan.scene, end)]), plan)[0]
    return pose


def other_poses(plan: Plan, arm: PaperArm, time: float) -> FloatArray:
    """Pose (1, 6) on the other side of the elbow, with the tool where it is at a time [s]."""
    return _poses(arm, _tool_at(plan, time)[None], plan, other=True)


def other_joint_paths(plan: Plan, arm: PaperArm) -> tuple[Followed, ...]:
    """Joint path on the other side of the elbow, at the page's samples of the motion."""
    motion = plan.motion
    assert motion is not None
    rows = samples_of(motion)
    positions = _poses(arm, motion.tool[rows], plan, other=True)
    return (Followed(motion.time[rows], positions, np.zeros(len(rows))),)


def region_start(plan: Plan, arm: PaperArm) -> Elbow:
    """What its regions depend on beside its settings: the side of its elbow."""
    return _elbow_of(plan)


def region(name: str, plan: Plan, arm: PaperArm) -> FloatArray:
    """Triangles (n, 3, 3) of its ``shadow`` or ``reach``, [unit], world."""
    scene, elbow = plan.scene, _elbow_of(plan)
    lowest, box = scene.workspace.min[2], (scene.workspace.min, scene.workspace.max)
    if name == "shadow":
        obstacles = paper_arm_world(arm, ObstacleSet(scene.obstacles), lowest)
        return shadow(arm, elbow, scene.arm.q5, obstacles, box)
    floor = min(lowest, scene.arm.base[2])
    return reachable(arm, elbow, scene.arm.q5, floor)


def _poses(arm: PaperArm, tool: FloatArray, plan: Plan, other: bool = False) -> FloatArray:
    """Joint positions (k, 6) of the paper's arm with its tool at (k, 3), on its branch or not."""
    elbow = _elbow_of(plan)
    if other:
        elbow = "down" if elbow == "up" else "up"
    q5, still = np.full(len(tool), plan.scene.arm.q5), np.zeros(len(tool))
    joints, _ = solve(arm, tool, q5, elbow, np.zeros_like(tool))
    return np.column_stack([joints, still, q5, still])


def _elbow_of(plan: Plan) -> Elbow:
    """Branch of the plan's arm."""
    return plan.scene.arm.branches[0] if plan.motion is None else plan.motion.elbow


def _tool_at(plan: Plan, time: float) -> FloatArray:
    """Position of the tool at a time, (3,), [unit], world."""
    motion = plan.motion
    if motion is None:
        return np.array(plan.scene.start)
    return rows_at(time, motion.time, motion.tool)
