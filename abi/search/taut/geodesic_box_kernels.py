"""Shortest paths around a box with round edges, by unrolling its faces and edges into a plane.

Plain Python that numba compiles with its caller. Points are triples of numbers, [unit]. A face of
the box is a number: twice its axis, and one more on the positive side.
"""

from __future__ import annotations

import math

from abi.compilation.jitable import jitable
from abi.obstacles.vector_kernels import Vec3, distance, dot, sub

LengthBound = tuple[float, bool]
"""Lower bound of the length of paths, [unit], and whether a path has that length."""
Faces = tuple[int, int]
"""Two faces that share an edge, in the order in which a path crosses them."""
Tangent = tuple[float, float]
"""Length of a tangent across an edge to its arc, [unit], -1 where it touches none; and the angle of
the arc from there to the far face, in [0, π/2]."""
Gate = tuple[complex, complex, complex, float]
"""An edge in the unrolled plane that a path crosses between its ends: its middle, its unit normal,
its direction, and half its length."""

_QUARTER = math.pi / 2
_ROUNDING = 1e-9  # by which an angle or a share may miss its range


@jitable
def around_box(half: Vec3, radius: float, start: Vec3, goal: Vec3) -> LengthBound:
    """Shortest path around a box of half sizes ``half``, widened by ``radius`` >= 0.

    Tries every order in which the path can cross faces: a shortest one crosses none twice, since
    the surface between two points of a face is flat. Unrolled it is straight, so it either stays
    between the ends of the edges that it rounds, and is a path indeed, or its order can be left
    out. Paths that touch a corner are bounded by the nearest such point. (Sharir and Schorr, On
    Shortest Paths in Polyhedral Spaces, SIAM J. Comput. 15, 1986, for the polyhedron.)
    """
    best, corners = math.inf, math.inf
    for first in range(6):
        for second in range(6):
            if first >> 1 == second >> 1:
                continue
            faces = (first, second)
            tangent = _tangent(half, radius, start, faces)
            if tangent[0] < 0:
                continue
            best = min(best, _over_edge(half, radius, start, goal, faces, tangent))
            best = min(best, _over_more_faces(half, radius, start, goal, faces, tangent))
    for x in (-1.0, 1.0):
        for y in (-1.0, 1.0):
            for z in (-1.0, 1.0):
                a = (x * start[0] - half[0], y * start[1] - half[1], z * start[2] - half[2])
                b = (x * goal[0] - half[0], y * goal[1] - half[1], z * goal[2] - half[2])
                corners = min(corners, _corner_bound(radius, a, b))
    return max(min(best, corners), distance(start, goal)), best <= corners


@jitable
def _corner_bound(radius: float, a: Vec3, b: Vec3) -> float:
    """Lower bound of paths that touch the rounded corner at 0; inf where a shortest does not.

    A shortest path touches a point in its tangent plane, so an end that lies beyond the tangent
    planes of all of the corner's points sees them all, but not along one of them.

    Args:
        radius: of the ball around the corner, [unit].
        a, b: start and goal from the corner; the box is where all coordinates are negative.
    """
    if _least_product(a) > radius or _least_product(b) > radius:
        return math.inf
    # The sum of the distances to the ends is convex: each tangent bounds it.
    third = 1 / math.sqrt(3)
    bound = 0.0
    for y in ((third, third, third), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
        p = (radius * y[0], radius * y[1], radius * y[2])
        to_a, to_b = distance(p, a), distance(p, b)
        u = 1 / to_a if to_a > 0 else 0.0
        v = 1 / to_b if to_b > 0 else 0.0
        from_a, from_b = sub(p, a), sub(p, b)
        slope = (
            from_a[0] * u + from_b[0] * v,
            from_a[1] * u + from_b[1] * v,
            from_a[2] * u + from_b[2] * v,
        )
        bound = max(bound, to_a + to_b + radius * (_least_product(slope) - dot(slope, y)))
    return bound


@jitable
def _least_product(slope: Vec3) -> float:
    """Least value of slope . y over the unit vectors y >= 0."""
    least = min(slope[0], min(slope[1], slope[2]))
    if least >= 0:
        return least
    x, y, z = min(slope[0], 0.0), min(slope[1], 0.0), min(slope[2], 0.0)
    return -math.sqrt(x * x + y * y + z * z)


@jitable
def _tangent(half: Vec3, radius: float, point: Vec3, faces: Faces) -> Tangent:
    """Tangent from a point beyond one face to the round edge, towards another."""
    near_face, far_face = faces
    u = (2 * (near_face & 1) - 1) * point[near_face >> 1] - half[near_face >> 1]
    v = (2 * (far_face & 1) - 1) * point[far_face >> 1] - half[far_face >> 1]
    length = math.sqrt(max(u * u + v * v - radius * radius, 0.0))
    angle = math.atan2(v, u) + math.atan2(length, radius)
    if not -_ROUNDING <= angle <= _QUARTER + _ROUNDING:
        return -1.0, 0.0
    return length, min(max(_QUARTER - angle, 0.0), _QUARTER)


@jitable
def _over_edge(
    half: Vec3, radius: float, start: Vec3, goal: Vec3, faces: Faces, tangent: Tangent
) -> float:
    """Length of the path over one edge alone, a helix between tangents; inf if there is none."""
    first, second = faces
    touch, angle = tangent
    departure, other_angle = _tangent(half, radius, goal, (second, first))
    arc = angle + other_angle - _QUARTER
    if departure < 0 or arc < -_ROUNDING:
        return math.inf
    axis = 3 - (first >> 1) - (second >> 1)
    across = touch + departure + radius * max(arc, 0.0)
    rise = goal[axis] - start[axis]
    share = touch / across if across > 0 else 0.0
    other = departure / across if across > 0 else 0.0
    if max(abs(start[axis] + rise * share), abs(goal[axis] - rise * other)) > half[axis]:
        return math.inf
    return math.hypot(across, rise)


@jitable
def _over_more_faces(
    half: Vec3, radius: float, start: Vec3, goal: Vec3, faces: Faces, tangent: Tangent
) -> float:
    """Length of the shortest path over the second and further faces; inf if there is none.

    The box is rolled from face to face over a plane, in which points are complex numbers. Depth
    first: each depth has the face that the box lies on, the next face to try, the box's
    centre and the directions of its axes in the plane, and two gates.
    """
    best = math.inf
    first, second = faces
    axis = 3 - (first >> 1) - (second >> 1)
    away = complex(0.0, -1.0)
    edge = half[first >> 1] * away
    origin = edge + (radius * tangent[1] + tangent[0]) * away + start[axis]
    gates = [(edge + radius * tangent[1] * away, -away, complex(1.0, 0.0), half[axis])] * 14
    gates[1] = (edge, -away, complex(1.0, 0.0), half[axis])
    face, untried = [0] * 7, [0] * 7
    centre, directions = [0j] * 7, [0j] * 21
    face[0] = second
    directions[first >> 1], directions[axis] = (2 * (first & 1) - 1) * away, complex(1.0, 0.0)
    crossed = (1 << first) | (1 << second)
    depth = 0
    while depth >= 0:
        if untried[depth] == 6:
            crossed &= ~(1 << face[depth])
            depth -= 1
            continue
        following = untried[depth]
        untried[depth] += 1
        here = face[depth]
        if crossed >> following & 1 == 1 or following >> 1 == here >> 1:
            continue
        axis = following >> 1
        other = 3 - axis - (here >> 1)
        ahead = (2 * (following & 1) - 1) * directions[3 * depth + axis]
        across = directions[3 * depth + other]
        edge = centre[depth] + half[axis] * ahead
        count = 2 * depth + 4
        gates[count - 2] = (edge, ahead, across, half[other])
        departure, arc = _tangent(half, radius, goal, (following, here))
        if departure >= 0:
            end = edge + (radius * arc + departure) * ahead + goal[other] * across
            gates[count - 1] = (edge + radius * arc * ahead, ahead, across, half[other])
            if _passes(origin, end, gates, count):
                best = min(best, abs(end - origin))
        if depth < 4:
            over = edge + radius * _QUARTER * ahead
            gates[count - 1] = (over, ahead, across, half[other])
            depth += 1
            face[depth], untried[depth] = following, 0
            centre[depth] = over + half[here >> 1] * ahead
            directions[3 * depth + (here >> 1)] = (1 - 2 * (here & 1)) * ahead
            directions[3 * depth + other] = across
            crossed |= 1 << following
    return best


@jitable
def _passes(origin: complex, end: complex, gates: list[Gate], count: int) -> bool:
    """Check if the straight line crosses the gates forwards, in order and between their ends."""
    line = end - origin
    before = 0.0
    for k in range(count):
        middle, normal, direction, half_length = gates[k]
        speed = (line * normal.conjugate()).real
        height = ((middle - origin) * normal.conjugate()).real
        if speed <= 0 or height < before * speed - _ROUNDING or height > speed + _ROUNDING:
            return False
        before = height / speed
        if abs(((origin + before * line - middle) * direction.conjugate()).real) > half_length:
            return False
    return True
