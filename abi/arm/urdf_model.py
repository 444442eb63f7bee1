"""An arm of a URDF for the planner: its joints are found by damped least squares.

Its branches are different poses that put the tool on the start.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from abi.arm.arm_certificate import ArmCertificate
from abi.arm.chain_certificate import certify_chain
from abi.arm.chain_distances import obstacle_distances
from abi.arm.chain_sight import ChainSight
from abi.arm.chain_surroundings import chain_surroundings
from abi.arm.joint_course import joint_course
from abi.arm.stances import Stances, spread_over
from abi.arm.surroundings import Surroundings
from abi.arm.urdf_arm import urdf_arm
from abi.arm.urdf_motion import JointCourse
from abi.arrays import FloatArray
from abi.curves.curve import ArcLength, Curve
from abi.obstacles.obstacle_set import ObstacleSet
from abi.scene.scene import Scene
from abi.scene.settings import ArmSettings
from abi.tet_mesh.tet_mesh import TetMesh

_BRANCHES = 6
"""First poses, at most, from which a path is sought."""


class UrdfModel:
    """An arm that a URDF describes, with the memory of its stances on the last mesh."""

    def __init__(self, settings: ArmSettings, unit: Literal["m", "cm", "mm"]) -> None:
        axis = settings.axis
        self.arm = urdf_arm(settings.robot, settings.tool, settings.base, axis, unit)
        self._start: tuple[object, ...] = ()
        self._poses: tuple[FloatArray, ...] = ()
        self._mesh: TetMesh | None = None
        self._stances: dict[int, Stances] = {}

    def surroundings(self, obstacles: ObstacleSet, lowest: float) -> Surroundings:
        """Obstacles and floor."""
        return chain_surroundings(self.arm, obstacles, lowest)

    def courses(
        self,
        curve: Curve,
        arc: ArcLength,
        settings: ArmSettings,
        obstacles: ObstacleSet,
        around: Surroundings,
    ) -> tuple[JointCourse, ...]:
        """The one from the first pose that keeps the arm clearest."""
        return (joint_course(curve, arc, self.arm, obstacles, around.floor),)

    def sights(
        self, scene: Scene, mesh: TetMesh, around: Surroundings, slack: float
    ) -> tuple[ChainSight, ...]:
        """One for each of some first poses, of those that are clear if there are any."""
        if self._start != scene.start:
            self._start, self._mesh = scene.start, None
            self._poses = self.arm.first_poses(np.array(scene.start))
        if self._mesh is not mesh:
            self._mesh, self._stances = mesh, {}
        clearance = scene.arm.clearance
        obstacles = ObstacleSet(scene.obstacles)
        clear = [
            number
            for number, pose in enumerate(self._poses)
            if self._is_clear(pose, obstacles, around, clearance + slack)
        ]
        return tuple(
            ChainSight(self.arm, number, around, self._stance(number), clearance, slack)
            for number in (clear or [0])[:_BRANCHES]
        )

    def _is_clear(
        self, pose: FloatArray, obstacles: ObstacleSet, around: Surroundings, margin: float
    ) -> bool:
        """Whether the arm, standing still, is proven clear and in no closed mesh."""
        found = certify_chain(self.arm, np.stack([pose, pose]), around, margin)
        if not isinstance(found, ArmCertificate):
            return False
        return bool((obstacle_distances(self.arm, obstacles, pose[None])[0] > 0).all())

    def _stance(self, number: int) -> Stances:
        """Stances on the mesh from one of the first poses."""
        assert self._mesh is not None
        if number not in self._stances:
            start = np.array(self._start, dtype=float)
            home = self._poses[number]
            self._stances[number] = spread_over(self.arm, self._mesh, start, home)
        return self._stances[number]
