"""A branch: one way to plan a scene, stage by stage, and what the stages give.

The pipeline (:mod:`abi.planner.pipeline`) runs the same six stages for every branch. There are two
kinds: the tool alone (:mod:`abi.planner.tool_branch`), and the whole arm on one side of its elbow
or from one start pose (:mod:`abi.planner.whole_arm_branch`). To add a kind, write a class with the
methods of :class:`Branch`, and have :class:`abi.planner.arm_aware.ArmAware` try it, which decides
in what order the branches of an arm are tried.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple, Protocol, TypeAlias

from abi.arm_planning.joint_search.search_joints import JointSearch
from abi.arm_planning.motion.arm_clearance import ArmClearance, is_clear
from abi.arm_planning.motion.trajectory import ArmMotion
from abi.curves.bspline import BSpline
from abi.curves.curve import ArcLength
from abi.curves.fit import Fit
from abi.curves.quadratic import Quadratic
from abi.curves.timed_profile import PathProfile
from abi.search.graph import Graph
from abi.search.search import SearchResult
from abi.search.taut.lower_bound import Bound
from abi.search.taut.taut_path import TautPath
from abi.tet_mesh.exclusion import FreeMesh

AnyFit: TypeAlias = Fit[BSpline] | Fit[Quadratic]
CurveName: TypeAlias = Literal["bspline", "quadratic"]


class ShortestPath(NamedTuple):
    """Result of stage 3.

    Attributes:
        graph: in which it was found: that of stage 2, without edges that turned out not to be free.
        path: result of the search that the scene chooses.
        clearance: distance of the path to the obstacles, [unit].
    """

    graph: Graph
    path: SearchResult
    clearance: float


class SplineOnPath(NamedTuple):
    """Result of stages 3½ and 4.

    Attributes:
        taut: the path pulled taut; None if the scene does not ask for that.
        fit: the B-spline and its clearance.
        arc: its arc length.
    """

    taut: TautPath | None
    fit: Fit[BSpline]
    arc: ArcLength


class QuadraticOnSpline(NamedTuple):
    """Result of stage 5: the quadratic and its clearance, and its arc length."""

    fit: Fit[Quadratic]
    arc: ArcLength


class TimedMotion(NamedTuple):
    """Result of stage 6: the motion along the curve, the joints over time, and their clearance."""

    profile: PathProfile
    motion: ArmMotion
    clearance: ArmClearance

    @property
    def is_clear(self) -> bool:
        """Whether the whole arm is proven clear all along it, in reach and range."""
        return is_clear(self.motion, self.clearance)


class Branch(Protocol):
    """One way to plan a scene; each method is a stage, from the results of those before.

    All raise a StageError where there is no result.
    """

    def free_mesh(self) -> FreeMesh:
        """Stage 1: the mesh without the nodes and edges that are not free."""

    def graph(self, free: FreeMesh) -> Graph:
        """Stage 2: the graph from start to goal."""

    def shortest(self, graph: Graph) -> ShortestPath:
        """Stage 3: the shortest path, by the search that the scene chooses."""

    def searches(self, shortest: ShortestPath) -> tuple[SearchResult, ...]:
        """Stage 3: that search and those it is compared with."""

    def bspline(self, shortest: ShortestPath) -> SplineOnPath:
        """Stages 3½ and 4: the path pulled taut, and a B-spline near it."""

    def quadratic(self, bspline: SplineOnPath) -> QuadraticOnSpline:
        """Stage 5: the quadratic nearest to the B-spline."""

    def followed(self, bspline: SplineOnPath, quadratic: QuadraticOnSpline) -> CurveName:
        """Name of the curve that the arm follows."""

    def motion(self, followed: SplineOnPath | QuadraticOnSpline) -> TimedMotion:
        """Stage 6: the motion of the arm along that curve."""


@dataclass(slots=True, eq=False)
class BranchResults:
    """What the stages have given for a branch so far; the attributes are those of a Plan.

    What was not reached is None, or empty.
    """

    free: FreeMesh | None = None
    graph: Graph | None = None
    searches: tuple[SearchResult, ...] = ()
    path: SearchResult | None = None
    path_clearance: float = math.inf
    optimum: Bound | None = None
    taut: TautPath | None = None
    bspline: Fit[BSpline] | None = None
    bspline_arc: ArcLength | None = None
    quadratic: Fit[Quadratic] | None = None
    quadratic_arc: ArcLength | None = None
    followed: CurveName | None = None
    profile: PathProfile | None = None
    motion: ArmMotion | None = None
    arm_clearance: ArmClearance | None = None
    tool_only: AnyFit | None = None
    joint_search: JointSearch | None = None

    @property
    def followed_fit(self) -> AnyFit | None:
        """The curve that the arm follows."""
        return self.bspline if self.followed == "bspline" else self.quadratic

    def for_arm(self) -> BranchResults:
        """Results to begin with on an arm's branch, of those of the tool alone."""
        return BranchResults(optimum=self.optimum, tool_only=self.followed_fit)
