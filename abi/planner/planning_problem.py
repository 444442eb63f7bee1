"""The problem of a planner: a scene, and the objects that its settings describe."""

from __future__ import annotations

import math
from dataclasses import dataclass

from abi.arm_planning.models import ArmModel
from abi.curves.cubic_profile import PathProfile
from abi.curves.fit_quadratic import Mode
from abi.errors import StageError
from abi.obstacles.obstacle_set import ObstacleSet
from abi.scene.scene import Scene
from abi.scene.settings import MOST_SAMPLES, SAMPLES, MotionSettings


@dataclass(frozen=True, eq=False)
class PlanningProblem:
    """A scene to plan, and what every branch makes use of.

    Attributes:
        scene: the scene.
        obstacles: its obstacles.
        model: its arm.
        searches: names of the searches to run, the scene's own among them.
        hasty: whether somebody waits for one of many plans.
    """

    scene: Scene
    obstacles: ObstacleSet
    model: ArmModel
    searches: tuple[str, ...]
    hasty: bool = False

    @property
    def quadratic_mode(self) -> Mode:
        """How the quadratic is fitted: a clear one that the arm does not follow is not awaited."""
        waits = not self.hasty or self.scene.motion.curve != "bspline"
        return self.scene.quadratic.mode if waits else "least_squares"

    @property
    def margin(self) -> float:
        """Distance that edges keep from the obstacles, [unit]."""
        return self.scene.spline.clearance + self.scene.workspace.slack


def sample_count(profile: PathProfile, asked: MotionSettings) -> int:
    """Number of samples of a motion, its first and last moment among them.

    Raises:
        StageError: the time step that is asked for takes more than there may be.
    """
    if asked.time_step is None:
        return asked.samples or SAMPLES
    count = round(profile.duration / asked.time_step) + 1
    if count > MOST_SAMPLES:
        step = profile.duration / (MOST_SAMPLES - 1)
        raise StageError(
            "timing",
            "too_many_samples",
            f"With this time step a motion of {profile.duration:.3g} s has {count:,} samples, and "
            f"{MOST_SAMPLES:,} may be planned.",
            f"Choose a motion.time_step of at least {math.ceil(step * 1e6) / 1e6:.6f} s.",
        )
    return max(count, 3)
