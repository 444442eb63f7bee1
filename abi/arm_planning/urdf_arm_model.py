"""A URDF arm as the planner uses it: joints by damped least squares.

Its branches are different poses with the tool at the start. If none of them leads to a motion,
redundant joints are drawn towards poses with the tool at the goal.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import Literal

import numpy as np

from abi.arm_planning.branch.arm_branch import ArmBranch
from abi.arm_planning.branch.chain_branch import ChainBranch
from abi.arm_planning.branch.followed import Followed
from abi.arm_planning.branch.pose_pairs import PosePair, pose_pairs
from abi.arm_planning.branch.segment_memory import SegmentMemory
from abi.arm_planning.certificates.chain_certificate import chain_refutation
from abi.arm_planning.exclusion.node_configurations import NodeConfigurations, spread_over
from abi.arm_planning.motion.urdf_motion import (
    ChainJointPath,
    chain_joint_path,
    start_pose,
    touches_from_all,
)
from abi.arm_planning.world.arm_worlds import chain_world
from abi.arm_planning.world.chain_distances import inside_meshes
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arm_planning.world.row_table import RowTable
from abi.arrays import FloatArray
from abi.curves.clearance.certificate import Refutation
from abi.curves.curve import ArcLength, Curve
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import METRES, Vec3
from abi.robot.urdf_arm import TRIED, urdf_arm
from abi.scene.arm_settings import ArmSettings
from abi.scene.scene import Scene
from abi.tet_mesh.tet_mesh import TetMesh

_BRANCHES = 6
"""Most first poses from which a path is sought."""
_ALL = 64
"""Most poses at start or goal that are paired if those lead to none."""
_REMEMBERED = 16
"""Most pairs whose configurations are cached."""


class UrdfArmModel:
    """An arm that a URDF describes.

    It remembers its configurations on the last mesh, and the rows of the last obstacles.
    """

    def __init__(self, settings: ArmSettings, unit: Literal["m", "cm", "mm"]) -> None:
        stands = settings.base, settings.exact_axis, unit, settings.base_wxyz
        robot = settings.with_attached(METRES[unit])
        touches = settings.gripper, settings.allowed, settings.grasping
        self.arm = self.chain_arm = urdf_arm(robot, settings.tool, *stands, *touches)
        self._at: tuple[TetMesh, Vec3, Vec3] | None = None
        self._configurations: dict[PosePair, tuple[NodeConfigurations, SegmentMemory]] = {}
        self._rows, self._poses = RowTable(), SegmentMemory()
        self._start = -1  # number of the last start pose along the tool's own curve

    def collision_world(self, obstacles: ObstacleSet, lowest: float) -> CollisionWorld:
        """The arm's collision world: obstacles and floor."""
        return chain_world(self.arm, obstacles, lowest, self._rows)

    def joint_paths(
        self,
        curve: Curve,
        arc: ArcLength,
        settings: ArmSettings,
        collision_world: CollisionWorld,
        hasty: bool = False,
    ) -> tuple[ChainJointPath, ...]:
        """The joint path from the start pose that keeps the arm clearest; in haste the last one."""
        likely = self._start if hasty else -1
        self._start = start_pose(curve, arc, self.arm, collision_world, likely)
        return (chain_joint_path(curve, arc, self.arm, self._start),)

    def is_refuted(
        self,
        curve: Curve,
        arc: ArcLength,
        collision_world: CollisionWorld,
        required: float,
    ) -> bool:
        """Check whether it touches something at a few points, whatever start pose it has."""
        # near meshes the quick test is of capsules, which are larger
        if collision_world.obstacles.meshes:
            return False
        return touches_from_all(curve, arc, self.arm, collision_world, required)

    def branches(
        self,
        scene: Scene,
        collision_world: CollisionWorld,
        mesh: TetMesh,
        slack: float,
        only: str = "",
    ) -> tuple[ChainBranch, ...]:
        """One branch for each of a few start poses, clear ones if there are any."""
        self._remember(scene, mesh)
        poses, is_clear = self._poses_at(scene.start), self._asked(scene, collision_world, slack)
        pairs: list[PosePair] = []
        if only:  # whether others are clear is not asked
            known = {(number, None) for number in range(TRIED)} | {*self._configurations}
            named = [pair for pair in known if _name_of(*pair) == only and pair[0] < len(poses)]
            pairs = [(first, home) for first, home in named if is_clear(poses[first])]
        else:
            clear = _clear_ones(poses[:TRIED], is_clear)
            pairs = [(number, None) for number in _first_ones(clear)]
        return tuple(self._branch(scene, collision_world, slack, *pair) for pair in pairs)

    def branches_in_turn(
        self, scene: Scene, collision_world: CollisionWorld, mesh: TetMesh, slack: float
    ) -> Iterator[ChainBranch]:
        """Start poses, each made on demand; the one along the tool's own curve comes first."""
        self._remember(scene, mesh)
        is_clear = self._asked(scene, collision_world, slack)
        clear = _clear_ones(self._poses_at(scene.start)[:TRIED], is_clear)
        numbers = sorted(_first_ones(clear), key=lambda number: number != self._start)
        return (self._branch(scene, collision_world, slack, number, None) for number in numbers)

    def other_branches(
        self, scene: Scene, collision_world: CollisionWorld, mesh: TetMesh, slack: float
    ) -> tuple[Iterator[ArmBranch], str]:
        """One branch for each of a few clear pairs of a start pose and a pose at the goal.

        A start pose that was not tried may also stand alone.
        """
        if not self.arm.is_redundant:
            return iter(()), ""
        self._remember(scene, mesh)
        is_clear = self._asked(scene, collision_world, slack)
        poses = [self._poses_at(point) for point in (scene.start, scene.goal)]
        firsts, lasts = (_clear_ones(some, is_clear) for some in poses)
        for where, found, clear in zip(("start", "goal"), poses, (firsts, lasts), strict=True):
            if not clear:
                note = f"Of {len(found)} poses found at the {where} none keeps the arm clear."
                return iter(()), note
        tried = [(number, None) for number in _first_ones(firsts)]
        line = np.array(scene.start), np.array(scene.goal)
        pairs = pose_pairs(self.arm, line, firsts, lasts, is_clear)
        others = (pair for pair in pairs if pair not in tried)
        return (self._branch(scene, collision_world, slack, *pair) for pair in others), ""

    def _remember(self, scene: Scene, mesh: TetMesh) -> None:
        """Drop caches of another mesh, start or goal."""
        at = (mesh, scene.start, scene.goal)
        if self._at is None or at[0] is not self._at[0] or at[1] != self._at[1]:
            self._configurations = {}
        elif at[2] != self._at[2]:
            self._configurations = {
                pair: one for pair, one in self._configurations.items() if pair[1] is None
            }
        self._at = at

    def _poses_at(self, point: Vec3) -> tuple[FloatArray, ...]:
        """All poses found with the tool at a point."""
        return self.arm.first_poses(np.array(point), _ALL)

    def _asked(
        self, scene: Scene, collision_world: CollisionWorld, slack: float
    ) -> Callable[[FloatArray], bool]:
        """Function that tells whether the arm, standing still in a pose, is proven clear."""
        return partial(self._is_clear, collision_world, scene.arm.clearance + slack)

    def _is_clear(self, collision_world: CollisionWorld, margin: float, pose: FloatArray) -> bool:
        """Check whether the arm, standing still, is proven clear and in no closed mesh."""
        self._poses.enter(collision_world)
        _, fault = self._poses.examined(
            (pose.tobytes(), margin), partial(_still, pose), partial(self._refutation, margin)
        )
        if fault is not None:
            return False
        return not inside_meshes(self.arm, collision_world, pose)

    def _refutation(
        self, margin: float, followed: Followed, around: CollisionWorld, with_itself: bool
    ) -> Refutation | None:
        """Why the arm, standing still, is not proven clear."""
        joints = followed.joints
        return chain_refutation(self.arm, joints, around, margin, with_itself=with_itself)

    def _branch(
        self,
        scene: Scene,
        collision_world: CollisionWorld,
        slack: float,
        first: int,
        home: int | None,
    ) -> ChainBranch:
        configurations, memory = self._spread(first, home)
        memory.enter(collision_world)
        around = collision_world, configurations, scene.arm.clearance, slack
        return ChainBranch(self.arm, _name_of(first, home), *around, memory=memory)

    def _spread(self, first: int, home: int | None) -> tuple[NodeConfigurations, SegmentMemory]:
        """Configurations on the mesh from a first pose, drawn to a home; memory of segments."""
        if (first, home) not in self._configurations:
            assert self._at is not None
            mesh, start, goal = self._at
            pose = self._poses_at(start)[first]
            drawn = pose if home is None else self._poses_at(goal)[home]
            found = spread_over(self.arm, mesh, np.array(start, dtype=float), pose, drawn)
            if len(self._configurations) >= _REMEMBERED:
                self._configurations.pop(next(iter(self._configurations)))
            self._configurations[first, home] = found, SegmentMemory()
        return self._configurations[first, home]


def _name_of(first: int, home: int | None) -> str:
    """Name of the branch from a first pose, drawn to a home."""
    name = f"From pose {first + 1} at the start"
    return name if home is None else f"{name} drawn to pose {home + 1} at the goal"


def _clear_ones(
    poses: Sequence[FloatArray], is_clear: Callable[[FloatArray], bool]
) -> dict[int, FloatArray]:
    """The clear poses by their numbers."""
    return {k: pose for k, pose in enumerate(poses) if is_clear(pose)}


def _first_ones(clear: Iterable[int]) -> list[int]:
    """Numbers of the first poses that are tried alone; the very first if none is clear."""
    return [number for number in clear if number < TRIED][:_BRANCHES] or [0]


def _still(pose: FloatArray) -> Followed:
    """Joint path of an arm that stands still."""
    nothing = np.zeros(2)
    return Followed(nothing, np.stack([pose, pose]), nothing)
