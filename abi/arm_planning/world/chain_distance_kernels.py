"""Distances of a URDF arm's capsules to all obstacles and to each other, over many poses."""

from __future__ import annotations

import math

from abi.arm_planning.world.paper_arm_distance_kernels import way
from abi.arrays import FloatArray, IntArray
from abi.compilation.borrowed import borrowed, held
from abi.compiled import FLOATS, IDS, NEW_FLOATS, NEW_IDS, compiled
from abi.obstacles.obstacle_set_kernels import distance_to_segment, nearest_to_segment
from abi.obstacles.primitive_kernels import WIDTH
from abi.obstacles.surface_set import NO_SURFACES, SurfaceSet
from abi.obstacles.surface_set_kernels import most_to_mesh, nearest_mesh_to_segment, widened
from abi.obstacles.triangle_mesh.surface_tables_kernels import new_room
from abi.obstacles.triangle_mesh.triangle_kernels import between_segments
from abi.obstacles.vector_kernels import norm, sub, vec3_at

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


@compiled(example=(FLOATS, FLOATS, IDS, NEW_FLOATS))
def pair_distances(
    ends: FloatArray, radii: FloatArray, pairs: IntArray, distances: FloatArray
) -> None:
    """Signed distance between the capsules of each pair.

    Args:
        ends: of each pose both ends of the capsules, flat (6 n c,), [unit].
        radii: of the capsules (c,), [unit].
        pairs: numbers of the capsules, flat (2 p,).
        distances: (n p,), [unit]; written.
    """
    count, moving = len(pairs) // 2, len(radii)
    for i in range(len(distances)):
        k = 2 * (i % count)
        first, second = pairs[k], pairs[k + 1]
        row, other = 6 * (i // count * moving + first), 6 * (i // count * moving + second)
        p, q = vec3_at(ends, row), vec3_at(ends, other)
        d, e = sub(vec3_at(ends, row + 3), p), sub(vec3_at(ends, other + 3), q)
        distances[i] = norm(between_segments(p, d, q, e)) - radii[first] - radii[second]
