"""Order of triangles in a bounding volume hierarchy, and the slabs of its nodes.

Their boxes are cut in two, each part again, and so on, where that is cheapest to search by the
surface area heuristic: a line meets a box about as often as its surface is large, and then each box
within is looked at. Of all cuts, those between bins along the three axes are compared (Wald, On
fast construction of SAH-based bounding volume hierarchies, 2007).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, IDS, NEW_FLOATS, NEW_IDS, compiled
from abi.obstacles.vector_kernels import Vec3, add, cross, dot, norm, sub, triangle_at, vec3_at

BINS = 16
"""Bins along each axis."""

MOST = 12
"""Boxes that a leaf has at most."""


class _Bins(NamedTuple):
    """Bins along the axes, one axis after the other.

    A box belongs to a bin by its middle along the axis.

    Attributes:
        lows: (3,) least middle.
        spans: (3,) largest middle less that.
        counts: (3 ``BINS``,) number of boxes.
        boxes: what encloses them, flat (6 · 3 ``BINS``,).
        costs: (``BINS``,) of what is behind a cut before a bin.
        around: two boxes, flat (12,).
    """

    lows: FloatArray
    spans: FloatArray
    counts: IntArray
    boxes: FloatArray
    costs: FloatArray
    around: FloatArray


@jitable
def _empty(boxes: FloatArray, box: int) -> None:
    """Make a box empty, so that it grows with what it is to enclose."""
    for k in range(box, box + 3):
        boxes[k], boxes[k + 3] = math.inf, -math.inf


@jitable
def _enclose(boxes: FloatArray, box: int, others: FloatArray, other: int) -> None:
    """Grow a box to enclose another one, too."""
    for k in range(3):
        boxes[box + k] = min(boxes[box + k], others[other + k])
        boxes[box + 3 + k] = max(boxes[box + 3 + k], others[other + 3 + k])


@jitable
def _middle(boxes: FloatArray, box: int, axis: int) -> float:
    """Middle of a box along an axis."""
    return float(0.5 * boxes[6 * box + axis] + 0.5 * boxes[6 * box + 3 + axis])


@jitable
def _half_surface(boxes: FloatArray, box: int) -> float:
    """Half of a box's surface."""
    x, y, z = sub(vec3_at(boxes, box + 3), vec3_at(boxes, box))
    return x * y + y * z + z * x


@jitable
def _bin_of(bins: _Bins, axis: int, middle: float) -> int:
    """Number of the bin along an axis."""
    return min(int((middle - bins.lows[axis]) / bins.spans[axis] * BINS), BINS - 1)


@jitable
def _fill(boxes: FloatArray, order: IntArray, first: int, last: int, bins: _Bins) -> None:
    """Put the boxes ``order[first:last]`` into bins."""
    around = bins.around
    _empty(around, 0)
    for i in range(first, last):
        for axis in range(3):
            middle = _middle(boxes, order[i], axis)
            around[axis] = min(around[axis], middle)
            around[axis + 3] = max(around[axis + 3], middle)
    for axis in range(3):
        bins.lows[axis], bins.spans[axis] = around[axis], around[axis + 3] - around[axis]
    for b in range(3 * BINS):
        bins.counts[b] = 0
        _empty(bins.boxes, 6 * b)
    for i in range(first, last):
        for axis in range(3):
            if 0.0 < bins.spans[axis] < math.inf:
                b = BINS * axis + _bin_of(bins, axis, _middle(boxes, order[i], axis))
                bins.counts[b] += 1
                _enclose(bins.boxes, 6 * b, boxes, 6 * order[i])


@jitable
def _cheapest_along(bins: _Bins, axis: int, count: int, least: int) -> tuple[float, int]:
    """What the cheapest cut along an axis costs, and the bin behind it; inf where there is none.

    Args:
        bins: filled.
        axis: with a span above 0 that is finite.
        count: number of the boxes.
        least: as many at least are on each side.
    """
    around, costs, begin = bins.around, bins.costs, BINS * axis
    _empty(around, 0)
    _empty(around, 6)
    behind = 0
    for b in range(BINS - 1, 0, -1):
        behind += bins.counts[begin + b]
        _enclose(around, 0, bins.boxes, 6 * (begin + b))
        costs[b] = math.inf
        if least <= behind <= count - least:
            costs[b] = behind * _half_surface(around, 0)
    best, cut, before = math.inf, 0, 0
    for b in range(1, BINS):
        before += bins.counts[begin + b - 1]
        _enclose(around, 6, bins.boxes, 6 * (begin + b - 1))
        if costs[b] < math.inf:
            cost = costs[b] + before * _half_surface(around, 6)
            if cost < best:
                best, cut = cost, b
    return best, cut


@jitable
def _part(
    boxes: FloatArray, order: IntArray, first: int, last: int, bins: _Bins, axis: int, cut: int
) -> int:
    """Put those of ``order[first:last]`` before a cut first; where the others begin."""
    middle = first
    for i in range(first, last):
        if _bin_of(bins, axis, _middle(boxes, order[i], axis)) < cut:
            order[i], order[middle] = order[middle], order[i]
            middle += 1
    return middle


@jitable
def _halve(
    boxes: FloatArray, order: IntArray, first: int, last: int, axis: int, keys: FloatArray
) -> int:
    """Part ``order[first:last]`` at the median along an axis; where the second half begins.

    Quickselect (Hoare, Algorithm 65: FIND, 1961). Pivots are drawn: those of fixed places take
    quadratic time on the rings of which many meshes are made.
    """
    for i in range(first, last):
        keys[i] = _middle(boxes, order[i], axis)
    low, high, middle, drawn = first, last - 1, (first + last) // 2, 1
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
    return middle


@compiled(example=(FLOATS, NEW_FLOATS, NEW_IDS, NEW_IDS))
def order_of_leaves(boxes: FloatArray, keys: FloatArray, order: IntArray, leaves: IntArray) -> None:
    """Order boxes so that those of each node of a complete tree follow one another.

    Each node is cut where that is cheapest to search of all cuts between bins that leave its leaves
    from 1 to ``MOST`` boxes; at the median of its longest axis where there is none.

    Args:
        boxes: lowest and highest corners, flat (6 m,).
        keys: room (m,).
        order: numbers of the boxes (m,); written.
        leaves: where those of each of 2^k leaves begin, and where the last one's end (2^k + 1,);
            written. There are no more leaves than boxes, and at least a ``MOST``-th of them.
    """
    count, width = len(order), len(leaves) - 1
    counts, enclosing = np.empty(3 * BINS, np.int32), np.empty(6 * 3 * BINS)
    own = _Bins(np.empty(3), np.empty(3), counts, enclosing, np.empty(BINS), np.empty(12))
    bins = borrowed(own)
    for i in range(count):
        order[i] = i
    leaves[0], leaves[width] = 0, count
    while width > 1:
        half = width // 2
        for k in range(0, len(leaves) - 1, width):
            first, last = leaves[k], leaves[k + width]
            least = max(half, last - first - MOST * half)
            _fill(boxes, order, first, last, bins)
            axis, cut, best = -1, 0, math.inf
            for a in range(3):
                if 0.0 < bins.spans[a] < math.inf:
                    cost, found = _cheapest_along(bins, a, last - first, least)
                    if cost < best:
                        axis, cut, best = a, found, cost
            if axis >= 0:
                leaves[k + half] = _part(boxes, order, first, last, bins, axis, cut)
            else:
                widest = int(bins.spans.argmax())
                leaves[k + half] = _halve(boxes, order, first, last, widest, keys)
        width = half
    held(own)


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


@compiled(example=(IDS, FLOATS, NEW_FLOATS))
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
