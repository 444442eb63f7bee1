"""Plans of a sequence of tasks: leg by leg, each from the joints in which the last one ended.

Each leg is an ordinary plan of a scene of its own, with its own certificate. What the gripper
attaches is no obstacle any more but a body of the arm, until it is released where it then is.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arrays import FloatArray, ShortRepr, read_only
from abi.errors import StageError
from abi.obstacles.pose import METRES
from abi.planner import plan_json
from abi.planner.joined_legs import joined_clearance, joined_motion
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.planner.task_scenes import first_scene, next_scene, number_in_scene
from abi.scene.scene import Scene, require_scene

_FAR = 0.25
"""Distance from the tool tip to an object that it takes, from which on a note tells of it, [m]."""


@dataclass(frozen=True, eq=False, repr=False)
class TaskPlan(ShortRepr):
    """Plans of the legs of a scene's tasks, as far as they come.

    Attributes:
        scene: the scene.
        legs: plan of each leg; the last one has an error where the sequence ends early.
        total_ms: time of all, [ms].
    """

    scene: Scene
    legs: tuple[Plan, ...]
    total_ms: float = 0.0

    @property
    def error(self) -> StageError | None:
        """Why the sequence ends early, or None; it counts obstacles as the scene does."""
        error = self.legs[-1].error
        return error and error.renumbered(self._numbers(len(self.legs) - 1))

    def _numbers(self, leg: int) -> Callable[[int], int]:
        """Number in the scene of an obstacle by its number in that of a leg."""
        return partial(number_in_scene, self.scene, leg)

    @property
    def trajectory(self) -> ArmMotion | None:
        """The motion of all legs on one time bar; None where one of them has none.

        At the ends of each leg the arm rests; its last sample and the first of the next are one.
        """
        is_whole = self.error is None and len(self._motions) == len(self.legs)
        return joined_motion(self._motions) if is_whole else None

    @property
    def begins(self) -> FloatArray:
        """When each leg that has a motion begins, and when the last one ends, (legs + 1,), [s]."""
        return read_only(np.cumsum([0.0, *(motion.time[-1] for motion in self._motions)]))

    @property
    def _motions(self) -> list[ArmMotion]:
        return [leg.motion for leg in self.legs if leg.motion is not None]

    @property
    def joined(self) -> Plan:
        """One plan with the motions of all legs, as far as they come, for files of a motion.

        Its other results are those of the first leg. Obstacles have the numbers of the scene.
        """
        legs = tuple(leg for leg in self.legs if leg.motion is not None)
        clearances = [
            leg.arm_clearance.renumbered(self._numbers(number))
            for number, leg in enumerate(self.legs)
            if leg.motion is not None and leg.arm_clearance is not None
        ]
        first = self.legs[0]
        if not legs:
            return replace(first, scene=self.scene)
        return replace(
            first,
            scene=self.scene,
            profile=None,
            motion=joined_motion(self._motions),
            arm_clearance=joined_clearance(
                clearances,
                [float(motion.time[-1]) for motion in self._motions],
            ),
            legs=legs,
            error=self.error,
            total_ms=self.total_ms,
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences on the scene, and the gripper's own motion, and what is taken from afar."""
        held = [leg.scene.arm.gripper for leg in self.legs]
        moving = [str(k + 1) for k in range(1, len(held)) if held[k] != held[k - 1]]
        told = [f"How the gripper moves before leg {', '.join(moving)} is not proven."]
        first = self.legs[0].notes if self.legs else self.scene.notes
        states = [
            f"Leg {number}: {note}"
            for number, leg in enumerate(self.legs[1:], 2)
            for note in (*leg.scene.arm.state_notes(METRES[leg.scene.unit]), *leg.not_compared)
            if note not in first
        ]
        told = told if moving else []
        return (*first, *states, *told, *self._taken_from_afar())

    def _taken_from_afar(self) -> Iterator[str]:
        """Sentences on objects that are attached where the tool tip is nowhere near them."""
        unit = self.scene.unit
        for number, (leg, task) in enumerate(zip(self.legs, self.scene.tasks, strict=False), 1):
            if task.attach is None or leg.motion is None:
                continue
            taken = leg.scene.obstacles[task.attach]
            away = float(taken.signed_distance(leg.motion.tool[-1:])[0])
            if away * METRES[unit] > _FAR:
                yield (
                    f"On leg {number} obstacle {task.attach + 1} is taken from {away:.3g} {unit} "
                    "away: tasks.attach counts obstacles from 0."
                )

    def to_dict(self, full: bool = False) -> dict[str, Any]:
        """Plain data, ready for JSON, as ``docs/scene-and-plan.md`` describes it.

        Args:
            full: whether each leg has all of its samples, and the nodes of its mesh.
        """
        whole = self.trajectory
        counts = [len(motion.time) - (k > 0) for k, motion in enumerate(self._motions)]
        return {
            "version": 1,
            "scene": self.scene.to_dict(),
            "legs": [leg.to_dict(full) for leg in self.legs],
            "trajectory": None
            if whole is None
            else {
                "joints": list(whole.joints),
                "time": whole.time.tolist(),
                "positions": whole.positions.tolist(),
                "leg": np.repeat(np.arange(len(counts)), counts).tolist(),
                "begins": self.begins.tolist(),
            },
            "total_ms": self.total_ms,
            "error": plan_json.error(self.error),
            "notes": list(self.notes),
        }


def plan_tasks(scene: Scene) -> TaskPlan:
    """Plan all legs of a scene's tasks, one after the other.

    Args:
        scene: the scene; without tasks its way from start to goal is the only leg.

    Returns:
        The plans, up to the first leg that has none; nothing is raised.

    Raises:
        SceneError: ``scene`` is no scene.
    """
    require_scene(scene)
    begin = time.perf_counter()
    legs = tuple(legs_of(scene, [Planner()] * max(len(scene.tasks), 1)))
    return TaskPlan(scene, legs, 1e3 * (time.perf_counter() - begin))


def legs_of(scene: Scene, planners: Sequence[Planner], chosen_only: bool = False) -> Iterator[Plan]:
    """Plans of the legs, each as soon as it is made, up to the first that has an error.

    Args:
        scene: the scene; without tasks its way from start to goal is the only leg.
        planners: the planner of each leg.
        chosen_only: whether to run only the search that the scene names.
    """
    leg_scene = first_scene(scene) if scene.tasks else scene
    for number, planner in enumerate(planners):
        plan = planner(leg_scene, chosen_only)
        yield plan
        if plan.error is not None or number + 1 >= len(scene.tasks):
            return
        leg_scene = next_scene(scene, number + 1, plan)
