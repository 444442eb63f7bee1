"""Questions to any arm as functions, so that stages can remember the answers."""

from __future__ import annotations

from collections.abc import Sequence

from abi.arm.arm_clearance import ArmClearance
from abi.arm.arm_model import ArmModel, Course
from abi.arm.surroundings import Surroundings
from abi.arm.trajectory import ArmMotion
from abi.curves.curve import ArcLength, Curve
from abi.curves.timed_profile import PathProfile
from abi.obstacles.obstacle_set import ObstacleSet
from abi.scene.settings import ArmSettings


def surroundings_of(model: ArmModel, obstacles: ObstacleSet, lowest: float) -> Surroundings:
    """Surroundings of an arm."""
    return model.surroundings(obstacles, lowest)


def courses_of(
    model: ArmModel,
    curve: Curve,
    arc: ArcLength,
    settings: ArmSettings,
    obstacles: ObstacleSet,
    around: Surroundings,
) -> Sequence[Course]:
    """An arm's joints along a curve, on each of its branches."""
    return model.courses(curve, arc, settings, obstacles, around)


def motion_on(course: Course, profile: PathProfile, samples: int) -> ArmMotion:
    """The motion of a course."""
    return course.motion(profile, samples)


def clearance_on(
    course: Course,
    motion: ArmMotion,
    obstacles: ObstacleSet,
    around: Surroundings,
    required: float,
) -> ArmClearance:
    """Clearance of the arm in that motion."""
    return course.clearance(motion, obstacles, around, required)
