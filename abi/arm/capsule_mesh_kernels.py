"""Distances of the arm's capsules to triangle meshes."""

from __future__ import annotations

import math

from abi.arm.pose_kernels import CAPSULE
from abi.arrays import FloatArray, IntArray
from abi.compiled import FLOATS, NEW_FLOATS, NEW_IDS, compiled
from abi.obstacles.surface_set import NO_SURFACES, SurfaceSet
from abi.obstacles.surface_set_kernels import (
    meshes_met,
    most_to_mesh,
    nearest_mesh_to_segment,
    widened,
)
from abi.obstacles.triangle_mesh.surface_tables_kernels import new_room
from abi.obstacles.vector_kernels import distance, vec3_at

_STRIDE = 8
"""One pose in so many bounds the least clearance of all beforehand."""

_SURELY = 1e-7
"""Part of a capsule's length by which it is nearer to a mesh that it touches beyond doubt."""


@compiled(example=(FLOATS, FLOATS, NO_SURFACES, NEW_FLOATS, NEW_IDS), fallback=False)
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
    room, moving = new_room(), len(capsules) // CAPSULE
    least = math.inf
    for k in range(len(clearances)):
        least = min(least, clearances[k])
    for k in range(len(clearances)):
        if k // moving % _STRIDE == 0 and least > 0:
            radius = capsules[CAPSULE * (k % moving) + 3]
            for end in range(2):
                away = most_to_mesh(surfaces, least + radius, vec3_at(ends, 6 * k + 3 * end))
                least = min(least, away - radius)
    # the only mesh that each capsule touches, if nothing else is, and how deep it has been in it
    within, deepest = [-1] * moving, [0.0] * moving
    for k in range(len(clearances)):
        c = k % moving
        nearest[k], radius = -1, capsules[CAPSULE * c + 3]
        enough = min(clearances[k], max(least, 0.0)) + radius
        a, b = vec3_at(ends, 6 * k), vec3_at(ends, 6 * k + 3)
        before, within[c] = within[c], -1
        if clearances[k] > 0 and least <= 0:
            met, mesh = meshes_met(surfaces, radius, a, b, 2, room)
            if met == 0:
                continue
            surely = radius - _SURELY * distance(a, b)
            if met == 1 and meshes_met(surfaces, surely, a, b, 1, room)[0] == 1:
                clearances[k], nearest[k], within[c] = 0.0, mesh, mesh
                deepest[c] = deepest[c] if mesh == before else 0.0
                enough = deepest[c] + radius
        # what is not below a limit may seem to be, by rounding: a little more is asked for
        away, mesh = nearest_mesh_to_segment(surfaces, widened(enough), a, b, room)
        if mesh >= 0 and away <= enough:
            clearances[k], nearest[k] = away - radius, mesh
            least, deepest[c] = min(least, clearances[k]), clearances[k]
