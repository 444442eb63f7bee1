"""Shortest ways around what is round: a ball, and a bar round in section.

Plain Python that numba compiles with its caller. Points are triples of numbers, [unit]. A way is
its length, below which there is none, [unit], and whether there is one of that length.
"""

from __future__ import annotations

import math

from numba.extending import register_jitable

from abi.obstacles.vector_kernels import Vec3, distance, norm

Way = tuple[float, bool]


@register_jitable
def around_ball(radius: float, start: Vec3, goal: Vec3) -> float:
    """Exact length of the shortest way around a ball at the origin, by two tangents and an arc.

    Args:
        radius: of the ball, [unit].
        start: not inside the ball.
        goal: not inside the ball.
    """
    a, b = norm(start), norm(goal)
    straight = distance(start, goal)
    if radius <= 0 or a <= radius or b <= radius:
        return straight
    cosine = (start[0] * goal[0] + start[1] * goal[1] + start[2] * goal[2]) / (a * b)
    arc = math.acos(max(-1.0, min(1.0, cosine))) - math.acos(radius / a) - math.acos(radius / b)
    if arc <= 0:
        return straight
    return math.sqrt(a * a - radius**2) + math.sqrt(b * b - radius**2) + radius * arc


@register_jitable
def around_bar(radius: float, half: float, start: Vec3, goal: Vec3) -> Way:
    """Shortest way around a bar along z: round in section, its ends beyond |z| = ``half``.

    The bar widened is the cylinder |z| <= half with anything beyond that lies in the cylinder's
    extension, as a capsule's caps do. A way that meets it only on the cylinder unrolls; any other
    crosses a plane |z| = half, so mirroring about that plane bounds its length.
    """
    straight = distance(start, goal)
    ends = min(_by_plane(half, 1.0, start, goal), _by_plane(half, -1.0, start, goal))
    a, b = math.hypot(start[0], start[1]), math.hypot(goal[0], goal[1])
    if a < radius or b < radius:
        return max(ends, straight), False
    turn = abs(math.atan2(start[1], start[0]) - math.atan2(goal[1], goal[0]))
    before, after = math.sqrt(a * a - radius**2), math.sqrt(b * b - radius**2)
    unseen = math.acos(radius / a) + math.acos(radius / b)
    rise = goal[2] - start[2]
    best = math.inf
    for angle in (turn, 2 * math.pi - turn):
        if angle < unseen:
            return straight, False
        across = before + after + radius * (angle - unseen)
        first = start[2] + rise * before / across if across > 0 else start[2]
        last = goal[2] - rise * after / across if across > 0 else goal[2]
        if max(abs(first), abs(last)) <= half:
            best = min(best, math.hypot(across, rise))
    return min(best, ends), best <= ends


@register_jitable
def _by_plane(height: float, sign: float, start: Vec3, goal: Vec3) -> float:
    """Length of the shortest way from start to goal by z = sign height, on the side away from 0."""
    a, b = max(height - sign * start[2], 0.0), max(height - sign * goal[2], 0.0)
    if a == 0 or b == 0:
        return distance(start, goal)
    return distance((start[0], start[1], 0.0), (goal[0], goal[1], a + b))
