"""How short a curve can be at best: proven bounds of the length of any curve that keeps clear."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from abi.arrays import FloatArray
from abi.clearance import ROUNDING
from abi.pose import rotation
from abi.scene import Workspace
from abi.shapes import Box, Capsule, Cylinder, MeshShape, Obstacle, Obstacles, Sphere, Vec3
from abi.shortest.around import Point, Way, around_ball, around_bar, around_box

_SAMPLES = 65  # of the straight line and of a bar's axis, for balls that bound
_PRISMS = 4  # square prisms inscribed in a cylinder, turned evenly


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
    start: Vec3, goal: Vec3, obstacles: Obstacles, clearance: float, workspace: Workspace
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
    straight = float(np.linalg.norm(ends[1] - ends[0]))
    in_the_way = [
        k
        for k, solid in enumerate(obstacles)
        if float(solid.segment_distance(ends[:1], ends[1:])[0]) < asked
    ]
    if not in_the_way:
        return Bound(straight, True)
    ways = {k: _around(obstacles[k], ends, asked) for k in in_the_way}
    best = max(ways, key=lambda k: ways[k].length)
    length = max(ways[best].length, straight)
    rest = (solid for k, solid in enumerate(obstacles) if k != best)
    exact = (
        ways[best].exact
        and _within(obstacles[best], asked, workspace)
        and all(_beyond(solid, ends, asked, length) for solid in rest)
    )
    return Bound(length, exact)


def _around(solid: Obstacle, ends: FloatArray, clearance: float) -> Way:
    """Bound for one obstacle that is in the way."""
    if float(solid.signed_distance(ends).min()) < clearance:
        return Way(math.dist(*ends), False)
    if isinstance(solid, MeshShape):
        return Way(_ball_bound(solid, ends, clearance), False)
    start, goal = _in_body(solid, ends)
    if isinstance(solid, Sphere):
        return Way(around_ball(solid.radius + clearance, start, goal), True)
    if isinstance(solid, Box):
        x, y, z = solid.size
        way = around_box((x / 2, y / 2, z / 2), clearance, start, goal)
        return _at_least(way, _ball_bound(solid, ends, clearance))
    way = around_bar(solid.radius + clearance, solid.height / 2, start, goal)
    balls = _balls_on_axis(solid, start, goal, clearance)
    if isinstance(solid, Cylinder) and not way.exact:
        balls = max(balls, _prisms(solid, start, goal, clearance))
    return _at_least(way, balls)


def _at_least(way: Way, length: float) -> Way:
    """The better of a bound and another; the first stays exact unless the other one is above it."""
    return way if way.exact or way.length >= length else Way(length, False)


def _in_body(solid: Obstacle, ends: FloatArray) -> tuple[Point, Point]:
    """Start and goal in the solid's own axes."""
    placed = (ends - np.array(solid.position)) @ rotation(solid.wxyz)
    (a, b, c), (d, e, f) = placed.tolist()
    return (a, b, c), (d, e, f)


def _ball_bound(solid: Obstacle, ends: FloatArray, clearance: float) -> float:
    """Bound by balls in the widened solid around places of the straight line."""
    share = np.linspace(0, 1, _SAMPLES)[:, None]
    line = ends[:1] + share * (ends[1:] - ends[:1])
    radius = clearance - solid.signed_distance(line)
    k = int(radius.argmax())
    (a, b, c), (d, e, f) = (ends - line[k]).tolist()
    return around_ball(float(radius[k]), (a, b, c), (d, e, f))


def _balls_on_axis(solid: Cylinder | Capsule, start: Point, goal: Point, clearance: float) -> float:
    """Bound by the largest balls in the widened solid around places of its axis."""
    half, radius = solid.height / 2, solid.radius
    if isinstance(solid, Cylinder):
        radius = min(radius, half)
        half -= radius
    return max(
        around_ball(
            radius + clearance,
            (start[0], start[1], start[2] - height),
            (goal[0], goal[1], goal[2] - height),
        )
        for height in np.linspace(-half, half, _SAMPLES).tolist()
    )


def _prisms(solid: Cylinder, start: Point, goal: Point, clearance: float) -> float:
    """Bound by square prisms within a cylinder."""
    side = solid.radius / math.sqrt(2)
    prism = Box(size=(2 * side, 2 * side, solid.height))
    best = 0.0
    for k in range(_PRISMS):
        c, s = math.cos(k * math.pi / 2 / _PRISMS), math.sin(k * math.pi / 2 / _PRISMS)
        a, b = ((c * x + s * y, c * y - s * x, z) for x, y, z in (start, goal))
        if prism.segment_distance(np.array([a]), np.array([b]))[0] < clearance:
            way = around_box((side, side, solid.height / 2), clearance, a, b)
            best = max(best, way.length)
    return best


def _within(solid: Obstacle, clearance: float, workspace: Workspace) -> bool:
    """Whether a solid and what is nearer to it than the clearance lie in the workspace."""
    low, high = solid.bounds()
    return bool(
        (low - clearance >= workspace.min).all() and (high + clearance <= workspace.max).all()
    )


def _beyond(solid: Obstacle, ends: FloatArray, clearance: float, length: float) -> bool:
    """Whether no way of that length from start to goal comes within the clearance of a solid."""
    low, high = solid.bounds()
    reach = float(np.linalg.norm(high - low)) / 2 + clearance
    return float(np.linalg.norm(ends - (low + high) / 2, axis=1).sum()) - 2 * reach > length
