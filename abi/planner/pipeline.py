"""The six stages of the method, in their order, for any branch.

What each stage does on a branch is told by :class:`abi.planner.branch.Branch`. Results are kept as
they come, so that a plan which ends early shows how far it came.
"""

from __future__ import annotations

from abi.planner.branch import (
    Branch,
    BranchResults,
    QuadraticOnSpline,
    ShortestPath,
    SplineOnPath,
    TimedMotion,
)
from abi.search.graph import Graph


def find_path(branch: Branch, results: BranchResults) -> ShortestPath:
    """Stages 1 to 3: the free mesh, the graph and the shortest path.

    Raises:
        StageError: there is no path; ``results`` has what was reached.
    """
    results.free = branch.free_mesh()
    results.graph = branch.graph(results.free)
    return seek_path(branch, results.graph, results)


def seek_path(branch: Branch, graph: Graph, results: BranchResults) -> ShortestPath:
    """Stage 3: the shortest path in the graph.

    Raises:
        StageError: there is no path; ``results`` has what was reached.
    """
    found = branch.shortest(graph)
    results.graph, results.path, results.path_clearance = found
    return found


def follow_path(branch: Branch, path: ShortestPath, results: BranchResults) -> TimedMotion:
    """Stages 4 to 6: the curves near the path, and the arm's motion along one of them.

    Raises:
        StageError: there is no curve or no motion; ``results`` has what was reached.
    """
    return move_arm(branch, fit_curves(branch, path, results), results)


def fit_curves(
    branch: Branch, path: ShortestPath, results: BranchResults
) -> SplineOnPath | QuadraticOnSpline:
    """Stages 4 and 5: the B-spline, the quadratic, and which of them the arm follows.

    Raises:
        StageError: there is no curve to follow; ``results`` has what was reached.
    """
    results.searches = branch.searches(path)
    bspline = branch.bspline(path)
    results.taut, results.bspline, results.bspline_arc = bspline
    quadratic = branch.quadratic(bspline)
    results.quadratic, results.quadratic_arc = quadratic
    results.followed = branch.followed(bspline, quadratic)
    return bspline if results.followed == "bspline" else quadratic


def move_arm(
    branch: Branch, followed: SplineOnPath | QuadraticOnSpline, results: BranchResults
) -> TimedMotion:
    """Stage 6: the arm's motion along the curve that it follows.

    Raises:
        StageError: there is none on this branch.
    """
    moved = branch.motion(followed)
    results.profile, results.motion, results.arm_clearance = moved
    return moved
