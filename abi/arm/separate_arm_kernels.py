"""Certificates of the arm: directions that separate its capsules from what stands around it.

See ``abi.arm.arm_certificate`` for what a direction proves, ``abi.arm.pose_kernels`` for the
numbers of an arm and its capsules, ``abi.clearance.separation_kernels`` for pieces and planes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from numba.extending import register_jitable

from abi.arm.pose_kernels import (
    CAPSULE,
    NO_ARM,
    ArmTable,
    Pose,
    Rates,
    capsule_ends,
    capsule_rates,
    limits_hold_near,
    pose_of,
    rates_near,
    reaches,
    shoulder_holds,
)
from abi.arrays import BoolArray, FloatArray, IntArray
from abi.clearance.separation_kernels import (
    CERTIFIED,
    MOST_HALVINGS,
    NO_PLANE,
    REFUTED,
    UNDECIDED,
    Outcome,
    Piece,
    Plane,
    halves_of,
    table_of,
)
from abi.compiled import FLAGS, FLOATS, IDS, NEW_FLOATS, compiled
from abi.obstacles.primitive_kernels import (
    BOUNDS,
    WIDTH,
    Core,
    axes_of,
    centre_of,
    core_of,
    in_body,
    in_world,
    signed_distance_gradient,
)
from abi.obstacles.vector_kernels import Vec3, axpy, distance, dot, sub, vec3_at

UNREACHED = 3
"""Outcome of a piece with a place that the arm does not reach within its limits."""

_STEPS = 40
_LATEST = 8
FINEST = 2.0**-26
"""Part of the largest coordinate: smaller pieces are not halved."""
ALLOWANCE = 2.0**-40
"""Part of the largest coordinate, for each place of the elbow computed."""


class Obstacles(NamedTuple):
    """Everything around that the arm is to keep clear of.

    Attributes:
        primitives: rows (k WIDTH,).
        inside: first and last row but one of those inside a row that is a box around others; 0 and
            0 of what is itself solid (2 k,).
        meshes: number of the triangle mesh that a row holds a part of, -1 of others (k + 1,).
        margins: distance to prove from each of them and, last, from the floor (k + 1,), [unit].
        asked: whether a capsule is to keep clear of one of them, flat (c (k + 1),).
        floor: height of the floor, [unit].
        size: largest coordinate of arm and obstacles, [unit].
    """

    primitives: FloatArray
    inside: IntArray
    meshes: IntArray
    margins: FloatArray
    asked: BoolArray
    floor: float
    size: float


class Slide(NamedTuple):
    """Bounds of q5 along the curve, which does not fall.

    Attributes:
        parameters: increasing, from the curve's first to its last (m,).
        low, high: bounds at each of them (m,), [unit].
    """

    parameters: FloatArray
    low: FloatArray
    high: FloatArray


NO_OBSTACLES = Obstacles(FLOATS, IDS, IDS, FLOATS, FLAGS, 0.0, 1.0)
NO_SLIDE = Slide(FLOATS, FLOATS, FLOATS)
"""Examples."""


@register_jitable(forceinline=True)
def support(core: Core, direction: Vec3) -> float:
    """Greatest product of a body direction with a primitive."""
    x, y, z = abs(direction[0]), abs(direction[1]), abs(direction[2])
    if core[4] == 1:
        across: float = math.sqrt(x * x + y * y) * core[0] + z * core[2]
        return across
    return x * core[0] + y * core[1] + z * core[2] + core[3]


@register_jitable(forceinline=True)
def between_boxes(primitives: FloatArray, s: int, a: Vec3, b: Vec3) -> tuple[float, Vec3]:
    """Largest gap along an axis of the world between a segment and primitive s, and its way."""
    k = WIDTH * s + BOUNDS
    best, way = -math.inf, (0.0, 0.0, 1.0)
    for axis in range(3):
        low, high = min(a[axis], b[axis]), max(a[axis], b[axis])
        above, below = low - primitives[k + 3 + axis], primitives[k + axis] - high
        if max(above, below) > best:
            best = max(above, below)
            sign = 1.0 if above >= below else -1.0
            way = (
                sign if axis == 0 else 0.0,
                sign if axis == 1 else 0.0,
                sign if axis == 2 else 0.0,
            )
    return best, way


@register_jitable
def judged(core: Core, p: Vec3, d: Vec3, near: float, far: float) -> tuple[int, float, Vec3]:
    """Whether the segment from p to p + d, body frame, is separated by more than ``far``.

    A tangent bounds the distance, which is convex along the segment, from below, and its gradient
    separates as far as that bound. The next place is where those at both ends of the bracket meet,
    in turn with its middle.

    Returns:
        CERTIFIED with the gap and its direction; REFUTED with a distance below ``near``; else
        UNDECIDED.
    """
    low, high = 0.0, 1.0
    at_low, fall, at_high, rise = 0.0, 0.0, 0.0, 0.0  # distances and slopes once they are known
    square = dot(d, d)
    # nearest to the centre: there most segments are decided
    t = min(max(-dot(p, d) / square, 0.0), 1.0) if square > 0 else 0.0
    best, way = math.inf, (0.0, 0.0, 1.0)
    for step in range(_STEPS):
        away, way = signed_distance_gradient(core, axpy(t, d, p))
        best = min(best, away)
        if best < near:
            return REFUTED, best, way
        slope = dot(way, d)
        gap = dot(way, p) + min(0.0, slope) - support(core, way)
        if gap > far:
            return CERTIFIED, gap, way
        if slope == 0 or (slope < 0 and t == 1) or (slope > 0 and t == 0):
            return UNDECIDED, best, way
        if slope < 0:
            low, at_low, fall = t, away, slope
        else:
            high, at_high, rise = t, away, slope
        if fall == 0:
            t = 0.0
        elif rise == 0:
            t = 1.0
        else:
            t = (at_low - at_high + rise * high - fall * low) / (rise - fall)
            if best <= far and at_low + fall * (t - low) >= near:
                return UNDECIDED, best, way
            if step % 3 == 2 or not low < t < high:
                t = (low + high) / 2
            if not low < t < high:
                return UNDECIDED, best, way
    return UNDECIDED, best, way


@register_jitable
def _slide_within(slide: Slide, start: float, end: float) -> tuple[float, float]:
    """Bounds of q5 from one parameter to another."""
    last = len(slide.parameters) - 1
    low, high = 0, last
    while low < high:  # the last parameter not after the start
        middle = (low + high + 1) // 2
        if slide.parameters[middle] <= start:
            low = middle
        else:
            high = middle - 1
    first = low
    low, high = 0, last
    while low < high:  # the first parameter not before the end
        middle = (low + high) // 2
        if slide.parameters[middle] >= end:
            high = middle
        else:
            low = middle + 1
    return slide.low[first], slide.high[low]


class Moving(NamedTuple):
    """A capsule at a pose, and how far from there it may be.

    Attributes:
        number: of the capsule.
        first, last: ends of its segment, [unit], world.
        radius: [unit].
        way: of every point of it, at most, [unit].
    """

    number: int
    first: Vec3
    last: Vec3
    radius: float
    way: float


@register_jitable(forceinline=True)
def moving_capsule(
    arm: FloatArray,
    capsules: FloatArray,
    c: int,
    pose: Pose,
    rates: Rates,
    ways: tuple[float, float],
) -> Moving:
    """Capsule c near a pose.

    Args:
        arm: its numbers.
        capsules: theirs.
        c: number of the capsule.
        pose: the middle one.
        rates: of the elbow.
        ways: of the tool and the slide, at most, [unit].
    """
    a, b = capsule_ends(arm, pose, capsules, c)
    by_tool, by_slide = capsule_rates(arm, rates, capsules, c)
    way = by_tool * ways[0] + by_slide * ways[1]
    return Moving(c, a, b, capsules[CAPSULE * c + 3], way)


@register_jitable(forceinline=True)
def _allowance(around: Obstacles, rates: Rates) -> float:
    """Room for rounding, [unit]."""
    return ALLOWANCE * around.size * (1.0 if math.isinf(rates.slide) else 1 + rates.slide)


@register_jitable(forceinline=True)
def separating_gap(around: Obstacles, capsule: Moving, rates: Rates) -> float:
    """Gap, less a margin, between a capsule's segment and what it is clear of all the way."""
    return capsule.radius + _allowance(around, rates) + capsule.way


@register_jitable
def separates(around: Obstacles, s: int, capsule: Moving, rates: Rates) -> tuple[int, float, Vec3]:
    """Whether a direction keeps a capsule clear of an obstacle near a pose.

    Args:
        around: the obstacles.
        s: number of the obstacle.
        capsule: near the pose.
        rates: of the elbow.

    Returns:
        CERTIFIED, REFUTED at the pose or UNDECIDED; the distance there; the direction.
    """
    a, b, radius = capsule.first, capsule.last, capsule.radius
    far = around.margins[s] + separating_gap(around, capsule, rates)
    near = radius + around.margins[s] - _allowance(around, rates)
    if s == len(around.margins) - 1:
        gap, way = min(a[2], b[2]) - around.floor, (0.0, 0.0, 1.0)
        if gap > far:
            return CERTIFIED, gap, way
        return (REFUTED if gap < near else UNDECIDED), gap - radius, way
    gap, way = between_boxes(around.primitives, s, a, b)
    if gap > far:
        return CERTIFIED, math.inf, way
    axes = axes_of(around.primitives, s)
    p = in_body(axes, sub(a, centre_of(around.primitives, s)))
    d = in_body(axes, sub(b, a))
    outcome, away, way = judged(core_of(around.primitives, s), p, d, near, far)
    return outcome, away - radius, in_world(axes, way)


class Direction(NamedTuple):
    """A direction that separates a capsule from parts of a mesh near a pose.

    Attributes:
        way: unit vector towards the capsule, world.
        level: less the mesh's margin, the greatest product that such a part may have, [unit].
        mesh: number of the mesh.
    """

    way: Vec3
    level: float
    mesh: int


NO_DIRECTION = Direction((0.0, 0.0, 1.0), 0.0, -1)
"""Example."""


@register_jitable
def is_separated(around: Obstacles, s: int, latest: list[Direction]) -> bool:
    """Whether one of the latest directions keeps the part of a mesh in row s from a capsule.

    Near triangles have one in common with those beside and behind them.
    """
    mesh = around.meshes[s]
    if mesh < 0 or len(latest) == 0:
        return False
    axes, core = axes_of(around.primitives, s), core_of(around.primitives, s)
    centre, margin = centre_of(around.primitives, s), around.margins[s]
    for k in range(len(latest) - 1, -1, -1):
        known = latest[k]
        if known.mesh == mesh:
            reached = dot(known.way, centre) + support(core, in_body(axes, known.way))
            if reached < known.level - margin:
                return True
    return False


@register_jitable
def keep_direction(latest: list[Direction], way: Vec3, level: float, mesh: int) -> None:
    """Add a direction, see :class:`Direction`, to the latest, of which the oldest go."""
    if mesh >= 0:
        if len(latest) == _LATEST:
            latest.pop(0)
        latest.append(Direction(way, level, mesh + 0))


@register_jitable
def open_box(
    around: Obstacles, pair: int, moves: float, segment: tuple[Vec3, Vec3], work: list[int]
) -> bool:
    """Add what is inside a box that is larger than a capsule's way; whether it is one.

    What is nearest to the capsule's segment comes last, to be tried first.
    """
    count = len(around.margins)
    s = pair % count
    if s == count - 1 or around.inside[2 * s + 1] == 0:
        return False
    k = WIDTH * s + BOUNDS
    size = 0.0
    for axis in range(3):
        size = max(size, around.primitives[k + 3 + axis] - around.primitives[k + axis])
    if size < moves:
        return False
    a, b = segment
    way = sub(b, a)
    square = max(dot(way, way), 1e-300)
    nearest, at = math.inf, 0
    for row in range(around.inside[2 * s], around.inside[2 * s + 1]):
        work.append(pair - s + row)
        p = sub(centre_of(around.primitives, row), a)
        p = axpy(-min(max(dot(p, way) / square, 0.0), 1.0), way, p)
        if dot(p, p) < nearest:
            nearest, at = dot(p, p), len(work) - 1
    last = len(work) - 1
    work[at], work[last] = work[last], work[at]
    return True


@register_jitable
def asked_rows(around: Obstacles, moving: int) -> list[int]:
    """Rows, of which the last may be the floor's, that some of so many capsules keep clear of."""
    count = len(around.margins)
    rows = []
    for s in range(count):
        asked = False
        for c in range(moving):
            asked = asked or around.asked[c * count + s]
        if asked:
            rows.append(s)
    return rows


@register_jitable
def is_solid(around: Obstacles, pair: int) -> bool:
    """Whether the obstacle of a pair is solid, not a box around others."""
    count = len(around.margins)
    s = pair % count
    return s == count - 1 or around.inside[2 * s + 1] == 0


@compiled(example=(FLOATS, FLOATS, NEW_FLOATS, NO_ARM, NO_OBSTACLES, NO_SLIDE, 9))
def separate_arm(
    world: FloatArray,
    breaks: FloatArray,
    points: FloatArray,
    table: ArmTable,
    around: Obstacles,
    slide: Slide,
    most_tries: int,
) -> Outcome:
    """Separate every capsule from every obstacle while the tool runs along a curve.

    Where that is proven, q2 and q3 keep their limits, too. A piece of the curve carries the pairs
    that its parents were not separated in; what is left of them is tried on both halves.

    Args:
        world: Bézier points of the s polynomials, flat (3 s (degree + 1),), world frame.
        breaks: parameters between them (s + 1,).
        points: room for the same and the halves, flat (3 (s + 2 MOST_HALVINGS + 2) (degree + 1),).
        table: the arm.
        around: what to keep clear of.
        slide: bounds of q5.
        most_tries: tries it may take.

    Returns:
        As for curves; a plane's obstacle is the number of its pair, and its level the parameter of
        the pose.
    """
    arm, capsules = table
    spans, count = len(breaks) - 1, len(around.margins)
    width = len(world) // (3 * spans)
    for i in range(len(world)):
        points[i] = world[i]
    planes, candidates, work, tries = [NO_PLANE], [0], [0], 0
    latest = [NO_DIRECTION]
    candidates.clear()
    for pair in range(len(capsules) // CAPSULE * count):
        if around.asked[pair]:
            candidates.append(pair)
    if len(candidates) == 0:
        return CERTIFIED, 0.0, -1, math.inf, table_of(planes)
    whole = Piece(0, spans * width, 0, breaks[0], breaks[spans])
    pending = [(whole, 0, len(candidates))]
    while len(pending) > 0:
        piece, lowest, highest = pending.pop()
        while len(candidates) > highest:
            candidates.pop()
        at, ahead, behind = halves_of(points, piece, breaks, width)
        middle = vec3_at(points, 3 * behind.first)
        low, high = _slide_within(slide, piece.start, piece.end)
        forearm, slid = arm[5] + (low + high) / 2, (high - low) / 2
        farthest = 0.0
        for i in range(3 * piece.first, 3 * piece.last, 3):
            farthest = max(farthest, distance(middle, vec3_at(points, i)))
        farthest *= 1 + 2.0**-40
        if not reaches(arm, middle, forearm):
            return UNREACHED, at, -1, 0.0, table_of(planes)
        pose = pose_of(arm, middle, forearm)
        if not shoulder_holds(arm, pose):
            return UNREACHED, at, -1, 0.0, table_of(planes)
        rates = rates_near(arm, pose, farthest, slid)
        bounded = not math.isinf(rates.elbow)
        bounded = bounded and limits_hold_near(arm, pose, rates, farthest, slid)
        capsule = moving_capsule(arm, capsules, 0, pose, rates, (farthest, slid))
        work.clear()
        latest.clear()
        left = -1
        for i in range(highest - 1, lowest - 1, -1):
            work.append(candidates[i])
        while len(work) > 0:
            pair = work.pop()
            tries += 1
            s = pair % count
            if pair // count != capsule.number:
                capsule = moving_capsule(
                    *(arm, capsules, pair // count), pose, rates, (farthest, slid)
                )
                latest.clear()
                left = -1
            if is_separated(around, s, latest):
                continue
            if left >= 0 and around.meshes[s] == left:
                candidates.append(pair)
                continue
            outcome, away, way = separates(around, s, capsule, rates)
            if outcome == REFUTED and is_solid(around, pair):
                return REFUTED, at, pair, away, table_of(planes)
            if bounded and outcome == CERTIFIED:
                planes.append(Plane(piece.start, piece.end, pair, way, at))
                level = min(dot(way, capsule.first), dot(way, capsule.last))
                level -= separating_gap(around, capsule, rates)
                keep_direction(latest, way, level, around.meshes[s])
            elif not open_box(around, pair, capsule.way, (capsule.first, capsule.last), work):
                candidates.append(pair)
                # the piece is halved anyhow: the rest of the mesh is as good tried on its halves
                left = around.meshes[s] + 0
        if len(candidates) == highest:
            continue
        run = piece.last - piece.first > width
        final = piece.halvings == MOST_HALVINGS or farthest < FINEST * around.size
        if tries > most_tries or (not run and (final or not piece.start < at < piece.end)):
            return UNDECIDED, at, candidates[len(candidates) - 1], 0.0, table_of(planes)
        pending.append((behind, highest, len(candidates)))
        pending.append((ahead, highest, len(candidates)))
    return CERTIFIED, 0.0, -1, math.inf, table_of(planes)
