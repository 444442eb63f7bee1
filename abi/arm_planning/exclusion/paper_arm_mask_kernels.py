"""Mask of the tool positions that are out of the paper's arm's reach or where it touches something.

See ``abi.robot.paper_arm.pose_kernels`` for the numbers of an arm and its capsules.
"""

from __future__ import annotations

import math

import numpy as np

from abi.arm_planning.world.collision_world_kernels import (
    NO_OBSTACLES,
    Obstacles,
    asked_rows,
    box_gap,
)
from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compiled import FLAGS, FLOATS, NEW_FLAGS, compiled
from abi.obstacles.primitive_kernels import (
    BOUNDS,
    WIDTH,
    axes_of,
    centre_of,
    core_of,
    in_body,
    segment_within,
)
from abi.obstacles.triangle_mesh.segment_kernels import inverse_of, stretch_in
from abi.obstacles.triangle_mesh.triangle_kernels import DEPTH
from abi.obstacles.vector_kernels import Vec3, axpy, dot, sub, vec3_at
from abi.robot.paper_arm.pose_kernels import (
    CAPSULE,
    COLUMN,
    NO_ARM,
    UPPER_ARM,
    ArmTable,
    capsule_ends,
    capsule_rates,
    neighbourhood_of,
    pose_of,
    reaches,
    shoulder_holds,
    unbounded_near,
)


@compiled(example=(FLOATS, NO_ARM, 0.0, 0.0, NEW_FLAGS))
def reached_places(
    points: FloatArray, arm: ArmTable, forearm: float, slide: float, reached: BoolArray
) -> None:
    """Mark the places that the arm reaches within the limits of q2 and q3.

    Args:
        points: flat (3 n,), [unit], world.
        arm: the arm.
        forearm: length a6, [unit].
        slide: how much longer or shorter it may be, [unit].
        reached: (n,); written.
    """
    for i in range(len(reached)):
        x = vec3_at(points, 3 * i)
        reached[i] = (
            reaches(arm, x, forearm - slide)
            and reaches(arm, x, forearm + slide)
            and shoulder_holds(arm, pose_of(arm, x, forearm))
        )


@jitable(forceinline=True)
def is_near(primitives: FloatArray, s: int, a: Vec3, b: Vec3, need: float) -> bool:
    """Check whether a..b is nearer than ``need`` to row s."""
    if box_gap(primitives, s, a, b) >= need:
        return False
    axes = axes_of(primitives, s)
    p = in_body(axes, sub(a, centre_of(primitives, s)))
    return segment_within(core_of(primitives, s), need, p, in_body(axes, sub(b, a)))


@jitable
def touched_row(
    around: Obstacles, s: int, a: Vec3, b: Vec3, need: float, guess: int, waiting: IntArray
) -> int:
    """Row s, or one inside it, that is solid and from which a..b is nearer than ``need``; or -1.

    Args:
        around: what to keep clear of.
        s: its row.
        a, b: ends of the segment, [unit], world.
        need: [unit].
        guess: a row that is likely to be one, as of a segment beside; -1 without.
        waiting: room for ``DEPTH`` rows.
    """
    primitives, inside = around.primitives, around.inside
    if inside[2 * s + 1] == 0:
        return s if is_near(primitives, s, a, b, need) else -1
    if (
        guess >= 0
        and around.meshes[guess] == around.meshes[s]
        and is_near(primitives, guess, a, b, need)
    ):
        return guess
    inverse = inverse_of(sub(b, a))
    waiting[0], count = s, 1
    while count > 0:
        count -= 1
        box = waiting[count]
        for row in range(inside[2 * box], inside[2 * box + 1]):
            k = WIDTH * row + BOUNDS
            low, high = vec3_at(primitives, k), vec3_at(primitives, k + 3)
            if stretch_in(a, inverse, low, high, need) < 0.0:
                continue
            if not is_near(primitives, row, a, b, need):
                continue
            if inside[2 * row + 1] == 0:
                return row
            waiting[count] = row
            count += 1
    return -1


@jitable(forceinline=True)
def is_far(primitives: FloatArray, s: int, a: Vec3, b: Vec3, most: float) -> bool:
    """Check if a..b is farther than ``most`` from the bounds of row s, or the ball around them."""
    if box_gap(primitives, s, a, b) >= most:
        return True
    k = WIDTH * s + BOUNDS
    low, high = vec3_at(primitives, k), vec3_at(primitives, k + 3)
    to_low, size, way = sub(low, a), sub(high, low), sub(b, a)
    to_centre = axpy(0.5, size, to_low)
    square = dot(way, way)
    t = min(max(dot(to_centre, way) / square, 0.0), 1.0) if square > 0 else 0.0
    gap = axpy(-t, way, to_centre)
    reach = most + 0.5 * math.sqrt(dot(size, size))
    return dot(gap, gap) >= reach * reach


@jitable(forceinline=True)
def is_beside(around: Obstacles, s: int, arm: ArmTable, tool: Vec3, widest: float) -> bool:
    """Check whether row s is too far from the upright plane of the arm to be touched."""
    k = WIDTH * s + BOUNDS
    primitives = around.primitives
    x, y = tool[0] - arm.x, tool[1] - arm.y
    ahead = (primitives[k] + primitives[k + 3]) / 2 - arm.x
    side = (primitives[k + 1] + primitives[k + 4]) / 2 - arm.y
    wide, deep = primitives[k + 3] - primitives[k], primitives[k + 4] - primitives[k + 1]
    # the half width of the bounds across the plane, times the tool's distance from the axis
    reach = (abs(y) * wide + abs(x) * deep) / 2
    away, most = abs(x * side - y * ahead) - reach, widest + around.margins[s]
    beside: bool = away > 0 and away * away > most * most * (x * x + y * y)
    return beside


@jitable(forceinline=True)
def outline(arm: ArmTable) -> tuple[int, float, float, float]:
    """Number of capsules that stand still, and how far the others reach from the arm's lines.

    Returns:
        The number of those of the column, which come first and are not at shoulder, elbow and tool;
        the largest radius of the others; and how far they stand out from the lines of upper arm and
        forearm, [unit].
    """
    capsules = arm.capsules
    moving, still = len(capsules) // CAPSULE, 0
    while still < moving and capsules[CAPSULE * still] == COLUMN:
        still += 1
    widest, out_of_upper, out_of_fore = 0.0, 0.0, 0.0
    for c in range(still, moving):
        low, high = capsules[CAPSULE * c + 1], capsules[CAPSULE * c + 2]
        radius = capsules[CAPSULE * c + 3]
        widest = max(widest, radius)
        if capsules[CAPSULE * c] == UPPER_ARM:
            out_of_upper = max(out_of_upper, radius + max(0.0, -low, high - arm.upper))
        else:
            out_of_fore = max(out_of_fore, radius + max(0.0, -low, high - arm.forearm))
    return still, widest, out_of_upper, out_of_fore


@compiled(example=(FLOATS, NO_ARM, NO_OBSTACLES, 0.0, 0.0, FLAGS, NEW_FLAGS))
def touching_places(
    points: FloatArray,
    arm: ArmTable,
    around: Obstacles,
    forearm: float,
    slide: float,
    reached: BoolArray,
    touching: BoolArray,
) -> None:
    """Mark the places of the tool at which a capsule is too near to something.

    Args:
        points: flat (3 n,), [unit], world.
        arm: the arm.
        around: what to keep clear of.
        forearm: length a6, [unit].
        slide: how much longer or shorter it may be, [unit].
        reached: places to look at (n,).
        touching: (n,), False at first; written.
    """
    capsules = arm.capsules
    count, moving = len(around.margins), len(capsules) // CAPSULE
    still, widest, out_of_upper, out_of_fore = outline(arm)
    rows = asked_rows(around, moving)
    own = np.empty(DEPTH, np.int32)
    waiting = borrowed(own)
    latest = np.full(moving, -1)  # what each capsule touched last
    likely = still  # the capsule that touched something last: beside its place it does so again
    for i in range(len(reached)):
        if not reached[i]:
            continue
        tool = vec3_at(points, 3 * i)
        beside = True
        for s in rows:
            if s == count - 1 or not is_beside(around, s, arm, tool, widest):
                beside = False
                break
        if beside:
            continue
        pose = pose_of(arm, tool, forearm)
        near = unbounded_near(pose, 0.0, slide)
        if slide > 0:
            near = neighbourhood_of(arm, pose, 0.0, slide)
        for s in rows:
            most = around.margins[s]
            if slide > 0:
                most += (near.by_slide + 1) * slide
            upper, fore = False, False  # whether these are far away
            if s < count - 1:
                a, b = pose.shoulder, pose.elbow
                upper = is_far(around.primitives, s, a, b, out_of_upper + most)
                fore = is_far(around.primitives, s, b, pose.tool, out_of_fore + most)
            if upper and fore:
                continue
            for number in range(still - 1, moving):
                c = likely if number < still else number
                if number == likely:
                    continue
                if upper if capsules[CAPSULE * c] == UPPER_ARM else fore:
                    continue
                if not around.asked[c * count + s]:
                    continue
                need = capsules[CAPSULE * c + 3] + around.margins[s]
                if slide > 0:
                    need += capsule_rates(arm, near, c)[1] * slide
                a, b = capsule_ends(arm, pose, c)
                if s == count - 1:
                    touching[i] = min(a[2], b[2]) - around.floor < need
                elif around.inside[2 * s + 1] == 0:  # a call less for most
                    touching[i] = is_near(around.primitives, s, a, b, need)
                else:
                    row = touched_row(around, s, a, b, need, latest[c], waiting)
                    touching[i] = row >= 0
                    latest[c] = row if row >= 0 else latest[c]
                if touching[i]:
                    likely = c
                    break
            if touching[i]:
                break
    held(own)
