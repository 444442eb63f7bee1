"""Path and curves of a tool whose whole arm keeps clear, on one elbow branch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from abi.arm.arm_sight import ArmSight
from abi.arrays import FloatArray, read_only
from abi.curves.bspline import BSpline, clamped
from abi.curves.control_points import place_control_points
from abi.curves.fit import Fit, proven_fit
from abi.curves.fit_bspline import fit as fit_bspline
from abi.obstacles.obstacle_set import ObstacleSet
from abi.search.graph import Graph
from abi.search.search import SearchResult
from abi.search.without_edges import without_edges
from abi.taut.taut_path import TautPath, taut

_MOST_REPAIRS = 12
_ROUNDS = 3
_STEPS = (0.8, 0.3, 0.08)
_REFINEMENTS = 30
_SETTLED = 1e-3
_CUT = (0.45, 0.2)


@dataclass(frozen=True, eq=False)
class ArmGraphPath:
    """A path along edges that the arm follows clear of everything.

    Attributes:
        graph: without the edges that were found not to be clear.
        path: of the graph.
    """

    graph: Graph
    path: SearchResult


def search_clear(
    graph: Graph, sight: ArmSight, search: Callable[[Graph], SearchResult]
) -> ArmGraphPath | None:
    """Search until all edges of the path are clear for the arm; None where it does not end.

    Raises:
        StageError: there is no path.
    """
    for _ in range(_MOST_REPAIRS):
        path = search(graph)
        vertices = path.vertices.tolist()
        shut = [
            (vertices[k], vertices[k + 1])
            for k in range(len(vertices) - 1)
            if sight.leg_refutation(path.points[k : k + 2]) is not None
        ]
        if not shut:
            return ArmGraphPath(graph, path)
        graph = without_edges(graph, shut)
    return None


def pull_clear(
    graph: Graph, obstacles: ObstacleSet, margin: float, path: SearchResult, sight: ArmSight
) -> TautPath:
    """Pull a path taut as far as tool and arm stay clear.

    The taut path of the tool alone is taken where the arm is clear along it. Else vertices that are
    not needed are dropped, others moved towards the chord of their neighbours, and corners cut,
    until the length settles.

    Args:
        graph: the graph of the path.
        obstacles: the solids.
        margin: distance that the tool keeps from them, [unit].
        path: clear for the arm.
        sight: the arm.
    """
    of_tool = taut(graph, obstacles, margin, path)
    if sight.leg_refutation(of_tool.points) is None:
        return of_tool
    ends = obstacles.signed_distance(path.points[[0, -1]]).min()
    free = _Legs(obstacles, min(margin, float(ends) - 1e-9), sight)
    points = _shortcuts(path.points, free)
    for _ in range(_ROUNDS):
        before = _length(points)
        points = _cut_corners(_moved(points, free), free)
        if _length(points) > (1 - _SETTLED) * before:
            break
    return TautPath(read_only(points), _length(points), obstacles.polyline_clearance(points))


def fit_clear(
    points: FloatArray,
    degree: int,
    obstacles: ObstacleSet,
    clearance: float,
    sight: ArmSight,
) -> Fit[BSpline] | None:
    """B-spline near a path that is clear for tool and arm; None where none was found.

    The control polygon is halved where the arm is not clear, until the curve is near enough to the
    path there.

    Args:
        points: the path (k, 3), clear for the arm, [unit], world.
        degree: of the curve.
        obstacles: to keep clear of.
        clearance: distance to keep from them, [unit].
        sight: the arm.
    """
    fitted = fit_bspline(points, degree, obstacles, clearance, True)
    if fitted.holds and sight.refutation(fitted.curve) is None:
        return fitted
    # its control points may have been pushed off the path, along which alone the arm is clear
    control, added = place_control_points(points, degree, obstacles, clearance)
    spline = clamped(control, degree, added)
    for _ in range(_REFINEMENTS):
        fault = sight.refutation(spline)
        if fault is None:
            fitted = proven_fit(spline, spline.extent, obstacles, clearance)
            if fitted.holds:
                return fitted
        spline = _refined(spline, fitted.clearance.at if fault is None else fault.parameter)
    return None


def _refined(spline: BSpline, parameter: float) -> BSpline:
    """Halve the edges of the control polygon that the curve depends on at a parameter."""
    p, n = spline.degree, len(spline.control_points)
    at = int(np.searchsorted(spline.knots, parameter, side="right")) - 1
    at = min(max(at, p), n - 1)
    edges = np.arange(at - p, at)
    points = spline.control_points
    lengths = np.linalg.norm(points[edges + 1] - points[edges], axis=1)
    edges = edges[lengths > 0]
    middles = (points[edges] + points[edges + 1]) / 2
    return clamped(
        np.insert(points, edges + 1, middles, axis=0),
        p,
        np.insert(spline.added, edges + 1, True),
        np.insert(spline.pushed, edges + 1, False),
    )


@dataclass(frozen=True, eq=False)
class _Legs:
    """Legs that tool and arm may run along."""

    obstacles: ObstacleSet
    margin: float
    sight: ArmSight

    def clear(self, *points: FloatArray) -> bool:
        """Whether the legs between points (3,) are."""
        polyline = np.stack(points)
        if self.obstacles.polyline_clearance(polyline) < self.margin:
            return False
        return self.sight.leg_refutation(polyline) is None


def _shortcuts(points: FloatArray, free: _Legs) -> FloatArray:
    """From each vertex straight to the farthest in sight, found by doubling, then halving."""
    kept, i, last = [0], 0, len(points) - 1
    while i < last:
        near, step = i + 1, 2
        while i + step <= last and free.clear(points[i], points[i + step]):
            near, step = i + step, 2 * step
        far = min(i + step, last)
        while far > near + 1:
            middle = (near + far) // 2
            if free.clear(points[i], points[middle]):
                near = middle
            else:
                far = middle
        if near < last and far == last and free.clear(points[i], points[last]):
            near = last
        i = near
        kept.append(i)
    return points[kept]


def _moved(points: FloatArray, free: _Legs) -> FloatArray:
    """Vertices dropped, or moved towards the chord of their neighbours."""
    kept = [points[0]]
    for k in range(1, len(points) - 1):
        a, vertex, b = kept[-1], points[k], points[k + 1]
        if free.clear(a, b):
            continue
        chord = b - a
        share = np.clip((vertex - a) @ chord / max(float(chord @ chord), 1e-300), 0, 1)
        foot = a + share * chord
        moves = (vertex + step * (foot - vertex) for step in _STEPS)
        kept.append(next((at for at in moves if free.clear(a, at, b)), vertex))
    return np.array([*kept, points[-1]])


def _cut_corners(points: FloatArray, free: _Legs) -> FloatArray:
    """Bends cut where that is clear."""
    kept = [points[0]]
    for k in range(1, len(points) - 1):
        vertex = points[k]
        back, ahead = points[k - 1] - vertex, points[k + 1] - vertex
        for share in _CUT:
            first, last = vertex + share * back, vertex + share * ahead
            if free.clear(first, last):
                kept += [first, last]
                break
        else:
            kept.append(vertex)
    return np.array([*kept, points[-1]])


def _length(points: FloatArray) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
