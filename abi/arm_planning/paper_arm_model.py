"""The paper's arm as the planner uses it: joints by formulas, on two elbow branches."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

from abi.arm_planning.branch.arm_branch import ArmBranch
from abi.arm_planning.branch.elbow_branch import ElbowBranch
from abi.arm_planning.branch.paper_arm_joint_path import PaperArmJointPath
from abi.arm_planning.world.arm_worlds import paper_arm_world
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arm_planning.world.row_table import RowTable
from abi.arm_planning.wrist_drives import wrist_positions
from abi.curves import three_phase_profile
from abi.curves.curve import ArcLength, Curve
from abi.obstacles.obstacle_set import ObstacleSet
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.scene.arm_settings import ArmSettings
from abi.scene.scene import Scene
from abi.tet_mesh.tet_mesh import TetMesh

_LONGER = 1.5
"""Longest path, over the straight line, whose duration bounds the slide in advance."""


def paper_arm(settings: ArmSettings, unit: Literal["m", "cm", "mm"] = "cm") -> PaperArm:
    """The paper's arm that a scene's settings describe; lengths in the scene's unit."""
    lengths = settings.a1, settings.a2, settings.a3, settings.a4, settings.a5
    return PaperArm.of(settings.base, lengths, unit)


class PaperArmModel:
    """The paper's arm for the planner; caches the rows of the last obstacles."""

    def __init__(self, settings: ArmSettings, unit: Literal["m", "cm", "mm"]) -> None:
        self.arm = paper_arm(settings, unit)
        self.chain_arm = None
        self._rows = RowTable()

    def collision_world(self, obstacles: ObstacleSet, lowest: float) -> CollisionWorld:
        """The arm's collision world: obstacles, floor and column."""
        return paper_arm_world(self.arm, obstacles, lowest, self._rows)

    def joint_paths(
        self,
        curve: Curve,
        arc: ArcLength,
        settings: ArmSettings,
        collision_world: CollisionWorld,
        hasty: bool = False,
    ) -> tuple[PaperArmJointPath, ...]:
        """Joints along a curve, on each allowed elbow branch."""
        branches = settings.branches
        return tuple(
            PaperArmJointPath(curve, arc, self.arm, settings.on(elbow)) for elbow in branches
        )

    def is_refuted(
        self,
        curve: Curve,
        arc: ArcLength,
        collision_world: CollisionWorld,
        required: float,
    ) -> bool:
        """False: its joints follow from formulas, and testing them along the curve is as quick."""
        return False

    def branches(
        self,
        scene: Scene,
        collision_world: CollisionWorld,
        mesh: TetMesh,
        slack: float,
        only: str = "",
    ) -> tuple[ElbowBranch, ...]:
        """One branch for each allowed elbow, whichever is named: they are made at once."""
        settings, extensions = scene.arm, _extensions(scene)
        asked = extensions, settings.clearance, slack
        return tuple(
            ElbowBranch(self.arm, elbow, collision_world, *asked, settings=settings)
            for elbow in settings.branches
        )

    def branches_in_turn(
        self, scene: Scene, collision_world: CollisionWorld, mesh: TetMesh, slack: float
    ) -> Iterator[ElbowBranch]:
        """One branch for each allowed elbow."""
        return iter(self.branches(scene, collision_world, mesh, slack))

    def other_branches(
        self, scene: Scene, collision_world: CollisionWorld, mesh: TetMesh, slack: float
    ) -> tuple[Iterator[ArmBranch], str]:
        """No further branches: an elbow has only two sides."""
        return iter(()), ""


def _extensions(scene: Scene) -> tuple[float, float]:
    """Least and greatest q5 during a rather long path, [unit]."""
    settings, asked = scene.arm, scene.motion
    if settings.forces[1] == 0:
        return settings.q5, settings.q5
    straight = float(np.linalg.norm(np.subtract(scene.goal, scene.start)))
    longest = three_phase_profile.three_phase(
        _LONGER * straight, asked.speed, asked.acceleration, asked.deceleration
    )
    end = float(wrist_positions(settings, [longest.duration])[0, 1])
    return min(settings.q5, end), max(settings.q5, end)
