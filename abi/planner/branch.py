"""A branch: one way to plan a scene, stage by stage.

The stages are the same for every branch. There are two kinds: the tool alone
(:mod:`abi.planner.tool_branch`), and the whole arm on one side of its elbow or from one start pose
(:mod:`abi.planner.whole_arm_branch`). To add a kind, write a class with the methods of
:class:`Branch`, and have :class:`abi.planner.arm_aware.ArmAware` try it, which decides in what
order the branches of an arm are tried.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

from abi.curves.bspline import BSpline
from abi.curves.fit import Fit
from abi.curves.quadratic import Quadratic
from abi.planner.plan import Plan
from abi.planner.stage_results import AnyFit, CurveName, ShortestPath, TimedMotion
from abi.search.graph import Graph
from abi.search.search import SearchResult
from abi.search.taut.taut_path import TautPath
from abi.tet_mesh.exclusion import FreeMesh

STAGE_NAMES = ("mesh", "graph", "search", "bspline", "quadratic", "timing", "arm")
"""Names that errors have for the stages, in order."""


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

    def bspline(self, shortest: ShortestPath) -> tuple[TautPath | None, Fit[BSpline]]:
        """Stages 3½ and 4: the path pulled taut, if that is asked for, and a B-spline near it."""

    def quadratic(self, bspline: Fit[BSpline]) -> Fit[Quadratic]:
        """Stage 5: the quadratic nearest to the B-spline."""

    def followed(self, bspline: Fit[BSpline], quadratic: Fit[Quadratic]) -> CurveName:
        """Name of the curve that the arm follows."""

    def motion(self, followed: AnyFit) -> TimedMotion:
        """Stage 6: the motion of the arm along that curve."""


class BranchRun:
    """Runs the stages of one branch in their order, and collects their results in a plan.

    The plan has each result as soon as it is there, so that one which ends early shows how far it
    came.

    Attributes:
        branch: the branch.
        plan: what its stages have given so far.
    """

    def __init__(self, branch: Branch, plan: Plan) -> None:
        """Begin with ``plan``, in which the results of the stages that run are replaced."""
        self.branch, self.plan = branch, plan

    def find_path(self) -> ShortestPath:
        """Stages 1 to 3: the free mesh, the graph and the shortest path.

        Raises:
            StageError: there is no path.
        """
        return self.search(self.build_graph())

    def build_graph(self) -> Graph:
        """Stages 1 and 2: the free mesh and the graph.

        Raises:
            StageError: start or goal cannot be used.
        """
        free = self.branch.free_mesh()
        self.plan = replace(self.plan, free=free)
        graph = self.branch.graph(free)
        self.plan = replace(self.plan, graph=graph)
        return graph

    def search(self, graph: Graph) -> ShortestPath:
        """Stage 3: the shortest path in the graph.

        Raises:
            StageError: there is no path.
        """
        found = self.branch.shortest(graph)
        self.plan = replace(
            self.plan, graph=found.graph, path=found.path, path_clearance=found.clearance
        )
        return found

    def fit_curves(self, path: ShortestPath) -> AnyFit:
        """Stages 4 and 5: the B-spline, the quadratic, and which of them the arm follows.

        Raises:
            StageError: there is no curve to follow.
        """
        self.plan = replace(self.plan, searches=self.branch.searches(path))
        taut, bspline = self.branch.bspline(path)
        self.plan = replace(self.plan, taut=taut, bspline=bspline)
        quadratic = self.branch.quadratic(bspline)
        self.plan = replace(self.plan, quadratic=quadratic)
        followed = self.branch.followed(bspline, quadratic)
        self.plan = replace(self.plan, followed=followed)
        return bspline if followed == "bspline" else quadratic

    def move_arm(self, followed: AnyFit) -> TimedMotion:
        """Stage 6: the arm's motion along the curve that it follows.

        Raises:
            StageError: there is none on this branch.
        """
        moved = self.branch.motion(followed)
        profile, motion, clearance = moved
        self.plan = replace(self.plan, profile=profile, motion=motion, arm_clearance=clearance)
        return moved
