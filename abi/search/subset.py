"""Subset of a mesh to draw if all of it would be too much."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
import scipy
from numpy.typing import NDArray

from abi import arguments, progress
from abi.arrays import BoolArray, FloatArray, IntArray, read_only
from abi.errors import ArgumentError
from abi.obstacles.obstacle_set import Obstacles, ObstacleSet
from abi.search.graph import Graph
from abi.tet_mesh.exclusion import FreeMesh

_Rows = TypeVar("_Rows", bound=NDArray[Any])

VIEWS = ("near", "slice_x", "slice_y", "slice_z", "surface")

_CELLS = 40  # along the longest side: how finely "near" is told
_EDGES_A_NODE = 7
_SLICE = 0.75  # of the longest edge: half the thickness of a slice


def fits(free: FreeMesh, budget: int) -> bool:
    """Check whether the whole mesh has no more than about ``budget`` edges."""
    return _EDGES_A_NODE * free.nodes <= budget


def edges_in_all(free: FreeMesh, graph: Graph | None) -> int:
    """Number of edges from which :func:`subset` chooses."""
    return len(_free_edges(free)) if graph is None else graph.edge_count


def _free_edges(free: FreeMesh) -> IntArray:
    """Edges of the mesh (e, 2) between nodes that are not excluded; not tested themselves."""
    return free.mesh.edges[~free.excluded[free.mesh.edges].any(axis=1)]


def subset(
    free: FreeMesh,
    graph: Graph | None,
    obstacles: Obstacles,
    path_points: FloatArray,
    view: str,
    budget: int,
) -> tuple[FloatArray, IntArray, FloatArray]:
    """Choose at most ``budget`` edges, those nearest to path and obstacles first.

    Args:
        free: the mesh and what is excluded of it.
        graph: its graph; None if there is none yet, then edges are not tested.
        obstacles: those that the mesh keeps clear of.
        path_points: (n, 3), n >= 1, points near which the mesh should be seen, [unit], world.
        view: ``near``: all, or what is near; ``slice_x`` and the like: one layer of nodes across
            that axis, through the first obstacle; ``surface``: nodes at the sides of the workspace
            and at the obstacles.
        budget: largest number of edges.

    Returns:
        Free nodes (k, 3), [unit], world; edges (e, 2) between these; excluded nodes (m, 3).

    Raises:
        CancelledError: it is not wanted any more.
    """
    path_points = arguments.points("path_points", path_points)
    if not len(path_points):
        raise ArgumentError("path_points", [], "one point or more")
    points = free.mesh.points if graph is None else graph.points
    gone = np.zeros(len(points), dtype=np.bool_)
    gone[: len(free.excluded)] = free.excluded
    seen = _seen(view, free, points, obstacles)
    if np.count_nonzero(seen & ~gone) * _EDGES_A_NODE > budget:
        seen &= _near(points, seen & ~gone, path_points, obstacles, budget // _EDGES_A_NODE)
    progress.check()
    if graph is None:
        edges = _free_edges(free)
        shown = edges[seen[edges].all(axis=1)][:budget]
    else:
        shown = graph.edges_among(seen)[:budget]
    progress.check()
    used = np.flatnonzero(seen & ~gone)
    place = np.zeros(len(points), dtype=np.int32)
    place[used] = np.arange(len(used))
    excluded = evenly(np.flatnonzero(seen & gone), budget // _EDGES_A_NODE)
    return read_only(points[used]), read_only(place[shown]), read_only(points[excluded])


def _seen(view: str, free: FreeMesh, points: FloatArray, obstacles: Obstacles) -> BoolArray:
    """Flags of the nodes in the view, however many."""
    low, high = free.mesh.points.min(axis=0), free.mesh.points.max(axis=0)
    if view == "near":
        return np.ones(len(points), dtype=np.bool_)
    if view == "surface":
        seen = ((points == low) | (points == high)).any(axis=1)
        across = free.mesh.edges[free.excluded[free.mesh.edges].sum(axis=1) == 1]
        seen[across] = True
        return np.asarray(seen)
    axis = VIEWS.index(view) - 1
    box = obstacles[0].bounds() if obstacles else (low, high)
    middle = (box[0][axis] + box[1][axis]) / 2
    half = _SLICE * float(free.mesh.lengths.max(initial=0.0))
    return np.asarray(np.abs(points[:, axis] - middle) <= half)


def _near(
    points: FloatArray, seen: BoolArray, path_points: FloatArray, obstacles: Obstacles, most: int
) -> BoolArray:
    """Flags of about ``most`` of the nodes in view, in the cells nearest to path and obstacles."""
    low, high = points.min(axis=0), points.max(axis=0)
    side = float((high - low).max()) / _CELLS
    counts = np.maximum(np.ceil((high - low) / side).astype(int), 1)
    place = np.minimum(((points - low) / side).astype(np.int32), counts - 1)
    cell = np.ravel_multi_index(tuple(place.T), tuple(counts))
    progress.check()
    centres = low + side * (np.indices(tuple(counts)).reshape(3, -1).T + 0.5)
    away = scipy.spatial.cKDTree(_polyline_samples(path_points, side)).query(centres)[0]
    np.minimum(away, ObstacleSet(obstacles).boxed.signed_distance(centres).clip(0), out=away)
    order = away.argsort(kind="stable")
    filled = np.cumsum(np.bincount(cell[seen], minlength=len(centres))[order])
    chosen = np.zeros(len(centres), dtype=np.bool_)
    chosen[order[: max(int(np.searchsorted(filled, most, side="right")), 1)]] = True
    return np.asarray(chosen[cell])


def evenly(rows: _Rows, most: int) -> _Rows:
    """At most ``most`` rows of an array, evenly thinned."""
    return rows if len(rows) <= most else rows[:: -(-len(rows) // most)]  # type: ignore[return-value]


def _polyline_samples(points: FloatArray, step: float) -> FloatArray:
    """Places (m, 3) along a polyline (n, 3), no farther apart than ``step``, [unit]."""
    if len(points) < 2:
        return points
    legs = np.linalg.norm(np.diff(points, axis=0), axis=1)
    parts = [
        np.linspace(a, b, int(leg / step) + 2)
        for a, b, leg in zip(points[:-1], points[1:], legs, strict=True)
    ]
    return np.concatenate(parts)
