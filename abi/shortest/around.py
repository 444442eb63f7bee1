"""Shortest ways around one solid widened by a radius, in the solid's own axes.

A shortest way around a convex body is straight, then a geodesic of its surface, then straight, with
one tangent all along. Where the surface is developable (flat faces, round edges, a cylinder's side)
it unrolls into a plane, in which that whole way is one straight line. What is left, ways that touch
a rounded corner or an end, is bounded from below.

Points are triples of numbers, [unit]. Widened means: all points within the radius of the solid.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

Point = tuple[float, float, float]
Face = tuple[int, int]  # axis and side, -1 or 1
Gate = tuple[complex, complex, complex, float]

_QUARTER = math.pi / 2
_ANGLE = 1e-9  # by which an angle may miss its range, for rounding


@dataclass(frozen=True)
class Way:
    """Length of the shortest way that was looked for.

    Attributes:
        length: no way is shorter, [unit].
        exact: whether there is one of this length.
    """

    length: float
    exact: bool


def around_ball(radius: float, start: Point, goal: Point) -> float:
    """Exact length of the shortest way around a ball at the origin, by two tangents and an arc.

    Args:
        radius: of the ball, [unit].
        start: not inside the ball.
        goal: not inside the ball.
    """
    a, b = math.hypot(*start), math.hypot(*goal)
    straight = math.dist(start, goal)
    if radius <= 0 or a <= radius or b <= radius:
        return straight
    cosine = sum(p * q for p, q in zip(start, goal, strict=True)) / (a * b)
    arc = math.acos(max(-1.0, min(1.0, cosine))) - math.acos(radius / a) - math.acos(radius / b)
    if arc <= 0:
        return straight
    return math.sqrt(a * a - radius**2) + math.sqrt(b * b - radius**2) + radius * arc


def around_bar(radius: float, half: float, start: Point, goal: Point) -> Way:
    """Shortest way around a bar along z: round in section, its ends beyond |z| = ``half``.

    The bar widened is the cylinder |z| <= half with anything beyond that lies in the cylinder's
    extension, as a capsule's caps do. A way that meets it only on the cylinder unrolls; any other
    crosses a plane |z| = half, so mirroring about that plane bounds its length.
    """
    straight = math.dist(start, goal)
    ends = min(_by_plane(half, start, goal), _by_plane(-half, start, goal))
    a, b = math.hypot(*start[:2]), math.hypot(*goal[:2])
    if a < radius or b < radius:
        return Way(max(ends, straight), False)
    turn = abs(math.atan2(start[1], start[0]) - math.atan2(goal[1], goal[0]))
    tangents = math.sqrt(a * a - radius**2), math.sqrt(b * b - radius**2)
    unseen = math.acos(radius / a) + math.acos(radius / b)
    rise = goal[2] - start[2]
    best = math.inf
    for angle in (turn, 2 * math.pi - turn):
        if angle < unseen:
            return Way(straight, False)
        level = sum(tangents) + radius * (angle - unseen)
        first = start[2] + rise * tangents[0] / level if level else start[2]
        last = goal[2] - rise * tangents[1] / level if level else goal[2]
        if max(abs(first), abs(last)) <= half:
            best = min(best, math.hypot(level, rise))
    return Way(min(best, ends), best <= ends)


def around_box(half: Point, radius: float, start: Point, goal: Point) -> Way:
    """Shortest way around a box of half sizes ``half``, widened by ``radius`` >= 0.

    Tries every order in which the way can cross faces: a shortest way crosses none twice, since
    the surface between two points of a face is flat. The way unrolled is straight, so it either
    stays between the ends of the edges that it rounds, and is a way indeed, or its order can be
    left out. Ways that touch a corner are bounded by the nearest such point. (Sharir and Schorr,
    On Shortest Paths in Polyhedral Spaces, SIAM J. Comput. 15, 1986, for the polyhedron.)
    """
    best = min(_unrolled(half, radius, start, goal), default=math.inf)
    corners = min(
        (
            _by_corner(half, radius, start, goal, corner)
            for corner in itertools.product((-1, 1), repeat=3)
        ),
        default=math.inf,
    )
    length = max(min(best, corners), math.dist(start, goal))
    return Way(length, best <= corners)


def _by_plane(height: float, start: Point, goal: Point) -> float:
    """Length of the shortest way from start to goal by the side of z = height away from 0."""
    sign = math.copysign(1.0, height)
    a, b = max(abs(height) - sign * start[2], 0.0), max(abs(height) - sign * goal[2], 0.0)
    if a == 0 or b == 0:
        return math.dist(start, goal)
    return math.hypot(start[0] - goal[0], start[1] - goal[1], a + b)


def _by_corner(
    half: Point, radius: float, start: Point, goal: Point, corner: tuple[int, ...]
) -> float:
    """No way that touches this rounded corner is shorter; inf where a shortest one does not.

    A shortest way touches a point in its tangent plane, so an end that lies beyond the tangent
    planes of all of the corner's points sees them all, but not along one of them.
    """
    a = [side * p - h for side, p, h in zip(corner, start, half, strict=True)]
    b = [side * p - h for side, p, h in zip(corner, goal, half, strict=True)]
    if _lowest(a) > radius or _lowest(b) > radius:
        return math.inf
    # The sum of the distances to the ends is convex: each tangent bounds it.
    third = 1 / math.sqrt(3)
    bound = 0.0
    for y in ((third, third, third), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
        x = [radius * value for value in y]
        to_a, to_b = math.dist(x, a), math.dist(x, b)
        slope = [
            (p - q) / (to_a or math.inf) + (p - r) / (to_b or math.inf)
            for p, q, r in zip(x, a, b, strict=True)
        ]
        along = sum(p * q for p, q in zip(slope, y, strict=True))
        bound = max(bound, to_a + to_b + radius * (_lowest(slope) - along))
    return bound


def _lowest(slope: list[float]) -> float:
    """Least value of slope . y over the unit vectors y >= 0."""
    if min(slope) >= 0:
        return min(slope)
    return -math.hypot(*(min(value, 0.0) for value in slope))


def _unrolled(half: Point, radius: float, start: Point, goal: Point) -> Iterator[float]:
    """Lengths of the straight unrolled ways that stay between the ends of their edges."""
    faces = [(axis, side) for axis in range(3) for side in (-1, 1)]
    for first, second in itertools.permutations(faces, 2):
        if first[0] == second[0]:
            continue
        touch = _tangent(half, radius, start, first, second)
        if touch is None:
            continue
        leave = _tangent(half, radius, goal, second, first)
        if leave is not None:
            yield from _over_edge(half, radius, start, goal, first, second, touch, leave)
        yield from _rolled(half, radius, start, goal, first, second, touch)


def _tangent(
    half: Point, radius: float, point: Point, near: Face, far: Face
) -> tuple[float, float] | None:
    """Tangent from a point beyond ``near`` to the round edge, towards ``far``.

    Returns:
        Its length across the edge, and the angle of the edge's arc from there to ``far``, in
        [0, π/2]; None where no tangent touches the arc.
    """
    u = near[1] * point[near[0]] - half[near[0]]
    v = far[1] * point[far[0]] - half[far[0]]
    length = math.sqrt(max(u * u + v * v - radius * radius, 0.0))
    angle = math.atan2(v, u) + math.atan2(length, radius)
    if not -_ANGLE <= angle <= _QUARTER + _ANGLE:
        return None
    return length, min(max(_QUARTER - angle, 0.0), _QUARTER)


def _over_edge(
    half: Point,
    radius: float,
    start: Point,
    goal: Point,
    first: Face,
    second: Face,
    touch: tuple[float, float],
    leave: tuple[float, float],
) -> Iterator[float]:
    """The way over one edge alone: a helix between two tangents."""
    axis = 3 - first[0] - second[0]
    arc = touch[1] + leave[1] - _QUARTER
    if arc < -_ANGLE:
        return
    across = touch[0] + leave[0] + radius * max(arc, 0.0)
    rise = goal[axis] - start[axis]
    share = touch[0] / across if across else 0.0
    other = leave[0] / across if across else 0.0
    if max(abs(start[axis] + rise * share), abs(goal[axis] - rise * other)) <= half[axis]:
        yield math.hypot(across, rise)


def _rolled(
    half: Point,
    radius: float,
    start: Point,
    goal: Point,
    first: Face,
    second: Face,
    touch: tuple[float, float],
) -> Iterator[float]:
    """Ways over ``second`` and further faces, the box rolled from face to face over a plane.

    Places in the plane are complex numbers. A gate is a line across the edge, which the way crosses
    between the edge's ends: a place on it, its unit normal, the edge's direction and half length.
    """
    axis = 3 - first[0] - second[0]
    away = complex(0, -1)
    edge = half[first[0]] * away
    origin = edge + (radius * touch[1] + touch[0]) * away + start[axis]
    gates = [(edge + radius * touch[1] * away, -away, 1 + 0j, half[axis])]
    gates.append((edge, -away, 1 + 0j, half[axis]))
    directions = {first[0]: first[1] * away, axis: 1 + 0j}
    stack: list[tuple[tuple[Face, ...], complex, dict[int, complex], list[Gate]]]
    stack = [((first, second), 0j, directions, gates)]
    while stack:
        crossed, centre, directions, gates = stack.pop()
        here = crossed[-1]
        for axis, side in itertools.product(directions, (-1, 1)):
            face = (axis, side)
            if face in crossed:
                continue
            (other,) = set(directions) - {axis}
            ahead = side * directions[axis]
            edge = centre + half[axis] * ahead
            gate = (edge, ahead, directions[other], half[other])
            leave = _tangent(half, radius, goal, face, here)
            if leave is not None:
                end = edge + (radius * leave[1] + leave[0]) * ahead
                end += goal[other] * directions[other]
                last = (edge + radius * leave[1] * ahead, ahead, directions[other], half[other])
                if _passes(origin, end, [*gates, gate, last]):
                    yield abs(end - origin)
            over = edge + radius * _QUARTER * ahead
            rolled = {here[0]: -here[1] * ahead, other: directions[other]}
            beyond = (over, ahead, directions[other], half[other])
            stack.append(
                ((*crossed, face), over + half[here[0]] * ahead, rolled, [*gates, gate, beyond])
            )


def _passes(origin: complex, end: complex, gates: list[Gate]) -> bool:
    """Whether the straight line crosses the gates forwards, in order and between their ends."""
    way = end - origin
    before = 0.0
    for place, normal, along, half in gates:
        speed = (way * normal.conjugate()).real
        gone = ((place - origin) * normal.conjugate()).real
        if speed <= 0 or gone < before * speed - _ANGLE or gone > speed + _ANGLE:
            return False
        before = gone / speed
        if abs(((origin + before * way - place) * along.conjugate()).real) > half:
            return False
    return True
