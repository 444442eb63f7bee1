"""The branch of an arm on one side of its elbow, or from one start pose: all of it keeps clear."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, lru_cache, partial

import numpy as np

from abi.arm_planning.arm_errors import ArmNotClear, past_limit, touching
from abi.arm_planning.branch.arm_branch import ArmBranch
from abi.arm_planning.branch.arm_path import REFINEMENTS, fit_clear, pull_clear, search_clear
from abi.arm_planning.branch.branch_memory import BranchMemory
from abi.arm_planning.exclusion.arm_path_kernels import ROUNDS
from abi.arm_planning.motion.arm_clearance import named
from abi.arm_planning.motion_law import motion_law
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arrays import FloatArray
from abi.curves import fit_quadratic
from abi.curves.bspline import BSpline
from abi.curves.clearance.certificate import Refutation
from abi.curves.fit import Fit
from abi.curves.quadratic import Quadratic
from abi.errors import StageError
from abi.planner.branch import Branch
from abi.planner.plan import Plan
from abi.planner.planning_problem import PlanningProblem, sample_count
from abi.planner.stage_results import AnyFit, CurveName
from abi.robot.any_arm import AnyArm
from abi.scene.arm_end import ENDS
from abi.search.build_graph import build_graph
from abi.search.graph import Graph
from abi.search.search import SearchResult, search
from abi.search.taut.taut_path import TautPath
from abi.tet_mesh.exclusion import FreeMesh

_SLACKS = (1.0, 4.0, 16.0)
"""Multiples of the slack with which a path is pulled taut, until there is a curve near it."""
_HASTY_ROUNDS, _HASTY_REFINEMENTS = 1, 8
"""Rounds in which it is, and refinements of a curve, at most, in haste."""


_profile = lru_cache(maxsize=4)(motion_law)
"""While an obstacle is dragged that is not in the way the joints go along the same path."""


class WholeArmBranch(Branch):
    """An arm on one of its branches: its stages ask that the whole arm keeps clear.

    Attributes:
        collision_world: everything around the arm.
        tool: the plan for the tool alone, up to the curves.
        arm_branch: what the arm allows on this branch.
        memory: what is kept from one plan to the next.
    """

    def __init__(
        self,
        problem: PlanningProblem,
        collision_world: CollisionWorld,
        tool: Plan,
        arm_branch: ArmBranch,
        memory: BranchMemory,
    ) -> None:
        self.problem, self.plan = problem, tool.for_arm()
        self.collision_world, self.tool = collision_world, tool
        self.arm_branch, self.memory = arm_branch, memory

    def free_mesh(self) -> FreeMesh:
        """Stage 1: the tool's mesh without the nodes at which the arm is not clear.

        Raises:
            ArmNotClear: it is not clear at start or goal.
        """
        scene = self.problem.scene
        for which, point in (("start", scene.start), ("goal", scene.goal)):
            fault = self.arm_branch.polyline_refutation(np.array([point]))
            if fault is not None:
                raise self._not_clear_at(which, np.array(point), fault)
        assert self.tool.free is not None
        return self.memory.exclude(self.tool.free, self.arm_branch, self.problem.obstacles)

    def graph(self, free: FreeMesh) -> Graph:
        """Stage 2: start and goal joined to the mesh."""
        scene, obstacles, margin = self.problem.scene, self.problem.obstacles, self.problem.margin
        return build_graph(free, obstacles, margin, scene.start, scene.goal, scene.spline.clearance)

    def least_cost(self, graph: Graph) -> float:
        """Lower bound of the cost of the shortest path: that of edges that may not be clear.

        Raises:
            ArmNotClear: there is no path at all.
        """
        try:
            return self._search(graph).cost
        except StageError:
            raise self._not_clear("path") from None

    def shortest(self, graph: Graph) -> tuple[Graph, SearchResult, float]:
        """Stage 3: the shortest path whose edges are all clear for the arm.

        Raises:
            ArmNotClear: there is none.
        """
        try:
            found = search_clear(graph, self.arm_branch, self._search)
        except StageError:
            found = None
        if found is None:
            raise self._not_clear("path")
        clear, path = found
        return clear, path, self.problem.obstacles.polyline_clearance(path.points)

    def searches(self, graph: Graph, path: SearchResult) -> tuple[SearchResult, ...]:
        """Stage 3: all searches that are asked for, on the edges that are left."""
        chosen = self.problem.scene.search
        return tuple(
            path if name == chosen.algorithm else search(name, graph, chosen.weight)
            for name in self.problem.searches
        )

    def bspline(
        self, graph: Graph, path: SearchResult, away: float
    ) -> tuple[TautPath | None, Fit[BSpline]]:
        """Stages 3½ and 4: the path pulled taut, if that is asked for, and a B-spline near it.

        Where no curve near the taut path is proven clear, it is pulled with more room to round its
        corners, which makes it a little longer; in haste as much room as last time comes first.

        Raises:
            ArmNotClear: there is no curve.
        """
        obstacles, wanted, hasty = (
            self.problem.obstacles,
            self.problem.scene.spline,
            self.problem.hasty,
        )
        slacks = list(range(len(_SLACKS) if self.tool.taut is not None else 1))
        if hasty and self.memory.slack in slacks:
            slacks = slacks[self.memory.slack :] + slacks[: self.memory.slack]
        for slack in slacks:
            points, room, taut = path.points, away, None
            if self.tool.taut is not None:
                looser = self.arm_branch.scaled(slack=_SLACKS[slack])
                taut = pull_clear(
                    *(self.tool.taut, obstacles, self.problem.margin, path, looser),
                    rounds=_HASTY_ROUNDS if hasty else ROUNDS,
                )
                points, room = taut.points, taut.clearance
            fit = fit_clear(
                *(points, wanted.degree, obstacles, wanted.clearance, room, self.arm_branch),
                refinements=_HASTY_REFINEMENTS if hasty else REFINEMENTS,
            )
            if fit is not None:
                self.memory.slack = slack
                return taut, fit
        raise self._not_clear("curve")

    def quadratic(self, bspline: Fit[BSpline]) -> Fit[Quadratic]:
        """Stage 5: the quadratic nearest to the B-spline, if possible one that is clear."""
        scene, obstacles = self.problem.scene, self.problem.obstacles
        mode, is_clear = self.problem.quadratic_mode, self._is_clear_along
        fit = fit_quadratic.fit(bspline, obstacles, scene.spline.clearance, mode, is_clear)
        fault = self._refutation(fit.curve) if fit.holds else None
        return fit if fault is None else replace(fit, note=_note(fault, self.problem.model.arm))

    def followed(self, bspline: Fit[BSpline], quadratic: Fit[Quadratic]) -> CurveName:
        """Name of the curve that the arm follows: the quadratic only if it is clear along it."""
        asked = self.problem.scene.motion.curve
        if asked != "auto":
            return asked
        is_clear = quadratic.holds and self._is_clear_along(quadratic.curve)
        return "quadratic" if is_clear else "bspline"

    def motion(self, followed: AnyFit) -> Plan:
        """Stage 6: the plan with the motion along the curve.

        Raises:
            ArmNotClear: the arm is not proven clear along it.
        """
        scene = self.problem.scene
        joint_path = self.arm_branch.joint_path(followed.curve, followed.arc)
        profile = _profile(joint_path, scene.motion)
        motion = joint_path.motion(profile, sample_count(profile, scene.motion))
        clearance = joint_path.clearance(motion, self.collision_world, scene.arm.clearance)
        moved = replace(self.plan, profile=profile, motion=motion, arm_clearance=clearance)
        if not moved.is_arm_clear:
            why = ""
            if clearance.certified and motion.limit_violations:
                passed = motion.limit_violations[0]
                slides = motion.slides[motion.joints.index(passed.joint)]
                why = past_limit(passed.joint, passed.value, passed.limit, slides)
            raise self._not_clear("curve", why)
        return moved

    def _is_clear_along(self, curve: Quadratic) -> bool:
        """Check whether the arm is proven clear along a curve."""
        return self._refutation(curve) is None

    @cached_property
    def _refutation(self) -> Callable[[Quadratic], Refutation | None]:
        """Where the arm is not clear along a curve; those asked about already are remembered."""
        return lru_cache(self.arm_branch.refutation)

    @cached_property
    def _search(self) -> Callable[[Graph], SearchResult]:
        """The search that the scene chooses; its last result is remembered."""
        chosen = self.problem.scene.search
        return lru_cache(maxsize=1)(partial(search, chosen.algorithm, weight=chosen.weight))

    def explained(self, fault: ArmNotClear) -> ArmNotClear:
        """An error of this branch with what the link itself does at start or goal.

        That takes a while, and nobody asks as long as another branch has a motion.
        """
        if fault.where not in ENDS or fault.obstacle is None:
            return fault
        scene, where = self.problem.scene, fault.where
        point = np.array(scene.start if where == "start" else scene.goal)
        pair, branch = (fault.link, fault.obstacle), self.arm_branch
        gap, at = branch.link_gap(point, pair), f" at the {where}"
        why = touching(*pair, gap, branch.clearance, at, fault.has_elbow)
        return ArmNotClear(fault.branch, where, *pair, has_elbow=fault.has_elbow, why=why)

    def _not_clear_at(self, end: str, point: FloatArray, fault: Refutation) -> ArmNotClear:
        """Error for a fault at start or goal, a point (3,)."""
        arm, branch = self.problem.model.arm, self.arm_branch.name
        link, obstacle = _named(fault, arm)
        if obstacle is None:
            unreached = self.arm_branch.unreached(point)
            why = f"the arm {unreached} at the {end}" if unreached else ""
            return ArmNotClear(branch, end, has_elbow=arm.has_elbow, why=why)
        return ArmNotClear(branch, end, link, obstacle, has_elbow=arm.has_elbow)

    def _not_clear(self, where: str, why: str = "") -> ArmNotClear:
        has_elbow = self.problem.model.arm.has_elbow
        return ArmNotClear(self.arm_branch.name, where, has_elbow=has_elbow, why=why)


def _named(fault: Refutation, arm: AnyArm) -> tuple[str, int | str | None]:
    """Link and obstacle of a fault; the obstacle is None where the point is out of reach."""
    if fault.capsule < 0:
        return "", None
    return arm.capsule_links[fault.capsule], named(fault.obstacle, arm)


def _note(fault: Refutation, arm: AnyArm) -> str:
    link, obstacle = _named(fault, arm)
    if obstacle is None:
        why = "the arm would pass its reach or a joint limit"
        return f"On this curve {why}, so it follows the B-spline."
    name = f"obstacle {obstacle + 1}" if isinstance(obstacle, int) else f"the {obstacle}"
    why = f"the {link.replace('_', ' ')} may touch {name}"
    return f"On this curve {why}, so the arm follows the B-spline."
