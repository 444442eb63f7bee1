"""The branch of an arm whose motion is sought in the space of its joints, without a mesh.

It is taken where joints, or a pose of the tool, are asked for at start or goal, and where the mesh
of places of the tool leads to no motion. The arm then follows no curve of the tool: its joints
follow one of their own.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from abi import progress
from abi.arm_planning.arm_errors import no_joint_motion
from abi.arm_planning.branch.followed import Followed
from abi.arm_planning.branch.segment_memory import SegmentMemory
from abi.arm_planning.certificates.chain_certificate import chain_refutation
from abi.arm_planning.joint_search.held_direction import HeldDirection
from abi.arm_planning.joint_search.joint_motion import passage_of, proven_motion
from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arm_planning.joint_search.joint_spline import JointSpline, sampled, spline_near
from abi.arm_planning.joint_search.search_joints import (
    JointSearch,
    JointSearchEffort,
    search_joints,
    shorter_path,
)
from abi.arm_planning.motion.arm_clearance import is_clear
from abi.arm_planning.motion.urdf_motion import ChainJointPath
from abi.arm_planning.motion_law import motion_law
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arrays import FloatArray
from abi.curves.clearance.certificate import Refutation
from abi.planner.end_poses import clear_end_poses
from abi.planner.held_direction_motion import move_holding
from abi.planner.plan import Plan
from abi.planner.planning_problem import sample_count
from abi.planner.remembered_call import RememberedCall
from abi.robot.urdf_arm import UrdfArm
from abi.scene.arm_end import ENDS
from abi.scene.arm_settings import ArmSettings
from abi.scene.scene import Scene

THOROUGH, HASTY = (
    JointSearchEffort(samples=3_000, shortcuts=60),
    JointSearchEffort(samples=200, shortcuts=10),
)
"""How long a motion is sought at rest, and while somebody waits for one of many plans."""


def asks_for_joints(arm: ArmSettings) -> bool:
    """Check whether a motion is to be sought in the space of the joints alone."""
    asked = any(one is not None for one in (arm.start, arm.goal, arm.held_axis))
    return arm.search == "joints" or (arm.search == "auto" and asked)


def may_search_joints(arm: ArmSettings) -> bool:
    """Check whether a motion may be sought there where the mesh has none.

    The direction of the tip is not held there.
    """
    return arm.model == "urdf" and arm.search == "auto" and arm.avoid and arm.axis is None


class JointSpaceMotions:
    """Motions in the space of an arm's joints, each by a memory of the last.

    While an obstacle is dragged most poses and ways that are asked about are those of the last
    plan, and of what has not moved they were clear.
    """

    def __init__(self) -> None:
        self._arm: UrdfArm | None = None
        self._memory = SegmentMemory()
        self._last: tuple[FloatArray, JointSpline] | None = None  # a path, and a curve near it
        self._passage_of = RememberedCall(passage_of)
        self._profile = RememberedCall(motion_law)

    def __call__(
        self,
        scene: Scene,
        arm: UrdfArm,
        collision_world: CollisionWorld,
        effort: JointSearchEffort,
        hasty: bool = False,
    ) -> Plan:
        """Find a motion in the space of an arm's joints, all of it proven clear.

        Args:
            scene: the scene.
            arm: its arm.
            collision_world: everything around the arm.
            effort: how long to search.
            hasty: whether the last path will do, made shorter, if it is clear.

        Returns:
            A plan of what was found there and the motion along a smooth curve near its path alone.

        Raises:
            NoJointMotion: none was found, or none that keeps the direction of the tool; tells why.
        """
        progress.tell("searching in the space of the joints")
        if arm is not self._arm:
            self._arm, self._memory, self._last = arm, SegmentMemory(), None
        self._memory.enter(collision_world)
        space = JointSpace(arm, collision_world, scene.arm.clearance)
        refuted = partial(self._refutation if hasty else _refutation, space)
        starts, goals = (clear_end_poses(space, scene, end, refuted) for end in ENDS)
        if scene.arm.held_axis is not None:
            part = HeldDirection.of(arm, scene.arm.held_axis)
            return move_holding(part, space, scene, (starts, goals), effort)
        search = self._search(space, starts, goals, effort, hasty)
        if search.path is None:
            raise no_joint_motion("path", samples=search.samples)
        if search.length == 0:
            raise no_joint_motion("same")
        passage = self._passage(space, search.path, hasty)
        profile = self._profile(passage, scene.motion)
        count = sample_count(profile, scene.motion)
        around = collision_world, scene.arm.clearance
        motion, clearance = proven_motion(passage, profile, count, *around)
        if not is_clear(motion, clearance):
            raise no_joint_motion("curve")
        return Plan(
            scene, profile=profile, motion=motion, arm_clearance=clearance, joint_search=search
        )

    def _search(
        self,
        space: JointSpace,
        starts: FloatArray,
        goals: FloatArray,
        effort: JointSearchEffort,
        hasty: bool,
    ) -> JointSearch:
        """A search that in haste begins with the last path, if it is clear."""
        if hasty and self._last is not None:
            path, _ = self._last
            joins = (starts == path[0]).all(axis=1).any() and (goals == path[-1]).all(axis=1).any()
            if joins and self._refutation(space, path) is None:
                return shorter_path(space, path, effort)
        return search_joints(space, starts, goals, effort)

    def _passage(self, space: JointSpace, path: FloatArray, hasty: bool) -> ChainJointPath:
        """The way of the joints along a smooth curve near a path (k, n), proven clear.

        In haste that is the last one, if it is clear and near the same path.

        Raises:
            NoJointMotion: there is no such curve.
        """
        if hasty and self._last is not None and np.array_equal(self._last[0], path):
            _, spline = self._last
            if self._refutation(space, sampled(spline)) is None:
                return self._passage_of(spline, space.arm)
        found = spline_near(space, path)
        if found is None:
            raise no_joint_motion("curve")
        self._last = path, found
        return self._passage_of(found, space.arm)

    def _refutation(self, space: JointSpace, positions: FloatArray) -> Refutation | None:
        """Where the arm is not clear along joint positions (k, n); what is known is not asked."""
        key = positions.tobytes(), space.margin
        unmissed = np.arange(float(len(positions))), positions, np.zeros(len(positions))

        def refute(way: Followed, around: CollisionWorld, itself: bool) -> Refutation | None:
            return _refutation(replace(space, collision_world=around), way.joints, itself)

        return self._memory.examined(key, lambda: Followed(*unmissed), refute)[1]


def _refutation(
    space: JointSpace, positions: FloatArray, with_itself: bool = True
) -> Refutation | None:
    """Where the arm is not clear along joint positions (k, n)."""
    around, margin = space.collision_world, space.margin
    return chain_refutation(space.arm, positions, around, margin, with_itself=with_itself)
