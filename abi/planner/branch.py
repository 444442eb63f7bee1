"""A branch: one way to plan a scene, stage by stage.

The stages are the same for every branch. There are two kinds: the tool alone
(:mod:`abi.planner.tool_branch`), and the whole arm on one side of its elbow or from one start pose
(:mod:`abi.planner.whole_arm_branch`). To add a kind, write a child of :class:`Branch`, and have
:class:`abi.planner.arm_aware.ArmAware` try it, which decides in what order the branches of an arm
are tried.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace

from abi.curves.bspline import BSpline
from abi.curves.fit import Fit
from abi.curves.quadratic import Quadratic
from abi.planner.plan import Plan
from abi.planner.planning_problem import PlanningProblem
from abi.planner.stage_results import AnyFit, CurveName
from abi.search.graph import Graph
from abi.search.search import SearchResult
from abi.search.taut.taut_path import TautPath
from abi.tet_mesh.exclusion import FreeMesh

STAGE_NAMES = ("mesh", "graph", "search", "bspline", "quadratic", "timing", "arm")
"""Names that errors have for the stages, in order."""


class Branch(ABC):
    """One way to plan a scene: its stages, and the plan that they have given so far.

    Each abstract method is a stage, from the results of those before, and raises a StageError where
    there is no result. The other methods run them in their order and put each result into the plan
    as soon as it is there, so that a plan which ends early shows how far it came.

    Attributes:
        problem: what to plan.
        plan: what the stages have given so far.
    """

    problem: PlanningProblem
    plan: Plan

    @abstractmethod
    def free_mesh(self) -> FreeMesh:
        """Stage 1: the mesh without the nodes and edges that are not free."""

    @abstractmethod
    def graph(self, free: FreeMesh) -> Graph:
        """Stage 2: the graph from start to goal."""

    @abstractmethod
    def shortest(self, graph: Graph) -> tuple[Graph, SearchResult, float]:
        """Stage 3: the shortest path, by the search that the scene chooses.

        Returns:
            The graph without edges that turned out not to be free, the path in it, and the distance
            of the path to the obstacles, [unit].
        """

    @abstractmethod
    def searches(self, graph: Graph, path: SearchResult) -> tuple[SearchResult, ...]:
        """Stage 3: the search that found the path, and those it is compared with."""

    @abstractmethod
    def bspline(
        self, graph: Graph, path: SearchResult, away: float
    ) -> tuple[TautPath | None, Fit[BSpline]]:
        """Stages 3½ and 4: the path pulled taut, if that is asked for, and a B-spline near it.

        Args:
            graph, path, away: what :meth:`shortest` gave.
        """

    @abstractmethod
    def quadratic(self, bspline: Fit[BSpline]) -> Fit[Quadratic]:
        """Stage 5: the quadratic nearest to the B-spline."""

    @abstractmethod
    def followed(self, bspline: Fit[BSpline], quadratic: Fit[Quadratic]) -> CurveName:
        """Name of the curve that the arm follows."""

    @abstractmethod
    def motion(self, followed: AnyFit) -> Plan:
        """Stage 6: the plan with the motion of the arm along that curve, and how clear it is."""

    def find_path(self) -> float:
        """Stages 1 to 3: the free mesh, the graph and the shortest path; returns its cost.

        Raises:
            StageError: there is no path.
        """
        return self.search(self.build_graph())

    def build_graph(self) -> Graph:
        """Stages 1 and 2: the free mesh and the graph.

        Raises:
            StageError: start or goal cannot be used.
        """
        free = self.free_mesh()
        self.plan = replace(self.plan, free=free)
        graph = self.graph(free)
        self.plan = replace(self.plan, graph=graph)
        return graph

    def search(self, graph: Graph) -> float:
        """Stage 3: the shortest path in the graph; returns its cost.

        Raises:
            StageError: there is no path.
        """
        graph, path, away = self.shortest(graph)
        self.plan = replace(self.plan, graph=graph, path=path, path_clearance=away)
        return path.cost

    def fit_curves(self) -> AnyFit:
        """Stages 4 and 5: the B-spline, the quadratic, and which of them the arm follows.

        Raises:
            StageError: there is no curve to follow.
        """
        graph, path, away = self.plan.graph, self.plan.path, self.plan.path_clearance
        assert graph is not None
        assert path is not None
        self.plan = replace(self.plan, searches=self.searches(graph, path))
        taut, bspline = self.bspline(graph, path, away)
        self.plan = replace(self.plan, taut=taut, bspline=bspline)
        quadratic = self.quadratic(bspline)
        self.plan = replace(self.plan, quadratic=quadratic)
        followed = self.followed(bspline, quadratic)
        self.plan = replace(self.plan, followed=followed)
        return bspline if followed == "bspline" else quadratic

    def move_arm(self, followed: AnyFit) -> Plan:
        """Stage 6: the plan with the arm's motion along the curve that it follows.

        Raises:
            StageError: there is none on this branch.
        """
        self.plan = self.motion(followed)
        return self.plan
