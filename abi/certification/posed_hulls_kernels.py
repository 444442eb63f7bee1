"""Convex bodies of a robot in a pose: where they are, and what they are near.

:func:`abi.robot.bodies.hull_kernels.separation` takes their differences from obstacles and from
each other. What a direction proves is computed anew from all points, so that errors here can lose
a proof but never make a false one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abi.arm_planning.world.collision_world_kernels import (
    NO_OBSTACLES,
    Obstacles,
    open_box,
)
from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, compiled
from abi.curves.clearance.separation_kernels import (
    CERTIFIED,
    REFUTED,
    UNDECIDED,
)
from abi.obstacles.primitive_kernels import BOUNDS, axes_of, centre_of, core_of, in_body, in_world
from abi.obstacles.primitive_kernels import WIDTH as ROW
from abi.obstacles.vector_kernels import Vec3, axpy, sub, vec3_at
from abi.robot.bodies.capsule_table import BODIES, Bodies
from abi.robot.bodies.hull_kernels import APART, OVERLAP, separation
from abi.robot.kinematics.chain_kernels import POSE, TABLE, ChainTable, place_chain

Points = tuple[FloatArray, int, int]
"""Points, flat, the first of a hull and the one behind its last, [unit], world."""


@jitable
def lowest_of(hull: Points, way: Vec3) -> Vec3:
    """Point of a hull that is lowest along a direction."""
    points, first, last = hull
    best, which = math.inf, first
    x, y, z = way
    for k in range(first, last):
        product = x * points[3 * k] + y * points[3 * k + 1] + z * points[3 * k + 2]
        if product < best:
            best, which = product, k
    return vec3_at(points, 3 * which)


@jitable
def radius_of(primitives: FloatArray, s: int) -> float:
    """Radius around a primitive's core, [unit]; 0 of a cylinder, whose core is all of it."""
    core = core_of(primitives, s)
    return 0.0 if core.is_cylinder == 1 else core.radius


@jitable
def from_row(pair: tuple[Points, FloatArray, int], way: Vec3) -> Vec3:
    """Lowest point of a hull less the highest of a primitive's core, without its radius."""
    hull, primitives, s = pair
    core, axes = core_of(primitives, s), axes_of(primitives, s)
    x, y, z = in_body(axes, way)
    c = core.z if z >= 0 else -core.z
    if core.is_cylinder == 1:
        across = math.sqrt(x * x + y * y)
        share = core.x / across if across > 0 else 0.0
        point = (share * x, share * y, c)
    else:
        point = (core.x if x >= 0 else -core.x, core.y if y >= 0 else -core.y, c)
    highest = axpy(1.0, in_world(axes, point), centre_of(primitives, s))
    return sub(lowest_of(hull, way), highest)


@jitable
def from_hull(pair: tuple[Points, Points], way: Vec3) -> Vec3:
    """Lowest point of a hull less the highest of another."""
    hull, other = pair
    return sub(lowest_of(hull, way), lowest_of(other, (-way[0], -way[1], -way[2])))


class HullPose(NamedTuple):
    """Joint positions in the middle of a piece of a motion, and arrays for the hulls there.

    Attributes:
        joints: coordinates (n,).
        ways: farthest that each gets from there on the stretch (n,).
        poses: of the joints, flat (12 (m + 1),).
        points: of all bodies, flat, [unit], world.
        bounds: least and largest coordinates of each body without its radius, flat (6 b,), [unit].
        room: Bézier points of one joint (width,).
    """

    joints: FloatArray
    ways: FloatArray
    poses: FloatArray
    points: FloatArray
    bounds: FloatArray
    room: FloatArray


@jitable
def place_hulls(chain: ChainTable, hulls: Bodies, pose: HullPose) -> None:
    """Write the points of all bodies and their bounds at the joints of a pose."""
    place_chain(chain, pose.joints, 0, pose.poses)
    poses, points, bounds = pose.poses, pose.points, pose.bounds
    for b in range(len(hulls.frames)):
        frame = hulls.frames[b]
        for r in range(3):
            low, high = math.inf, -math.inf
            for k in range(hulls.first[b], hulls.first[b + 1]):
                x, y, z = vec3_at(hulls.points, 3 * k)
                if frame < 0:
                    value = x if r == 0 else y if r == 1 else z
                else:
                    at = POSE * frame + 3 * r
                    value = poses[at] * x + poses[at + 1] * y + poses[at + 2] * z
                    value += poses[POSE * frame + 9 + r]
                value *= hulls.scale
                points[3 * k + r] = value
                low, high = min(low, value), max(high, value)
            bounds[6 * b + r], bounds[6 * b + 3 + r] = low, high


@jitable
def box_gap(bounds: FloatArray, b: int, primitives: FloatArray, s: int) -> tuple[float, Vec3]:
    """Largest gap along an axis between the bounds of body b and of primitive s; its direction."""
    best, way = -math.inf, (0.0, 0.0, 1.0)
    for axis in range(3):
        k = ROW * s + BOUNDS + axis
        above = bounds[6 * b + axis] - primitives[k + 3]
        below = primitives[k] - bounds[6 * b + 3 + axis]
        if max(above, below) > best:
            best, sign = (above, 1.0) if above >= below else (below, -1.0)
            way = (
                sign if axis == 0 else 0.0,
                sign if axis == 1 else 0.0,
                sign if axis == 2 else 0.0,
            )
    return best, way


@jitable
def outcome_of(found: int) -> int:
    """Whether a pair of bodies is proven apart, touches or is undecided, from what its hulls do."""
    return CERTIFIED if found == APART else REFUTED if found == OVERLAP else UNDECIDED


@jitable
def from_body(
    hulls: Bodies, pose: HullPose, pair: int, moves: float, allowance: float
) -> tuple[int, Vec3]:
    """Check whether a direction keeps two bodies apart near a pose."""
    i, j = hulls.pairs[2 * pair], hulls.pairs[2 * pair + 1]
    radii = hulls.roundings[i] + hulls.roundings[j]
    first = pose.points, hulls.first[i], hulls.first[i + 1]
    second = pose.points, hulls.first[j], hulls.first[j + 1]
    near, far = max(radii - 2 * allowance, 0.0), radii + moves + 2 * allowance
    found, _, way = separation(from_hull, (second, first), (0.0, 0.0, 1.0), near, far, False)
    return outcome_of(found), way


@jitable
def new_pose(chain: ChainTable, hulls: Bodies, count: int, width: int) -> HullPose:
    """Arrays for one pose, not yet filled."""
    poses, points = np.empty(POSE * (len(chain.source) + 1)), np.empty(len(hulls.points))
    return HullPose(
        *(np.empty(count), np.zeros(count), poses, points, np.empty(6 * len(hulls.frames))),
        np.empty(width),
    )


@compiled(example=(TABLE, BODIES, FLOATS, 1), fallback=False)
def hulls_touch(chain: ChainTable, hulls: Bodies, joints: FloatArray, count: int) -> int:
    """Number of poses in which a pair of bodies overlaps.

    Args:
        chain: the chain.
        hulls: its bodies and pairs of them.
        joints: coordinates of the poses, flat (k n,).
        count: their number n.
    """
    pose, touching = new_pose(chain, hulls, count, 1), 0
    for sample in range(len(joints) // count):
        for j in range(count):
            pose.joints[j] = joints[sample * count + j]
        place_hulls(chain, hulls, pose)
        for pair in range(len(hulls.pairs) // 2):
            if from_body(hulls, pose, pair, 0.0, 0.0)[0] == REFUTED:
                touching += 1
                break
    return touching


NearestPair = tuple[float, int, int]
"""Distance [unit], pair and number of the pose at which a body is nearest to an obstacle."""


@compiled(example=(TABLE, BODIES, FLOATS, 1, NO_OBSTACLES), fallback=False)
def nearest_obstacle(
    chain: ChainTable, hulls: Bodies, joints: FloatArray, count: int, around: Obstacles
) -> NearestPair:
    """Least distance of a robot's bodies to an obstacle over some poses.

    Args:
        chain: the chain.
        hulls: its bodies.
        joints: coordinates of the poses, flat (k n,).
        count: their number n.
        around: the obstacles.

    Returns:
        The distance, 0 where a body overlaps an obstacle, inf without obstacles; the pair and the
        pose, -1 without.
    """
    pose, rows = new_pose(chain, hulls, count, 1), len(around.margins)
    best, whose, when = math.inf, -1, -1
    work = [0]
    for sample in range(len(joints) // count):
        for j in range(count):
            pose.joints[j] = joints[sample * count + j]
        place_hulls(chain, hulls, pose)
        for b in range(len(hulls.frames)):
            work.clear()
            for k in range(len(around.outer)):
                s = around.outer[k]
                if s < rows - 1 and around.asked[b * rows + s]:
                    work.append(b * rows + s)
            segment = vec3_at(pose.bounds, 6 * b), vec3_at(pose.bounds, 6 * b + 3)
            hull = pose.points, hulls.first[b], hulls.first[b + 1]
            while len(work) > 0:
                pair = work.pop()
                s = pair % rows
                if box_gap(pose.bounds, b, around.primitives, s)[0] - hulls.roundings[b] >= best:
                    continue
                if open_box(around, pair, 0.0, segment, work):
                    continue
                radii = hulls.roundings[b] + radius_of(around.primitives, s)
                pairing = hull, around.primitives, s
                up, far = (0.0, 0.0, 1.0), best + radii
                _, away, _ = separation(from_row, pairing, up, radii, far, True)
                if max(away - radii, 0.0) < best:
                    best, whose, when = max(away - radii, 0.0), pair, sample
    return best, whose, when
