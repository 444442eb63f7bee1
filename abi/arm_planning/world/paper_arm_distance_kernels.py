"""Distances of the paper's arm's capsules to the surroundings, and how deep they are in meshes.

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
from abi.compiled import FLOATS, NEW_FLOATS, NEW_IDS, compiled
from abi.obstacles.obstacle_set_kernels import distance_to_segment
from abi.obstacles.triangle_mesh.surface_distance_kernels import bounds_along, least_distance
from abi.obstacles.triangle_mesh.surface_kernels import (
    NO_SURFACES,
    SurfaceSet,
    meshes_met,
    most_to_mesh,
    nearest_mesh_to_segment,
    surface_at,
    widened,
)
from abi.obstacles.triangle_mesh.surface_tables_kernels import (
    DescentWorkspace,
    Placement,
    SurfaceTables,
    new_room,
    to_surface,
)
from abi.obstacles.vector_kernels import Vec3, distance, vec3_at
from abi.robot.paper_arm.pose_kernels import CAPSULE

_ROUNDING = 1e-12
"""Part, and [unit], by which distances that are compared may be wrong."""


@jitable(forceinline=True)
def way(ends: FloatArray, k: int, before: int) -> float:
    """Upper bound of the displacement of a segment's points between two poses, given as rows."""
    a, b = vec3_at(ends, 6 * k), vec3_at(ends, 6 * k + 3)
    at_a, at_b = vec3_at(ends, 6 * before), vec3_at(ends, 6 * before + 3)
    return (1 + _ROUNDING) * max(distance(a, at_a), distance(b, at_b)) + _ROUNDING


@compiled(example=(FLOATS, FLOATS, NO_OBSTACLES, 0.0, NEW_FLOATS, NEW_IDS))
def capsule_clearances(
    ends: FloatArray,
    capsules: FloatArray,
    around: Obstacles,
    enough: float,
    clearances: FloatArray,
    nearest: IntArray,
) -> None:
    """Least signed distance of capsules' surfaces to what they are to keep clear of.

    Of a capsule that touches nothing and is not the nearest of its pose the distance may be inf.
    One that has been far away is not measured again before it has come near by its own way.

    Args:
        ends: of each pose both ends of the capsules, flat (6 n c,), [unit], world.
        capsules: rows (4 c,).
        around: the obstacles; the last one is the floor.
        enough: distances above it may be inf, too, [unit]; above 0.
        clearances: (n c,), [unit]; written.
        nearest: (n c,) the nearest obstacle, -1 where there is none; written.
    """
    moving, count = len(capsules) // CAPSULE, len(around.margins)
    rows = asked_rows(around, moving)
    least_yet = np.full(moving, -np.inf)  # what each capsule's clearance is not below
    latest = np.zeros(moving, np.int64)  # what each capsule was nearest to
    likely = 0  # the nearest capsule of the pose before
    for i in range(len(clearances) // moving):
        least, first = enough, likely
        for number in range(moving + 1):
            c = first if number == 0 else number - 1
            if number > 0 and c == first:
                continue
            k = i * moving + c
            if i > 0:
                least_yet[c] -= way(ends, k, k - moving)
            clearances[k], nearest[k] = math.inf, -1
            if least_yet[c] > max(least, 0.0):
                continue
            radius = capsules[CAPSULE * c + 3]
            a, b = vec3_at(ends, 6 * k), vec3_at(ends, 6 * k + 3)
            # as far again as it counts, so that it need not be measured again soon
            best, whose = 2 * max(least, 0.0) + radius, -1
            beyond = math.inf
            # what was nearest at the pose before rules out most of the others
            for turn in range(len(rows) + 1):
                s = latest[c] if turn == 0 else rows[turn - 1]
                if not around.asked[c * count + s] or (turn > 0 and s == latest[c]):
                    continue
                if s == count - 1:
                    away = min(a[2], b[2]) - around.floor
                else:
                    away = box_gap(around.primitives, s, a, b)
                    if away < best:
                        away = distance_to_segment(around.primitives, s, best, a, b)
                beyond = min(beyond, away)
                if away < best:
                    best, whose = away, s
            least_yet[c] = beyond - radius
            if whose < 0:
                continue
            clearances[k], nearest[k], latest[c] = best - radius, whose, whose
            if clearances[k] < least:
                least, likely = clearances[k], c


_STRIDE = 8
"""One pose in so many bounds the least clearance of all beforehand."""

_SURELY = 1e-7
"""Part of a capsule's length by which it is nearer to a mesh that it touches beyond doubt."""


@compiled(example=(FLOATS, FLOATS, NO_SURFACES, NEW_FLOATS, NEW_IDS))
def capsules_near_meshes(
    ends: FloatArray,
    capsules: FloatArray,
    surfaces: SurfaceSet,
    clearances: FloatArray,
    nearest: IntArray,
) -> None:
    """Lower the clearances of capsules to those from meshes that are nearer.

    Only the least of all counts, and, of poses one after the other at which a capsule touches the
    same mesh, the least of these; others may stay, or be 0 where a mesh is touched.

    Args:
        ends: of each pose both ends of the capsules, flat (6 n c,), [unit], world.
        capsules: rows (4 c,).
        surfaces: the meshes, at least one.
        clearances: (n c,) from everything else, [unit]; lowered.
        nearest: (n c,) the mesh whose it is, -1 where it stays; written.
    """
    own, moving = new_room(), len(capsules) // CAPSULE
    room = borrowed(own)
    least = _least_beforehand(ends, capsules, surfaces, clearances)
    in_one = np.zeros(len(clearances), np.bool_)  # mesh, surely, and in nothing else
    for k in range(len(clearances)):
        nearest[k], radius = -1, capsules[CAPSULE * (k % moving) + 3]
        a, b = vec3_at(ends, 6 * k), vec3_at(ends, 6 * k + 3)
        if clearances[k] > 0 and least <= 0:
            surely, likely = radius - _SURELY * distance(a, b), k >= moving and in_one[k - moving]
            met, mesh = meshes_met(surfaces, surely if likely else radius, a, b, 2, room)
            if met == 0 and (not likely or meshes_met(surfaces, radius, a, b, 1, room)[0] == 0):
                continue
            if met == 1 and (likely or meshes_met(surfaces, surely, a, b, 1, room)[0] == 1):
                clearances[k], nearest[k], in_one[k] = 0.0, mesh, True
                continue
        enough = min(clearances[k], max(least, 0.0)) + radius
        # what is not below a limit may seem to be, by rounding: a little more is asked for
        away, mesh = nearest_mesh_to_segment(surfaces, widened(enough), a, b, room)
        if mesh >= 0 and away <= enough:
            clearances[k], nearest[k] = away - radius, mesh
            least = min(least, clearances[k])
    for c in range(moving):
        radius, k = capsules[CAPSULE * c + 3], c
        while k < len(clearances):
            count = _poses_within(in_one, nearest, k, moving)
            if count > 0:
                tables, placement = surface_at(surfaces, nearest[k])
                at, depth = _deepest(ends, (k, count, moving), radius, tables, placement, room)
                clearances[at] = min(clearances[at], depth)
            k += max(count, 1) * moving
    held(own)


@jitable
def _least_beforehand(
    ends: FloatArray, capsules: FloatArray, surfaces: SurfaceSet, clearances: FloatArray
) -> float:
    """Upper bound of the least clearance."""
    moving = len(capsules) // CAPSULE
    least = math.inf
    for k in range(len(clearances)):
        least = min(least, clearances[k])
    for k in range(len(clearances)):
        if k // moving % _STRIDE == 0 and least > 0:
            radius = capsules[CAPSULE * (k % moving) + 3]
            for end in range(2):
                away = most_to_mesh(surfaces, least + radius, vec3_at(ends, 6 * k + 3 * end))
                least = min(least, away - radius)
    return least


@jitable
def _poses_within(in_one: BoolArray, nearest: IntArray, k: int, stride: int) -> int:
    """Number of poses, from row k on, at which a capsule is in the same mesh and nothing else."""
    end = k
    while end < len(in_one) and in_one[end] and nearest[end] == nearest[k]:
        end += stride
    return (end - k) // stride


@jitable
def _on_surface(placement: Placement, ends: FloatArray, k: int) -> tuple[Vec3, Vec3]:
    """Both ends of a capsule, by its row, in a mesh's body frame."""
    a, b = vec3_at(ends, 6 * k), vec3_at(ends, 6 * k + 3)
    return to_surface(placement, a), to_surface(placement, b)


@jitable
def _deepest(
    ends: FloatArray,
    poses: tuple[int, int, int],
    radius: float,
    tables: SurfaceTables,
    placement: Placement,
    room: DescentWorkspace,
) -> tuple[int, float]:
    """Find the pose at which a capsule is deepest in a mesh, and how deep it is then.

    The grid bounds it at all poses. It is measured where it may be deepest, until it can be deeper
    at no other.

    Args:
        ends: of each pose both ends of the capsules, flat (6 n c,), [unit], world.
        poses: row of the capsule at the first pose, how many poses, and rows of a pose.
        radius: of the capsule, [unit].
        tables: the mesh.
        placement: its pose.
        room: for descents.

    Returns:
        Row of the capsule at that pose, and its clearance then, [unit]; of the first pose, and
        about 0, where it is nowhere less.
    """
    first, count, stride = poses
    bounds = np.empty(count)
    deepest, least = first, radius / placement.factor
    most = least
    for i in range(count):
        p, q = _on_surface(placement, ends, first + i * stride)
        bounds[i], upper = bounds_along(tables, p, q, most, room)
        most = min(most, upper)
    i = int(bounds.argmin())
    while bounds[i] < least:
        k = first + i * stride
        p, q = _on_surface(placement, ends, k)
        away = least_distance(tables, p, q, least, room)
        if away < least:
            deepest, least = k, away
        bounds[i] = math.inf
        i = int(bounds.argmin())
    return deepest, least * placement.factor - radius
