"""Legs of a sequence of tasks as far as they are known: of each where it ends, and how long."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Self

from abi.errors import SceneError
from abi.planner.plan import Plan
from abi.planner.task_scenes import scene_from
from abi.robot.urdf_arm import urdf_arm
from abi.scene.scene import Scene

_LARGEST = 1e6


class LegEnd(NamedTuple):
    """Where a leg ends.

    Attributes:
        joints: positions by name, [rad] or [unit].
        duration: of its motion, [s].
    """

    joints: tuple[tuple[str, float], ...]
    duration: float

    @classmethod
    def of(cls, plan: Plan) -> Self | None:
        """The end of a planned leg; None without a motion."""
        motion = plan.motion
        if motion is None:
            return None
        pairs = zip(motion.joints, motion.positions[-1].tolist(), strict=True)
        return cls(tuple(pairs), float(motion.time[-1]))


@dataclass(frozen=True, eq=False)
class KnownLegs:
    """A sequence of tasks, of which some legs have been planned.

    Attributes:
        whole: the scene with all tasks.
        number: of the leg that is shown, from 0.
        ends: of the legs before it, and of those after it that are known.
    """

    whole: Scene
    number: int
    ends: tuple[LegEnd, ...]

    def scenes(self) -> tuple[Scene, ...]:
        """Scenes of the legs before the one that is shown.

        Raises:
            SceneError: the ends are of other joints, or none of that scene.
        """
        found = [self.whole]
        for number in range(1, self.number):
            settings, last = found[-1].arm, found[-1]
            stands = settings.base, settings.exact_axis, last.unit, settings.base_wxyz
            arm = urdf_arm(settings.robot, settings.tool, *stands, settings.gripper)
            joints = dict(self.ends[number - 1].joints)
            if tuple(joints) != arm.joints:
                raise SceneError("tasks", [*joints], f"the joints {', '.join(arm.joints)}")
            found.append(scene_from(self.whole, number, last, arm, joints))
        return tuple(found[: self.number])

    def to_list(self) -> list[Any]:
        """Number and ends as plain data."""
        return [self.number, [[dict(one.joints), one.duration] for one in self.ends]]

    @classmethod
    def of(cls, whole: Scene, data: object) -> Self | None:
        """The legs that untrusted data tell; None if they tell none of that scene."""
        match data:
            case [int(number), [*given]] if 0 < number < len(whole.tasks):
                ends = [_end(one) for one in given[: len(whole.tasks)]]
                known = tuple(one for one in ends if one is not None)
                return cls(whole, number, known) if number <= len(known) == len(ends) else None
        return None


def _end(data: object) -> LegEnd | None:
    """Where a leg ends, of untrusted data."""
    match data:
        case [dict() as joints, int() | float() as duration] if duration >= 0:
            if all(map(_is_number, [*joints.values(), duration])):
                pairs = tuple((str(name), float(at)) for name, at in joints.items())
                return LegEnd(pairs, float(duration))
    return None


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and abs(value) < _LARGEST
