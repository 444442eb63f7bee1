"""Distances of a URDF arm, hulls and capsules, to its surroundings and to itself, over poses."""

from __future__ import annotations

import math

import numpy as np

from abi.arm_planning.world.collision_world_kernels import NO_OBSTACLES, Obstacles, box_gap
from abi.arm_planning.world.paper_arm_distance_kernels import way
from abi.arrays import FloatArray, IntArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, IDS, NEW_FLOATS, NEW_IDS, compiled
from abi.curves.clearance.separation_kernels import CERTIFIED, REFUTED, UNDECIDED
from abi.obstacles.obstacle_set_kernels import distance_to_segment, nearest_to_segment
from abi.obstacles.primitive_kernels import (
    WIDTH,
    Axes,
    Core,
    axes_of,
    centre_of,
    core_of,
    in_body,
    in_world,
)
from abi.obstacles.triangle_mesh.surface_kernels import (
    NO_SURFACES,
    SurfaceSet,
    most_to_mesh,
    nearest_mesh_to_segment,
    widened,
)
from abi.obstacles.triangle_mesh.surface_tables_kernels import new_room
from abi.obstacles.triangle_mesh.triangle_kernels import DEPTH, between_segments
from abi.obstacles.vector_kernels import Vec3, add, axpy, norm, sub, vec3_at
from abi.robot.bodies.capsule_table import BODIES, Bodies
from abi.robot.bodies.hull_kernels import APART, OVERLAP, lowest_point, separation
from abi.robot.kinematics.chain_kernels import POSE


@jitable
def _highest(core: Core, way: Vec3) -> Vec3:
    """Point of a core without its radius that is highest along a direction, body frame."""
    z = core.z if way[2] >= 0 else -core.z
    if core.is_cylinder == 1:
        across = math.sqrt(way[0] * way[0] + way[1] * way[1])
        if across == 0:
            return core.x, 0.0, z
        return core.x * way[0] / across, core.x * way[1] / across, z
    return (core.x if way[0] >= 0 else -core.x), (core.y if way[1] >= 0 else -core.y), z


@jitable
def _from_row(pair: tuple[Bodies, FloatArray, int, Core, Axes, Vec3], way: Vec3) -> Vec3:
    """Lowest point of a hull less the highest of a row's core, world."""
    bodies, poses, c, core, axes, centre = pair
    highest = add(centre, in_world(axes, _highest(core, in_body(axes, way))))
    return sub(lowest_point(bodies, poses, c, way), highest)


@jitable
def from_centre(around: Obstacles, s: int, a: Vec3, b: Vec3) -> Vec3:
    """Direction from the centre of row s, or from the floor, to a segment's middle."""
    if s == len(around.margins) - 1:
        return 0.0, 0.0, 1.0
    to_middle = sub(axpy(0.5, sub(b, a), a), centre_of(around.primitives, s))
    size = norm(to_middle)
    if size == 0:
        return 0.0, 0.0, 1.0
    return to_middle[0] / size, to_middle[1] / size, to_middle[2] / size


@jitable
def hull_and_row(
    bodies: Bodies,
    poses: FloatArray,
    c: int,
    around: Obstacles,
    s: int,
    way: Vec3,
    near: float,
    far: float,
    exact: bool,
) -> tuple[int, float, Vec3]:
    """Check if a direction keeps the hull of body c farther than ``far`` from row s, at a pose.

    Args:
        bodies: the bodies.
        poses: of the joints, flat (12 (m + 1),), [m].
        c: number of the body.
        around: what to keep clear of.
        s: its row, the last one for the floor.
        way: a direction from the row to begin with, of length 1.
        near, far: distances of the hull without its rounding, [unit].
        exact: whether a distance between the two is wanted.

    Returns:
        CERTIFIED, REFUTED with a distance below ``near``, or UNDECIDED; the distance; the direction
        from the row.
    """
    if s == len(around.margins) - 1:
        up = (0.0, 0.0, 1.0)
        gap = lowest_point(bodies, poses, c, up)[2] - around.floor
        return CERTIFIED if gap > far else REFUTED if gap < near else UNDECIDED, gap, up
    core, centre = core_of(around.primitives, s), centre_of(around.primitives, s)
    axes = axes_of(around.primitives, s)
    radius = 0.0 if core.is_cylinder == 1 else core.radius
    outcome, gap, way = separation(
        _from_row,
        (bodies, poses, c, core, axes, centre),
        way,
        near + radius,
        far + radius,
        exact,
    )
    if outcome == APART:
        return CERTIFIED, gap - radius, way
    return REFUTED if outcome == OVERLAP else UNDECIDED, gap - radius, way


@compiled(example=(BODIES, FLOATS, FLOATS, NO_OBSTACLES, IDS, FLOATS, NEW_FLOATS, NEW_IDS))
def hull_clearances(
    bodies: Bodies,
    poses: FloatArray,
    ends: FloatArray,
    around: Obstacles,
    asked: IntArray,
    lowest: FloatArray,
    distances: FloatArray,
    rows: IntArray,
) -> None:
    """Distances of hulls, with their roundings, to what their capsules are to keep clear of.

    Only the nearest of a pose is measured, and what may touch: the distance of another is inf.

    Args:
        bodies: the bodies.
        poses: of the joints at each of n poses, flat (12 (m + 1) n,), [m].
        ends: of all capsules at each, flat (6 c n,), [unit], world.
        around: what to keep clear of.
        asked: number of a pose and of a body, flat (2 k,), those of a pose together.
        lowest: what each distance is not below, (k,), [unit]; a hull of which that is below 0 is
            measured whether or not it is the nearest.
        distances: (k,), [unit], 0 where they overlap; written.
        rows: the nearest row of each, -1 where the distance is inf, (k,); written.
    """
    size, capsules, count = POSE * (bodies.moving + 1), len(bodies.frames), len(around.margins)
    waiting, least = np.empty(DEPTH + count, np.int32), math.inf
    latest = np.full(capsules, -1, np.int32)  # the row that each hull was nearest to
    for k in range(len(distances)):
        if k == 0 or asked[2 * k] != asked[2 * k - 2]:
            least = math.inf
        distances[k], rows[k] = math.inf, -1
        if lowest[k] > least:
            continue
        at, c = asked[2 * k] * size, asked[2 * k + 1]
        placed, first = poses[at : at + size], 6 * (asked[2 * k] * capsules + c)
        a, b = vec3_at(ends, first), vec3_at(ends, first + 3)
        enough = math.inf if lowest[k] < 0 else least
        best, nearest, open_, likely = bodies.roundings[c] + enough, -1, 0, -1
        for one in range(len(around.outer)):
            if around.asked[c * count + around.outer[one]]:
                waiting[open_] = around.outer[one]
                if waiting[open_] == latest[c]:  # the last comes first
                    likely = open_
                open_ += 1
        if likely >= 0:
            waiting[likely], waiting[open_ - 1] = waiting[open_ - 1], waiting[likely]
        while open_ > 0:
            open_ -= 1
            s = waiting[open_]
            # the hull is not in the capsule where this is exactly as wide
            gap = -math.inf if s == count - 1 else box_gap(around.primitives, s, a, b)
            if gap - 1.01 * bodies.radii[c] > best:
                continue
            if s < count - 1 and around.inside[2 * s + 1] > 0:
                for row in range(around.inside[2 * s], around.inside[2 * s + 1]):
                    waiting[open_] = row
                    open_ += 1
                continue
            way = from_centre(around, s, a, b)
            _, away, _ = hull_and_row(bodies, placed, c, around, s, way, 0.0, best, True)
            if away < best:
                best, nearest = away, s
        if nearest >= 0:
            latest[c] = nearest
            distances[k], rows[k] = max(best - bodies.roundings[c], 0.0), nearest
            least = min(least, distances[k])


_AHEAD = 8.0
"""Distance looked beyond what counts, in ways to the pose before: so that it is seldom."""


@compiled(example=(FLOATS, FLOATS, FLOATS, NO_SURFACES, 1.0, NEW_FLOATS, NEW_IDS))
def link_distances(
    ends: FloatArray,
    radii: FloatArray,
    primitives: FloatArray,
    surfaces: SurfaceSet,
    enough: float,
    distances: FloatArray,
    rows: IntArray,
) -> None:
    """Least signed distance of each capsule to an obstacle, and whose it is.

    Of a capsule that touches nothing and is not the nearest of its pose the distance may be inf.
    One that has been far away is not measured again before it has come near by its own way.

    Args:
        ends: of each pose both ends of the capsules, flat (6 n c,), [unit], world.
        radii: of the capsules (c,), [unit].
        primitives: rows (k WIDTH,).
        surfaces: the meshes.
        enough: distances above it may be inf, too, [unit]; above 0.
        distances: (n c,), [unit], inf without obstacles; written.
        rows: (n c,) number of the primitive or, after these, of the mesh; -1 where the distance is
            inf; written.
    """
    own = new_room()
    room = borrowed(own)
    moving, count = len(radii), len(primitives) // WIDTH
    least_yet = [-math.inf] * moving  # what each capsule's distance is not below
    latest = [-1] * moving  # the primitive that each was nearest to
    likely = 0  # the nearest capsule of the pose before
    for i in range(len(distances) // moving):
        least, first = enough, likely
        for number in range(moving + 1):
            c = first if number == 0 else number - 1
            if number > 0 and c == first:
                continue
            k = i * moving + c
            moved = way(ends, k, k - moving) if i > 0 else 0.0
            least_yet[c] -= moved
            distances[k], rows[k] = math.inf, -1
            counts = max(least, 0.0)
            if least_yet[c] > counts:
                continue
            a, b = vec3_at(ends, 6 * k), vec3_at(ends, 6 * k + 3)
            best, whose = 2 * counts + _AHEAD * moved + radii[c], -1
            if latest[c] >= 0:
                away = distance_to_segment(primitives, latest[c], best, a, b)
                best, whose = (away, latest[c]) if away < best else (best, -1)
            away, row = nearest_to_segment(primitives, best, a, b)
            if row >= 0:
                best, whose = away, row
            latest[c] = whose
            if len(surfaces.whose) > 0:
                most = most_to_mesh(surfaces, most_to_mesh(surfaces, best, a), b)
                away, mesh = nearest_mesh_to_segment(surfaces, widened(most), a, b, room)
                if mesh >= 0 and away < best:
                    best, whose = away, count + mesh
            least_yet[c] = best - radii[c]
            if whose >= 0:
                distances[k], rows[k] = best - radii[c], whose
                if distances[k] < least:
                    least, likely = distances[k], c
    held(own)


_WIDER = 1 + 2.0**-30
"""Factor of a ball around a capsule: its ends are rounded at each pose."""


@compiled(example=(FLOATS, FLOATS, IDS, 1.0, NEW_FLOATS))
def pair_distances(
    ends: FloatArray, radii: FloatArray, pairs: IntArray, enough: float, distances: FloatArray
) -> None:
    """Signed distance between the capsules of each pair.

    A pair that was far apart is not measured again before its own ways may have brought it near,
    nor while the balls around both are farther apart than is enough.

    Args:
        ends: of each pose both ends of the capsules, flat (6 n c,), [unit].
        radii: of the capsules (c,), [unit].
        pairs: numbers of the capsules, flat (2 p,).
        enough: distances above it may be inf, [unit].
        distances: (n p,), [unit]; written.
    """
    count, moving = len(pairs) // 2, len(radii)
    least_yet, moved = np.full(count, -math.inf), np.zeros(moving)
    sizes = np.zeros(moving)  # radii of balls around the capsules
    for c in range(min(moving, len(ends) // 6)):
        half = norm(sub(vec3_at(ends, 6 * c + 3), vec3_at(ends, 6 * c))) / 2
        sizes[c] = (half + radii[c]) * _WIDER
    for i in range(len(distances)):
        pair, pose = i % count, i // count * moving
        if pair == 0 and pose > 0:
            for c in range(moving):
                moved[c] = way(ends, pose + c, pose + c - moving)
        first, second = pairs[2 * pair], pairs[2 * pair + 1]
        least_yet[pair] -= moved[first] + moved[second]
        if least_yet[pair] > enough:
            distances[i] = math.inf
            continue
        row, other = 6 * (pose + first), 6 * (pose + second)
        p, q = vec3_at(ends, row), vec3_at(ends, other)
        d, e = sub(vec3_at(ends, row + 3), p), sub(vec3_at(ends, other + 3), q)
        if norm(sub(axpy(0.5, e, q), axpy(0.5, d, p))) > enough + sizes[first] + sizes[second]:
            distances[i], least_yet[pair] = math.inf, enough
            continue
        distances[i] = norm(between_segments(p, d, q, e)) - radii[first] - radii[second]
        least_yet[pair] = distances[i]
