"""Order of the triangles in a bounding volume hierarchy, and the slabs of its nodes."""

from __future__ import annotations

import math

from numba.extending import register_jitable

from abi.arrays import FloatArray, IntArray
from abi.compiled import FLOATS, IDS, NEW_FLOATS, NEW_IDS, compiled
from abi.obstacles.triangle_mesh.triangle_kernels import triangle_at
from abi.obstacles.vector_kernels import Vec3, add, cross, dot, norm, sub, vec3_at


@register_jitable
def _widest_axis(centres: FloatArray, order: IntArray, first: int, last: int) -> int:
    """Axis along which the centres ``order[first:last]`` spread farthest."""
    axis, widest = 0, -1.0
    for k in range(3):
        low = high = centres[3 * order[first] + k]
        for i in range(first, last):
            value = centres[3 * order[i] + k]
            low, high = min(low, value), max(high, value)
        if high - low > widest:
            axis, widest = k, high - low
    return axis


@register_jitable
def _part(keys: FloatArray, order: IntArray, low: int, high: int, middle: int) -> None:
    """Put what is less than the key that comes at ``middle`` before it, what is more behind.

    Quickselect (Hoare, Algorithm 65: FIND, 1961) from ``low`` to ``high``. Pivots are drawn: those
    of fixed places take quadratic time on the rings of which many meshes are made.
    """
    drawn = 1
    while low < high:
        drawn = (1_103_515_245 * drawn + 12_345) & 0x7FFFFFFF
        pivot = keys[low + drawn % (high - low + 1)]
        i, j = low, high
        while i <= j:
            while keys[i] < pivot:
                i += 1
            while keys[j] > pivot:
                j -= 1
            if i <= j:
                keys[i], keys[j] = keys[j], keys[i]
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if j < middle:
            low = i
        if middle < i:
            high = j


@compiled(example=(FLOATS, 1, NEW_FLOATS, NEW_IDS), fallback=False)
def order_of_leaves(centres: FloatArray, depth: int, keys: FloatArray, order: IntArray) -> None:
    """Order triangles so that those of each box of a complete tree follow one another.

    Boxes are halved at their medians.

    Args:
        centres: of the triangles, flat (3 m,).
        depth: of the tree; its level k has 2^k boxes, as equal in number as can be.
        keys: room (m,).
        order: numbers of the triangles (m,); written.
    """
    count = len(order)
    for i in range(count):
        order[i] = i
    for level in range(depth):
        for block in range(1 << level):
            first, last = (count * block) >> level, (count * (block + 1)) >> level
            axis = _widest_axis(centres, order, first, last)
            for i in range(first, last):
                keys[i] = centres[3 * order[i] + axis]
            _part(keys, order, first, last - 1, (count * (2 * block + 1)) >> (level + 1))


@register_jitable
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
