"""Path and curves along which the whole arm keeps clear, on one branch."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from abi.arm_planning.branch.arm_branch import ArmBranch
from abi.arm_planning.exclusion.arm_path_kernels import ROUNDS, pull, pulled
from abi.arrays import FloatArray, flat, read_only
from abi.curves.bspline import BSpline, clamped
from abi.curves.control_points import place_control_points
from abi.curves.fit import Fit, proven_fit
from abi.curves.fit_bspline import fit as fit_bspline
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import Vec3
from abi.search.graph import Graph
from abi.search.search import SearchResult
from abi.search.taut.taut_path import TautPath, polyline_length
from abi.search.taut.tighten_near_meshes import clear_of
from abi.search.without_edges import without_edges

_MOST_REPAIRS = 60
REFINEMENTS = 30
"""Times that a curve is refined, at most, unless it is said how often."""
_ROUNDING = 1e-9  # [unit]


def search_clear(
    graph: Graph, branch: ArmBranch, search: Callable[[Graph], SearchResult]
) -> tuple[Graph, SearchResult] | None:
    """Search until all edges of the path are clear for the arm; None if that takes too long.

    Returns:
        The graph without the edges that were found not to be clear, and its path.

    Raises:
        StageError: there is no path.
    """
    for _ in range(_MOST_REPAIRS):
        path = search(graph)
        vertices = path.vertices.tolist()
        shut = [
            (vertices[k], vertices[k + 1])
            for k in np.flatnonzero(~branch.clear_segments(path.points)).tolist()
        ]
        if not shut:
            return graph, path
        graph = without_edges(graph, shut)
    return None


def _is_clear(around: tuple[ObstacleSet, float, ArmBranch], points: tuple[Vec3, ...]) -> bool:
    """Check whether segments are clear for the tool and an arm that the kernels do not support."""
    obstacles, margin, branch = around
    polyline = np.array(points)
    if obstacles.polyline_clearance(polyline) < margin:
        return False
    return branch.polyline_refutation(polyline) is None


def pull_clear(
    of_tool: TautPath,
    obstacles: ObstacleSet,
    margin: float,
    path: SearchResult,
    branch: ArmBranch,
    rounds: int = ROUNDS,
) -> TautPath:
    """Pull a path taut while tool and arm stay clear.

    If the arm is clear along the taut path of the tool alone, that is taken. Otherwise vertices
    that are not needed are dropped, the others moved towards the chord of their neighbours, and
    corners cut, until the length settles.

    Args:
        of_tool: the path pulled taut for the tool alone.
        obstacles: the solids.
        margin: distance that the tool keeps from them, [unit].
        path: clear for the arm.
        branch: the arm.
        rounds: in which an arm that the kernels do not know does so, at most.
    """
    if branch.clear_segments(of_tool.points).all():
        return of_tool
    ends = obstacles.signed_distance(path.points[[0, -1]], margin + 2 * _ROUNDING).min()
    margin = min(margin, float(ends) - _ROUNDING)
    if branch.segments is None:
        vertices = [(x, y, z) for x, y, z in path.points.tolist()]
        points = np.array(pull(vertices, (obstacles, margin, branch), _is_clear, rounds))
    else:
        points = np.asarray(pulled(flat(path.points), clear_of(obstacles, margin), branch.segments))
        points = points.reshape(-1, 3)
    return TautPath(
        read_only(points), polyline_length(points), obstacles.polyline_clearance(points)
    )


def fit_clear(
    points: FloatArray,
    degree: int,
    obstacles: ObstacleSet,
    clearance: float,
    path_clearance: float,
    branch: ArmBranch,
    refinements: int = REFINEMENTS,
) -> Fit[BSpline] | None:
    """Fit a B-spline that is clear for tool and arm to a path; None if none was found.

    Edges of the control polygon are halved where the arm is not clear, until the curve is near
    enough to the path there.

    Args:
        points: the path (k, 3), clear for the arm, [unit], world.
        degree: of the curve.
        obstacles: to keep clear of.
        clearance: distance to keep from them, [unit].
        path_clearance: the path's own, [unit].
        branch: the arm.
        refinements: how often they are halved, at most.
    """
    fitted = fit_bspline(points, degree, obstacles, clearance, True, path_clearance)
    spline, fault = fitted.curve, None
    if fitted.holds:
        fault = branch.refutation(spline)
        if fault is None:
            return fitted
    if fault is None or spline.moved:
        # its control points may have been pushed off the path, along which alone the arm is clear
        control, added = place_control_points(points, degree, obstacles, clearance)
        spline = clamped(control, degree, added)
        fault = branch.refutation(spline)
    for _ in range(refinements):
        if fault is None:
            fitted = proven_fit(spline, spline.extent, obstacles, clearance)
            if fitted.holds:
                return fitted
        spline = _refined(spline, fitted.clearance.at if fault is None else fault.parameter)
        fault = branch.refutation(spline)
    return None


def _refined(spline: BSpline, parameter: float) -> BSpline:
    """Halve the edges of the control polygon that the curve depends on at a parameter."""
    p, n = spline.degree, len(spline.control_points)
    at = int(np.searchsorted(spline.knots, parameter, side="right")) - 1
    at = min(max(at, p), n - 1)
    return spline.refined(np.arange(at - p, at))
