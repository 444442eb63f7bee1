"""The plan: results of the stages, and their JSON."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from abi.arm_planning.joint_rates import JointRates, joint_rates, passed_limits
from abi.arm_planning.joint_search.held_direction import HeldDirection
from abi.arm_planning.joint_search.held_span import HeldSpan, exact_span, held_span
from abi.arm_planning.joint_search.search_joints import JointSearch
from abi.arm_planning.motion.arm_clearance import ArmClearance, is_clear
from abi.arm_planning.motion.liquid import largest_tilt
from abi.arm_planning.motion.trajectory import ArmMotion, Violation
from abi.arrays import ShortRepr
from abi.curves.bspline import BSpline
from abi.curves.cubic_profile import PathProfile
from abi.curves.curve import ArcLength
from abi.curves.fit import Fit
from abi.curves.quadratic import Quadratic
from abi.errors import AbiError, StageError, short
from abi.obstacles.pose import METRES
from abi.planner import plan_json
from abi.planner.joined_legs import begins, joined_violations
from abi.planner.stage_results import AnyFit, CurveName
from abi.robot.any_arm import AnyArm
from abi.robot.bodies.floor_contacts import floor_notes
from abi.robot.bodies.held_links import held_notes, mount_notes
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.scene.scene import Scene
from abi.search.graph import Graph
from abi.search.search import SearchResult
from abi.search.taut.lower_bound import Bound
from abi.search.taut.taut_path import TautPath
from abi.tet_mesh.exclusion import FreeMesh
from abi.tet_mesh.tet_mesh import TetMesh


@dataclass(frozen=True, eq=False)
class Plan(ShortRepr):
    """Results of the stages for a scene, and how they came about. Arrays are read-only.

    What was not reached is None. Lengths are in the scene's [unit], points in the world frame.

    Attributes:
        scene: the scene.
        arm: the arm.
        legs: plans of a sequence of tasks, all of whose motions this one joins.
        error: why the plan ends early, or None.
        ms: time of each stage when it last ran, [ms].
        interpreted: stages whose inner loops were not compiled then: their times say little.
        total_ms: time of this call, [ms].
        coarse: whether its mesh is coarser than the one asked for.
        partial: whether it was made in haste: with a coarser mesh, one search, or one branch of a
            URDF arm.
        free: stage 1, the mesh without the nodes and edges that the obstacles exclude.
        graph: stage 2, the free mesh with start and goal.
        searches: stage 3, the result of each search.
        path: the result of the search that the scene chooses.
        path_clearance: distance of that path to the obstacles; inf without obstacles.
        taut: stage 3½, the path pulled taut; None if that is switched off.
        optimum: lower bound of the length of any curve that keeps the clearance.
        bspline: stage 4, the B-spline, its clearance and its arc length.
        quadratic: stage 5, the quadratic, its clearance and its arc length.
        followed: ``bspline`` or ``quadratic``, whichever the arm follows.
        profile: stage 5, the motion along that curve.
        motion: stage 6, the arm's joint positions over time.
        arm_clearance: distance of its links to the obstacles along the motion.
        tool_only: the curve planned for the tool alone, if the whole arm follows another one.
        joint_search: the search in the space of the joints, if the motion is found there; the arm
            then follows no curve of the tool.
    """

    scene: Scene
    arm: AnyArm | None = None
    legs: tuple[Plan, ...] = ()
    error: StageError | None = None
    ms: Mapping[str, float] = field(default_factory=dict)
    interpreted: frozenset[str] = frozenset()
    total_ms: float = 0.0
    coarse: bool = False
    partial: bool = False
    _: KW_ONLY
    free: FreeMesh | None = None
    graph: Graph | None = None
    searches: tuple[SearchResult, ...] = ()
    path: SearchResult | None = None
    path_clearance: float = math.inf
    taut: TautPath | None = None
    optimum: Bound | None = None
    bspline: Fit[BSpline] | None = None
    quadratic: Fit[Quadratic] | None = None
    followed: CurveName | None = None
    profile: PathProfile | None = None
    motion: ArmMotion | None = None
    arm_clearance: ArmClearance | None = None
    tool_only: AnyFit | None = None
    joint_search: JointSearch | None = None

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

    @property
    def mesh(self) -> TetMesh | None:
        """The tetrahedral mesh of the whole workspace."""
        return None if self.free is None else self.free.mesh

    @property
    def curves(self) -> dict[str, AnyFit | None]:
        """Curves of stages 4 and 5 by name."""
        return {"bspline": self.bspline, "quadratic": self.quadratic}

    @property
    def followed_curve(self) -> AnyFit | None:
        """The curve that the arm executes."""
        return self.curves[self.followed] if self.followed else None

    @property
    def bspline_arc(self) -> ArcLength | None:
        """Arc length of the B-spline."""
        return None if self.bspline is None else self.bspline.arc

    @property
    def quadratic_arc(self) -> ArcLength | None:
        """Arc length of the quadratic."""
        return None if self.quadratic is None else self.quadratic.arc

    @property
    def followed_arc(self) -> ArcLength | None:
        """Arc length of the curve that the arm executes."""
        return None if self.followed_curve is None else self.followed_curve.arc

    @property
    def moves_along(self) -> str | None:
        """Name of the curve that is followed: one of the tool, or ``joints``."""
        return self.followed if self.joint_search is None else "joints"

    @property
    def is_arm_clear(self) -> bool:
        """Whether the whole arm is proven clear all along its motion, in reach and range."""
        if self.motion is None or self.arm_clearance is None:
            return False
        return is_clear(self.motion, self.arm_clearance)

    @property
    def lengths(self) -> dict[str, float | None]:
        """Lengths of paths and curves by stage, [unit]; None for a stage without a result."""
        path, taut, spline, quadratic = self.path, self.taut, self.bspline_arc, self.quadratic_arc
        return {
            "path": None if path is None else path.length,
            "taut": None if taut is None else taut.length,
            "bspline": None if spline is None else spline.length,
            "quadratic": None if quadratic is None else quadratic.length,
        }

    @property
    def kept_lengths(self) -> dict[str, float]:
        """Lengths of the paths and curves proven to keep the clearance, by stage, [unit]."""
        lacking = {name for name, fit in self.curves.items() if fit is None or not fit.holds}
        kept = {name: length for name, length in self.lengths.items() if name not in lacking}
        return {name: length for name, length in kept.items() if length is not None}

    @property
    def best_known(self) -> float | None:
        """Length of the shortest of this plan's curves that keep the clearance, [unit]."""
        return min(self.kept_lengths.values(), default=None)

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
        ms = self.ms
        return {
            "version": 1,
            "scene": self.scene.to_dict(),
            "mesh": plan_json.mesh(self.free, ms, full),
            "graph": plan_json.graph(self.graph, ms),
            "searches": plan_json.searches(self.searches, ms),
            "path": plan_json.path(self.path),
            "taut": plan_json.taut(self.taut, ms),
            "bspline": plan_json.bspline(self.bspline, ms),
            "quadratic": plan_json.quadratic(self.quadratic, self.scene.quadratic.mode, ms),
            "optimum": plan_json.optimum(self.optimum, self.kept_lengths, self.followed),
            "timing": plan_json.timing(self.profile, self.moves_along, self.liquid_tilt, ms),
            "joint_search": plan_json.joint_search(self.joint_search, self.arm, ms, full),
            "arm": plan_json.arm(
                self.arm,
                self.motion,
                self.arm_clearance,
                self.scene.obstacles,
                (self.joint_rates, self.limits_passed),
                self.held_spans,
                ms,
                full,
            ),
            "total_ms": self.total_ms,
            "error": plan_json.error(self.error),
            "notes": list(self.notes),
        }

    @property
    def paper_arm(self) -> PaperArm | None:
        """The arm if it is the paper's, which is proven along a curve and not along joints."""
        return self.arm if isinstance(self.arm, PaperArm) else None

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences on the scene, and on what is not compared."""
        return (*self.scene.notes, *self.not_compared)

    @property
    def not_compared(self) -> tuple[str, ...]:
        """Sentences on links that are below the floor, or held in others."""
        if self.arm is None or self.arm_clearance is None:
            return ()
        lowest, metres = self.scene.workspace.min[2], METRES[self.scene.unit]
        standing = [one.link for one in self.arm_clearance.allowed if one.other == "floor"]
        floor = min(self.scene.arm.base[2], lowest) * metres
        chain, asked = self.arm.chain, self.scene.arm.allowed
        mounts = {
            one.other: self.scene.obstacles[one.other]
            for one in self.arm_clearance.allowed
            if one.reason == "mount" and isinstance(one.other, int)
        }
        return (
            *floor_notes(chain, standing, floor),
            *held_notes(chain, floor, frozenset(asked)),
            *mount_notes(chain, mounts, metres, asked),
        )


def require_plan(value: object) -> None:
    """Raise an AbiError for what is given instead of a plan."""
    if not isinstance(value, Plan):
        raise AbiError(f"plan is {short(value)}; expected a Plan, such as abi.plan(scene).")
