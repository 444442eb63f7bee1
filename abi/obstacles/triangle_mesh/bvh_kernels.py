"""Slabs of the nodes of a bounding volume hierarchy."""

from __future__ import annotations

import math

from abi.arrays import FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, IDS, NEW_FLOATS, compiled
from abi.obstacles.triangle_mesh.triangle_kernels import triangle_at
from abi.obstacles.vector_kernels import Vec3, add, cross, dot, norm, sub, vec3_at


@jitable
def _normal_of(corners: FloatArray, first: int, last: int) -> Vec3:
    """Unit vector along the sum of triangles' normals, each as long as the area; 0 if that is."""
    total = (0.0, 0.0, 0.0)
    for number in range(first, last):
        a, b, c = triangle_at(corners, number)
        total = add(total, cross(sub(b, a), sub(c, a)))
    size = norm(total)
    if size <= 1e-300:
        return (0.0, 0.0, 0.0)
    return (total[0] / size, total[1] / size, total[2] / size)


@compiled(example=(IDS, FLOATS, NEW_FLOATS), fallback=False)
def slabs_of_nodes(leaves: IntArray, corners: FloatArray, slabs: FloatArray) -> None:
    """Slabs of all nodes of a tree, see ``TriangleTree``.

    Args:
        leaves: where the triangles of each leaf begin, and where the last one's end (k + 1,).
        corners: of the triangles, flat (9 m,).
        slabs: flat (5 (2 k - 1),); written.
    """
    count = len(leaves) - 1
    width, node = count, 0
    while width > 0:
        for block in range(count // width):
            first, last = leaves[block * width], leaves[(block + 1) * width]
            normal = _normal_of(corners, first, last)
            top, bottom = -math.inf, math.inf
            for k in range(3 * first, 3 * last):
                height = dot(normal, vec3_at(corners, 3 * k))
                top, bottom = max(top, height), min(bottom, height)
            slabs[5 * node], slabs[5 * node + 1], slabs[5 * node + 2] = normal
            slabs[5 * node + 3], slabs[5 * node + 4] = top, bottom
            node += 1
        width //= 2
