"""The plan: results of the stages, and their JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from abi.arm_planning.joint_rates import JointRates, joint_rates, passed_limits
from abi.arm_planning.joint_search.held_direction import HeldDirection
from abi.arm_planning.joint_search.held_span import HeldSpan, exact_span, held_span
from abi.arm_planning.motion.liquid import largest_tilt
from abi.arm_planning.motion.trajectory import Violation
from abi.arrays import ShortRepr
from abi.errors import ExportError, StageError, short
from abi.planner import plan_json
from abi.planner.joined_legs import begins, joined_violations
from abi.planner.stage_results import StageResults
from abi.robot.any_arm import AnyArm
from abi.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class Plan(StageResults, ShortRepr):
    """Results of the stages for a scene, and how they came about. Arrays are read-only.

    Attributes:
        scene: the scene.
        arm: the arm.
        legs: plans of a sequence of tasks, all of whose motions this one joins.
        error: why the plan ends early, or None.
        ms: time of each stage when it last ran, [ms].
        interpreted: stages whose inner loops were not compiled then: their times say little.
        total_ms: time of this call, [ms].
    """

    scene: Scene
    arm: AnyArm | None = None
    legs: tuple[Plan, ...] = ()
    error: StageError | None = None
    ms: Mapping[str, float] = field(default_factory=dict)
    interpreted: frozenset[str] = frozenset()
    total_ms: float = 0.0

    def __repr__(self) -> str:
        """One line: what is followed, or why there is no plan."""
        if self.error is not None or self.profile is None:
            return f"<Plan: {self.error or 'incomplete'}>"
        clear = "proven" if self.is_arm_clear else "not proven"
        if self.followed_arc is None:
            seconds = f"{self.profile.duration:.3g} s"
            return f"<Plan: joints alone, in {seconds}, whole arm {clear} clear>"
        return (
            f"<Plan: {self.followed} of {self.followed_arc.length:.4g} {self.scene.unit} "
            f"in {self.profile.duration:.3g} s, whole arm {clear} clear>"
        )

    def __getstate__(self) -> dict[str, Any]:
        """What ``pickle`` and ``copy`` keep; a view of a dict is not among what they can."""
        return {**vars(self), "ms": dict(self.ms)}

    @cached_property
    def liquid_tilt(self) -> float | None:
        """Largest tilt of the liquid in a cup on the tool, [rad]; None without a motion."""
        fit = self.followed_curve
        if fit is None or self.profile is None:
            return None
        return largest_tilt(fit.curve, fit.arc, self.profile, self.scene.unit)

    @cached_property
    def joint_rates(self) -> JointRates | None:
        """Speeds, accelerations and torques of the joints, and their limits."""
        if self.arm is None or self.motion is None:
            return None
        return joint_rates(self.arm, self.motion, self.scene.motion.joint_acceleration)

    @cached_property
    def limits_passed(self) -> tuple[Violation, ...]:
        """Joints past a limit of position, speed, acceleration or torque, each where it is worst.

        The paper's arm has limits of position alone. Of several legs that pass the same limit,
        the one is told that is farthest past it.
        """
        if self.legs:
            return joined_violations([leg.limits_passed for leg in self.legs], self._begins)
        if self.arm is None or self.motion is None or self.joint_rates is None:
            return ()
        rates = passed_limits(self.motion, self.joint_rates)
        return (*self.motion.limit_violations, *rates)

    @property
    def _begins(self) -> list[float]:
        """When each leg begins, [s]."""
        return begins(
            [0.0 if one.motion is None else float(one.motion.time[-1]) for one in self.legs]
        )

    @cached_property
    def held_spans(self) -> tuple[HeldSpan, ...]:
        """When the direction of the tool is kept, and how well; one for each leg that keeps one."""
        if self.legs:
            legs = zip(self.legs, self._begins, strict=True)
            return tuple(span.later(begin) for leg, begin in legs for span in leg.held_spans)
        settings, arm, motion = self.scene.arm, self.arm, self.motion
        if arm is None or motion is None or not motion.reachable:
            return ()
        if settings.exact_axis is not None:
            return (exact_span(arm, settings.exact_axis, motion),)
        if settings.held_axis is None or self.joint_search is None:
            return ()
        return (held_span(HeldDirection.of(arm, settings.held_axis), motion),)

    def for_arm(self) -> Plan:
        """The plan to begin with on an arm's branch, of that of the tool alone."""
        optimum, tool_only = self.optimum, self.followed_curve
        return Plan(self.scene, arm=self.arm, optimum=optimum, tool_only=tool_only)

    @property
    def straight_length(self) -> float:
        """Length of the straight line from start to goal, [unit]: no curve is shorter."""
        return float(np.linalg.norm(np.subtract(self.scene.goal, self.scene.start)))

    def to_dict(self, full: bool = False) -> dict[str, Any]:
        """Plain data, ready for JSON, as ``docs/scene-and-plan.md`` describes it.

        A stage that was not reached is None.

        Args:
            full: whether to add the nodes and edges of the mesh and all samples of the motion.
        """
        return {
            "version": 1,
            "scene": self.scene.to_dict(),
            **{
                name: section(self, self.scene, self.ms, full)
                for name, section in plan_json.SECTIONS.items()
            },
            "timing": plan_json.timing(self.profile, self.moves_along, self.liquid_tilt, self.ms),
            "joint_search": plan_json.joint_search(self.joint_search, self.arm, self.ms, full),
            "arm": plan_json.arm(
                self.arm,
                self.motion,
                self.arm_clearance,
                self.scene.obstacles,
                (self.joint_rates, self.limits_passed),
                self.held_spans,
                self.ms,
                full,
            ),
            "total_ms": self.total_ms,
            "error": plan_json.error(self.error),
            "notes": list(self.scene.notes),
        }


def require_plan(value: object) -> None:
    """Raise an ExportError for what is given instead of a plan."""
    if not isinstance(value, Plan):
        raise ExportError(f"plan is {short(value)}; expected a Plan, such as abi.plan(scene).")
