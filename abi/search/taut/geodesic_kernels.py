"""Shortest paths around one solid widened by a radius, in the solid's own axes.

A shortest path around a convex body is straight, then a geodesic of its surface, then straight,
without a kink. Where the surface is developable (flat faces, round edges, a cylinder's side) it
unrolls into a plane, in which the whole path is one straight line. The rest, paths that touch a
rounded corner or an end, is bounded from below.

Points are triples of numbers, [unit]. Widened means: all points within the radius of the solid. A
face of a box is a number: twice its axis, and one more on the positive side.
"""

from __future__ import annotations

import math

import numpy as np

from abi.arrays import BoolArray, FloatArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, compiled
from abi.obstacles.primitive_kernels import (
    WIDTH,
    Core,
    axes_of,
    centre_of,
    core_of,
    in_body,
    segment_within,
    signed_distance,
)
from abi.obstacles.vector_kernels import Vec3, axpy, cross, distance, dot, norm, sub

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


_SAMPLES = 65  # of the straight line and of a bar's axis, for balls that bound
_PRISMS = 4  # square prisms inscribed in a cylinder, at even angles


@jitable
def around_ball(radius: float, start: Vec3, goal: Vec3) -> float:
    """Length of the shortest path around a ball at the origin: two tangents and an arc.

    Angles are those of tangents, not cosines: near 0 and a half turn these have lost half of their
    digits.

    Args:
        radius: of the ball, [unit].
        start: not inside the ball.
        goal: not inside the ball.
    """
    a, b = norm(start), norm(goal)
    straight = distance(start, goal)
    if radius <= 0 or a <= radius or b <= radius:
        return straight
    before, after = math.sqrt((a - radius) * (a + radius)), math.sqrt((b - radius) * (b + radius))
    arc = math.atan2(norm(cross(start, goal)), dot(start, goal))
    arc -= math.atan2(before, radius) + math.atan2(after, radius)
    if arc <= 0:
        return straight
    return before + after + radius * arc


@jitable
def around_bar(radius: float, half: float, start: Vec3, goal: Vec3) -> LengthBound:
    """Shortest path around a bar along z: round in section, its ends beyond |z| = ``half``.

    The bar widened is the cylinder |z| <= half with anything beyond that lies in the cylinder's
    extension, as a capsule's caps do. A path that meets it only on the cylinder unrolls; any other
    crosses a plane |z| = half, so mirroring about that plane bounds its length.
    """
    straight = distance(start, goal)
    ends = min(_plane_bound(half, 1.0, start, goal), _plane_bound(half, -1.0, start, goal))
    a, b = math.hypot(start[0], start[1]), math.hypot(goal[0], goal[1])
    if a < radius or b < radius:
        return max(ends, straight), False
    separation = abs(math.atan2(start[1], start[0]) - math.atan2(goal[1], goal[0]))
    before, after = math.sqrt((a - radius) * (a + radius)), math.sqrt((b - radius) * (b + radius))
    unseen = math.atan2(before, radius) + math.atan2(after, radius)
    rise = goal[2] - start[2]
    best = math.inf
    for angle in (separation, 2 * math.pi - separation):
        if angle < unseen:
            return straight, False
        across = before + after + radius * (angle - unseen)
        first = start[2] + rise * before / across if across > 0 else start[2]
        last = goal[2] - rise * after / across if across > 0 else goal[2]
        if max(abs(first), abs(last)) <= half:
            best = min(best, math.hypot(across, rise))
    return min(best, ends), best <= ends


@jitable
def _plane_bound(height: float, sign: float, start: Vec3, goal: Vec3) -> float:
    """Length of the shortest path to goal by the plane z = sign height, on its side away from 0."""
    a, b = max(height - sign * start[2], 0.0), max(height - sign * goal[2], 0.0)
    if a == 0 or b == 0:
        return distance(start, goal)
    return distance((start[0], start[1], 0.0), (goal[0], goal[1], a + b))


@jitable
def _ball_bound(core: Core, clearance: float, start: Vec3, goal: Vec3) -> float:
    """Lower bound by the largest ball in the widened solid around a point of the straight line."""
    radius, centre = -math.inf, start
    for k in range(_SAMPLES):
        t = k / (_SAMPLES - 1)
        p = axpy(t, sub(goal, start), start)
        room = clearance - signed_distance(core, p)
        if room > radius:
            radius, centre = room, p
    return around_ball(radius, sub(start, centre), sub(goal, centre))


@jitable
def _axis_balls_bound(radius: float, half: float, start: Vec3, goal: Vec3) -> float:
    """Lower bound by balls around points of the z axis up to ``half``."""
    bound = 0.0
    for k in range(_SAMPLES):
        centre = (0.0, 0.0, half * (2 * k / (_SAMPLES - 1) - 1))
        bound = max(bound, around_ball(radius, sub(start, centre), sub(goal, centre)))
    return bound


@jitable
def _prisms_bound(radius: float, half: float, clearance: float, start: Vec3, goal: Vec3) -> float:
    """Lower bound by square prisms within a cylinder."""
    side = radius / math.sqrt(2)
    bound = 0.0
    for k in range(_PRISMS):
        c, s = math.cos(k * math.pi / 2 / _PRISMS), math.sin(k * math.pi / 2 / _PRISMS)
        a = (c * start[0] + s * start[1], c * start[1] - s * start[0], start[2])
        b = (c * goal[0] + s * goal[1], c * goal[1] - s * goal[0], goal[2])
        core = Core(side, side, half, 0.0, 0.0)
        if segment_within(core, clearance, a, sub(b, a)):
            bound = max(bound, around_box((side, side, half), clearance, a, b)[0])
    return bound


@jitable
def _solid_bound(core: Core, clearance: float, start: Vec3, goal: Vec3) -> LengthBound:
    """Lower bound around a solid that blocks the line, see ``abi.obstacles.primitive_kernels``."""
    if min(signed_distance(core, start), signed_distance(core, goal)) < clearance:
        return distance(start, goal), False
    radius, half = core.radius, core.z
    if core.is_cylinder == 0 and core.x + core.y > 0:
        length, exact = around_box((core.x, core.y, half), radius + clearance, start, goal)
        other = 0.0 if exact else _ball_bound(core, clearance, start, goal)
    elif core.is_cylinder == 0 and half == 0:
        return around_ball(radius + clearance, start, goal), True
    elif core.is_cylinder == 0:
        length, exact = around_bar(radius + clearance, half, start, goal)
        other = 0.0 if exact else _axis_balls_bound(radius + clearance, half, start, goal)
    else:
        length, exact = around_bar(core.x + clearance, half, start, goal)
        other = 0.0
        if not exact:
            inner = min(core.x, half)
            other = max(
                _axis_balls_bound(inner + clearance, half - inner, start, goal),
                _prisms_bound(core.x, half, clearance, start, goal),
            )
    return max(length, other), exact


@compiled(example=(FLOATS, 0.0, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))
def solid_bounds(
    solids: FloatArray, clearance: float, start: Vec3, goal: Vec3
) -> tuple[FloatArray, BoolArray]:
    """Lower bounds of the paths from start to goal around each of the solids alone.

    Args:
        solids: (k WIDTH,) rows, one after the other.
        clearance: distance to keep from them, [unit].
        start: start, [unit], world.
        goal: goal.

    Returns:
        The bounds (k,), [unit], 0 for a solid that does not block the line; and whether a path has
        that length (k,).
    """
    count = len(solids) // WIDTH
    lengths, exact = np.zeros(count), np.zeros(count, np.bool_)
    for s in range(count):
        axes, core = axes_of(solids, s), core_of(solids, s)
        a = in_body(axes, sub(start, centre_of(solids, s)))
        b = in_body(axes, sub(goal, centre_of(solids, s)))
        if segment_within(core, clearance, a, sub(b, a)):
            lengths[s], exact[s] = _solid_bound(core, clearance, a, b)
    return lengths, exact
