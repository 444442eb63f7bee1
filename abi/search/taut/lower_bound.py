"""Proven lower bounds of the length of any curve that keeps the clearance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from abi import arguments
from abi.arrays import FloatArray
from abi.curves.clearance.curve_clearance import ROUNDING
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import Vec3
from abi.scene.settings import Workspace
from abi.search.taut import geodesic_kernels as kernels

_ROUND_DOWN = 1 - 2.0**-51  # a length rounded to nearest is no bound
_ROUNDING = 2.0**-45
"""Rounding error of a length around a solid, over the coordinates."""
_SAMPLES = 65  # of the straight line, for balls that bound


@dataclass(frozen=True)
class Bound:
    """Lower bound of the length of curves that keep the clearance.

    Attributes:
        length: the bound, [unit].
        exact: whether it is proven that some curve has this length: the continuous optimum.
    """

    length: float
    exact: bool


def lower_bound(
    start: Vec3, goal: Vec3, obstacles: ObstacleSet, clearance: float, workspace: Workspace
) -> Bound:
    """Compute a lower bound of the length of all curves from start to goal that keep the clearance.

    If the straight line is clear it is the bound, which is exact. Otherwise the bound is the
    greatest of those for single obstacles, since a curve has to keep clear of each:

    - sphere: tangents and an arc of a great circle, exact;
    - box: exact, unless a path by a rounded corner might be shorter than those by edges and faces;
    - capsule: exact if the shortest path goes past its side and one past an end is proven longer;
    - cylinder: the same, or the bounds of a box and of balls inside it;
    - triangle mesh: the bound of a ball inside it, at the straight line's deepest point.

    Among several obstacles it stays exact if the others lie outside the ellipsoid that contains all
    paths of that length, and if the obstacle with its clearance lies in the workspace: then so does
    the shortest path past it, which stays in the convex hull of obstacle, start and goal. A curve
    that misses the clearance by up to 1e-9 counts as clear.

    Args:
        start: first point of the curves, [unit], world.
        goal: last point, [unit], world.
        obstacles: the solids.
        clearance: distance to keep from each, [unit], at least 0.
        workspace: the box that start and goal are in.
    """
    clearance = arguments.number("clearance", clearance, 0.0, math.inf)
    margin = max(clearance - ROUNDING, 0.0)
    ends = np.array([start, goal])
    straight = _ROUND_DOWN * math.dist(start, goal)
    lengths, exact = kernels.solid_bounds(obstacles.packed, margin, *map(tuple, ends.tolist()))
    # of the primitives, then of the meshes
    bounds = np.append(lengths, np.zeros(len(obstacles.meshes)))
    for number, mesh, _ in obstacles.near_meshes(ends[:1], ends[1:], np.array([margin])):
        row = len(lengths) + obstacles.mesh_numbers.searchsorted(number)
        bounds[row] = _mesh_bound(mesh, ends, margin)
    longest = float(bounds.max(initial=0.0))
    if longest == 0:
        return Bound(straight, True)
    low, high = (corners[obstacles.rows] for corners in obstacles.bounds)
    size = float(np.abs(ends).max() + max(np.abs(low).max(), np.abs(high).max())) + clearance
    length = max(longest - _ROUNDING * size, straight)
    best = int(bounds.argmax())
    if best >= len(exact) or not exact[best]:
        return Bound(length, False)
    inside = (low[best] - margin >= workspace.min).all() and (
        high[best] + margin <= workspace.max
    ).all()
    # no path of that length leaves the ellipsoid around start and goal
    reach = np.linalg.norm(high - low, axis=1) / 2 + margin
    by_centre = np.linalg.norm(ends - ((low + high) / 2)[:, None], axis=2).sum(axis=1)
    beyond = by_centre - 2 * reach > length
    beyond[best] = True
    return Bound(length, bool(inside and beyond.all()))


def _mesh_bound(mesh: MeshShape, ends: FloatArray, clearance: float) -> float:
    """Bound by a ball in the widened mesh around a point of the straight line, [unit].

    0 where the mesh does not block the line.
    """
    share = np.linspace(0, 1, _SAMPLES)[:, None]
    line = ends[:1] + share * (ends[1:] - ends[:1])
    lower, upper = mesh.distance_bounds(line)
    # of the others, only the deepest counts
    exact = lower <= upper.min()
    exact[[0, -1]] |= lower[[0, -1]] < clearance
    distance = np.full(_SAMPLES, math.inf)
    distance[exact] = mesh.signed_distance(line[exact])
    k = int(distance.argmin())
    if distance[k] >= clearance and (
        mesh.segment_distance(ends[:1], ends[1:], clearance)[0] >= clearance
    ):
        return 0.0
    if distance[[0, -1]].min() < clearance:
        return math.dist(*ends)
    (a, b, c), (d, e, f) = (ends - line[k]).tolist()
    return float(kernels.around_ball(clearance - float(distance[k]), (a, b, c), (d, e, f)))
