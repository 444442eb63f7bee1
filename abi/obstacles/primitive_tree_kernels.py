"""Tree over convex primitives, so that a query costs no more than what is near it.

The tree is part of the rows (``primitive_kernels``). Each node is a primitive, the largest of those
below it. It has the bounds low and high (6) of all of them, the next row, and the row after all
those below it, -1 at the end; row 0 also has the row to begin with. If there are only a few
primitives, the tree is a chain without branches, and each is looked at in order.

Plain Python that numba compiles with its caller; uncompiled it runs on lists.
"""

from __future__ import annotations

import math

from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.compiled import NEW_FLOATS, compiled
from abi.obstacles.primitive_kernels import (
    BOUNDS,
    WIDTH,
    axes_of,
    centre_of,
    core_of,
    distance_to,
    in_body,
    segment_within,
)
from abi.obstacles.vector_kernels import Vec3, sub, vec3_at

TREE = 23
"""Where a row's numbers of the tree begin: the bounds, and then the rows."""

_NEXT, _AFTER, _ROOT = 29, 30, 31
_CHAIN = 8  # so few primitives have no branches
_ROUNDING = 1e-13


@jitable
def first_row(primitives: FloatArray) -> int:
    """Row with which a walk through the tree begins; -1 without primitives."""
    return int(primitives[_ROOT]) if len(primitives) > 0 else -1


@jitable
def row_below(primitives: FloatArray, s: int) -> int:
    """Row that follows row s; -1 at the end."""
    return int(primitives[WIDTH * s + _NEXT])


@jitable
def row_after(primitives: FloatArray, s: int) -> int:
    """Row that follows all those below row s; -1 at the end."""
    return int(primitives[WIDTH * s + _AFTER])


@jitable
def _apart(rows: FloatArray, k: int, margin: float, low: Vec3, high: Vec3) -> bool:
    """Check whether the box at ``rows[k:]`` is ``margin`` or farther from another along an axis."""
    result: bool = (
        low[0] - rows[k + 3] >= margin
        or rows[k] - high[0] >= margin
        or low[1] - rows[k + 4] >= margin
        or rows[k + 1] - high[1] >= margin
        or low[2] - rows[k + 5] >= margin
        or rows[k + 2] - high[2] >= margin
    )
    return result


@jitable
def _apart_across(rows: FloatArray, k: int, margin: float, a: Vec3, b: Vec3) -> bool:
    """Check whether the box at ``rows[k:]``, widened, is beside a segment, across one of the axes.

    By the separating axis theorem, for a box and a segment (Ericson, Real-Time Collision Detection,
    section 5.3.3); for segments whose own box does not tell.
    """
    dx, dy, dz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    ax, ay, az = a[0] - rows[k], a[1] - rows[k + 1], a[2] - rows[k + 2]
    bx, by, bz = b[0] - rows[k + 3], b[1] - rows[k + 4], b[2] - rows[k + 5]
    ex = rows[k + 3] - rows[k] + 2 * margin
    ey = rows[k + 4] - rows[k + 1] + 2 * margin
    ez = rows[k + 5] - rows[k + 2] + 2 * margin
    u, v, w = abs(dx), abs(dy), abs(dz)
    size = abs(ax) + abs(ay) + abs(az) + abs(bx) + abs(by) + abs(bz)
    pad = _ROUNDING * size * (u + v + w)
    x, y, z = ax + bx, ay + by, az + bz
    result: bool = (
        abs(y * dz - z * dy) > ey * w + ez * v + pad
        or abs(z * dx - x * dz) > ez * u + ex * w + pad
        or abs(x * dy - y * dx) > ex * v + ey * u + pad
    )
    return result


@jitable
def is_leaf(primitives: FloatArray, s: int) -> bool:
    """Check whether nothing is below row s: then its bounds are those of its primitive."""
    k = WIDTH * s
    leaf: bool = primitives[k + _NEXT] == primitives[k + _AFTER]
    return leaf


@jitable
def next_near(primitives: FloatArray, s: int, margin: float, low: Vec3, high: Vec3) -> int:
    """Row after row s, -1 for the first, whose bounds are nearer to a box than ``margin``; or -1.

    What is farther along one of the axes is passed over, with all below it where that is, too.
    """
    s = row_below(primitives, s) if s >= 0 else first_row(primitives)
    while s >= 0:
        if _apart(primitives, WIDTH * s + TREE, margin, low, high):
            s = row_after(primitives, s)
        elif _apart(primitives, WIDTH * s + BOUNDS, margin, low, high):
            s = row_below(primitives, s)
        else:
            return s
    return -1


@jitable(forceinline=True)  # else ``taut_paths`` takes a fifth longer
def next_near_segment(primitives: FloatArray, s: int, margin: float, a: Vec3, b: Vec3) -> int:
    """Row after row s, -1 for the first, that may be nearer to a segment than ``margin``; or -1.

    Args:
        primitives: rows.
        s: row.
        margin: [unit].
        a: one end, [unit], world; it may be the other one, too.
        b: the other end.
    """
    s = row_below(primitives, s) if s >= 0 else first_row(primitives)
    while s >= 0:
        tree, bounds = WIDTH * s + TREE, WIDTH * s + BOUNDS
        if _segment_apart(primitives, tree, margin, a, b):
            s = row_after(primitives, s)
        elif not is_leaf(primitives, s) and _segment_apart(primitives, bounds, margin, a, b):
            s = row_below(primitives, s)
        else:
            return s
    return -1


@jitable
def _segment_apart(rows: FloatArray, k: int, margin: float, a: Vec3, b: Vec3) -> bool:
    """Check whether the segment a..b is certain to be ``margin`` or farther from a box."""
    low = (min(a[0], b[0]), min(a[1], b[1]), min(a[2], b[2]))
    high = (max(a[0], b[0]), max(a[1], b[1]), max(a[2], b[2]))
    return _apart(rows, k, margin, low, high) or _apart_across(rows, k, margin, a, b)


@jitable
def any_within(primitives: FloatArray, margin: float, p: Vec3) -> bool:
    """Check whether any primitive is nearer to a point of the world than ``margin``."""
    s = next_near(primitives, -1, margin, p, p)
    while s >= 0:
        if distance_to(primitives, s, p) < margin:
            return True
        s = next_near(primitives, s, margin, p, p)
    return False


@jitable
def _blocks(primitives: FloatArray, s: int, margin: float, a: Vec3, b: Vec3) -> bool:
    """Check whether the segment a..b comes nearer to primitive s than ``margin``."""
    axes = axes_of(primitives, s)
    p = in_body(axes, sub(a, centre_of(primitives, s)))
    return segment_within(core_of(primitives, s), margin, p, in_body(axes, sub(b, a)))


@jitable
def any_nearer(primitives: FloatArray, margin: float, a: Vec3, b: Vec3) -> bool:
    """Check whether the segment a..b comes nearer to any primitive than ``margin``."""
    s = next_near_segment(primitives, -1, margin, a, b)
    while s >= 0:
        if _blocks(primitives, s, margin, a, b):
            return True
        s = next_near_segment(primitives, s, margin, a, b)
    return False


@jitable
def blocked(primitives: FloatArray, margins: FloatArray, first: int, a: Vec3, b: Vec3) -> bool:
    """Check whether the segment a..b comes nearer to a primitive than that one's margin.

    Args:
        primitives: (k WIDTH,) rows, one after the other.
        margins: [unit]; those of the k primitives begin at ``first``; none is above ``margins[0]``.
        first: index.
        a: one end, [unit], world.
        b: the other end.
    """
    return blocker(primitives, margins, first, -1, a, b) >= 0


@jitable
def blocker(
    primitives: FloatArray, margins: FloatArray, first: int, guess: int, a: Vec3, b: Vec3
) -> int:
    """A primitive to which the segment a..b comes nearer than that one's margin, or -1.

    Args:
        primitives, margins, first, a, b: see :func:`blocked`.
        guess: the primitive that is tried first; -1 for none.
    """
    if (
        guess >= 0
        and not _segment_apart(primitives, WIDTH * guess + BOUNDS, margins[first + guess], a, b)
        and _blocks(primitives, guess, margins[first + guess], a, b)
    ):
        return guess
    most = margins[0] if len(margins) > 0 else 0.0
    s = next_near_segment(primitives, -1, most, a, b)
    while s >= 0 and not _blocks(primitives, s, margins[first + s], a, b):
        s = next_near_segment(primitives, s, most, a, b)
    return s


@compiled(example=(NEW_FLOATS,))
def link(primitives: FloatArray) -> None:
    """Make the tree of the rows, which have none.

    Of the primitives below a node the largest is the node. The others are parted in the middle of
    the longest side of the box around their centres.

    Args:
        primitives: rows (k WIDTH,), k >= 1; written.
    """
    count = len(primitives) // WIDTH
    for s in range(count):
        for i in range(6):
            primitives[WIDTH * s + TREE + i] = primitives[WIDTH * s + BOUNDS + i]
        primitives[WIDTH * s + _NEXT] = primitives[WIDTH * s + _AFTER] = (s + 2) % (count + 1) - 1
    primitives[_ROOT] = 0
    if count <= _CHAIN:
        return
    order = list(range(count))
    primitives[_ROOT] = _largest_first(primitives, order, 0, count)
    pending = [(0, count, -1)]
    while len(pending) > 0:
        first, last, after = pending.pop()
        k = WIDTH * order[first]
        primitives[k + _AFTER] = primitives[k + _NEXT] = after
        if last - first == 1:
            continue
        for i in range(first + 1, last):
            other = WIDTH * order[i] + BOUNDS
            for j in range(3):
                low, high = k + TREE + j, k + TREE + 3 + j
                primitives[low] = min(primitives[low], primitives[other + j])
                primitives[high] = max(primitives[high], primitives[other + 3 + j])
        middle = _part(primitives, order, first + 1, last)
        if middle < last:
            after_first = _largest_first(primitives, order, middle, last)
            pending.append((middle, last, after))
        else:
            after_first = after
        primitives[k + _NEXT] = _largest_first(primitives, order, first + 1, middle)
        pending.append((first + 1, middle, after_first))


@jitable
def _largest_first(primitives: FloatArray, order: list[int], first: int, last: int) -> int:
    """Put the largest of the primitives ``order[first:last]`` first, and return it."""
    at, most = first, -math.inf
    for i in range(first, last):
        low = vec3_at(primitives, WIDTH * order[i] + BOUNDS)
        high = vec3_at(primitives, WIDTH * order[i] + BOUNDS + 3)
        size = (high[0] - low[0]) + (high[1] - low[1]) + (high[2] - low[2])
        if size > most:
            at, most = i, size
    order[first], order[at] = order[at], order[first]
    return order[first]


@jitable
def _part(primitives: FloatArray, order: list[int], first: int, last: int) -> int:
    """Part ``order[first:last]`` in two by place; where the second begins, or ``last``."""
    if last - first == 1:
        return last
    axis, widest, middle = 0, -1.0, 0.0
    for j in range(3):
        low, high = math.inf, -math.inf
        for i in range(first, last):
            centre = primitives[WIDTH * order[i] + j]
            low, high = min(low, centre), max(high, centre)
        if high - low > widest:
            axis, widest, middle = j, high - low, low + (high - low) / 2
    at = first
    for i in range(first, last):
        if primitives[WIDTH * order[i] + axis] < middle:
            order[at], order[i] = order[i], order[at]
            at += 1
    return at if first < at < last else (first + last) // 2
