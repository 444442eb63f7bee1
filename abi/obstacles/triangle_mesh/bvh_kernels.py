"""Order of the triangles in a bounding volume hierarchy: boxes are halved at their medians."""

from __future__ import annotations

from numba.extending import register_jitable

from abi.arrays import FloatArray, IntArray
from abi.compiled import FLOATS, NEW_FLOATS, NEW_IDS, compiled


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
