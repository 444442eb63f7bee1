"""How short a curve can be at best: proven bounds of the length of any curve that keeps clear."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from abi.arrays import FloatArray
from abi.clearance.curve_clearance import ROUNDING
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import Vec3
from abi.scene.scene import Workspace
from abi.taut import geodesic_kernels as kernels

_DOWN = 1 - 1e-15  # for what is rounded to nearest is no bound
_SAMPLES = 65  # of the straight line, for balls that bound


@dataclass(frozen=True)
class Bound:
    """A length that no curve which keeps clear goes below.

    Attributes:
        length: the bound, [unit].
        exact: whether it is proven that some curve has this length: the continuous optimum.
    """

    length: float
    exact: bool


def lower_bound(
    start: Vec3, goal: Vec3, obstacles: ObstacleSet, clearance: float, workspace: Workspace
) -> Bound:
    """Bound from below the length of all curves from start to goal that keep the clearance.

    The straight line where it is clear, which is exact. Else the greatest of the bounds for single
    obstacles, for a curve has to keep clear of each:

    - sphere: tangents and an arc of a great circle, exact;
    - box: exact, unless a way by a rounded corner might be shorter than those by edges and faces;
    - capsule: exact where the shortest way goes by its side and a way by an end is proven longer;
    - cylinder: the same, or the bounds of a box and of balls within it;
    - triangle mesh: the bound of a ball within it, at the straight line's deepest place.

    It stays exact among several obstacles when the others lie beyond the ellipsoid that holds all
    ways of that length. And only where the obstacle with its clearance lies in the workspace: then
    so does the shortest way past it, which stays in the convex hull of obstacle, start and goal. A
    curve counts as clear that misses the clearance by up to 1e-9.

    Args:
        start: start, [unit], world.
        goal: goal, [unit], world.
        obstacles: the solids.
        clearance: distance to keep from each, [unit], at least 0.
        workspace: the box that start and goal are in.
    """
    asked = max(clearance - ROUNDING, 0.0)
    ends = np.array([start, goal])
    straight = _DOWN * math.dist(start, goal)
    lengths, exact = kernels.around(obstacles.packed, asked, *map(tuple, ends.tolist()))
    ways = [(float(length), bool(whether)) for length, whether in zip(lengths, exact, strict=True)]
    ways += [(_past(surface, ends, asked), False) for surface in obstacles.meshes]
    longest = max((length for length, _ in ways), default=0.0)
    if longest == 0:
        return Bound(straight, True)
    length = max(_DOWN * longest, straight)
    best = next(k for k, way in enumerate(ways) if way[0] == longest)
    if not ways[best][1]:
        return Bound(length, False)
    # the ways are those past the primitives, then those past the meshes
    order = np.concatenate([obstacles.primitive_numbers, obstacles.mesh_numbers])
    low, high = (corners[order] for corners in obstacles.bounds)
    inside = (low[best] - asked >= workspace.min).all() and (
        high[best] + asked <= workspace.max
    ).all()
    # no way of that length leaves the ellipsoid around start and goal
    reach = np.linalg.norm(high - low, axis=1) / 2 + asked
    by_middle = np.linalg.norm(ends - ((low + high) / 2)[:, None], axis=2).sum(axis=1)
    beyond = by_middle - 2 * reach > length
    beyond[best] = True
    return Bound(length, bool(inside and beyond.all()))


def _past(surface: MeshShape, ends: FloatArray, clearance: float) -> float:
    """Bound by a ball in the widened surface around a place of the straight line, [unit].

    0 where the surface is not in the way.
    """
    if float(surface.segment_distance(ends[:1], ends[1:])[0]) >= clearance:
        return 0.0
    if float(surface.signed_distance(ends).min()) < clearance:
        return math.dist(*ends)
    share = np.linspace(0, 1, _SAMPLES)[:, None]
    line = ends[:1] + share * (ends[1:] - ends[:1])
    radius = clearance - surface.signed_distance(line)
    k = int(radius.argmax())
    (a, b, c), (d, e, f) = (ends - line[k]).tolist()
    return float(kernels.around_ball(float(radius[k]), (a, b, c), (d, e, f)))
