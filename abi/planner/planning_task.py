"""The task of a planner: a scene, and the objects that its settings describe."""

from __future__ import annotations

from dataclasses import dataclass

from abi.arm_planning.arm_model import ArmModel
from abi.obstacles.obstacle_set import ObstacleSet
from abi.scene.scene import Scene

SAMPLES = 401
"""Samples of the arm's motion, uniform in time."""


@dataclass(frozen=True, eq=False)
class PlanningTask:
    """A scene to plan, and what every branch makes use of.

    Attributes:
        scene: the scene.
        obstacles: its obstacles.
        model: its arm.
        searches: names of the searches to run, the scene's own among them.
    """

    scene: Scene
    obstacles: ObstacleSet
    model: ArmModel
    searches: tuple[str, ...]

    @property
    def margin(self) -> float:
        """Distance that edges keep from the obstacles, [unit]."""
        return self.scene.spline.clearance + self.scene.workspace.slack
