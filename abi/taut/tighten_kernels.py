"""The tightening of a path between convex solids.

Plain Python that numba compiles with its caller; uncompiled it runs on lists. For the rows of
numbers that describe solids see ``abi.obstacles.primitive_kernels``.
"""

from __future__ import annotations

import math

from numba.extending import register_jitable

from abi.arrays import FloatArray
from abi.obstacles.primitive_kernels import (
    WIDTH,
    axes_of,
    blocked,
    bounds_apart,
    centre_of,
    core_of,
    in_body,
    in_world,
    segment_within,
    signed_distance_gradient,
)
from abi.obstacles.vector_kernels import Vec3, axpy, distance, dot, sub

_STEPS = 14  # halvings when a corner is cut: to 1/16,000 of the leg
_HALVINGS = 24  # when the place is looked for that touches a solid
_LOOK_BACK = 64  # points to which one may be joined
_CLOSELY = 8  # of which so many are tried, and of the others each fourth
_STRIDE = 4
_MOST_POINTS = 256
_SWEEPS = 24
_SETTLING = 4  # sweeps after each round of cuts
_SPLITS = 8
_SETTLED = 1e-6  # part of the length by which a sweep must shorten the path to be followed by one
_GLANCE = 3e-4  # the same, and how many sweeps, for a first look
_GLANCE_SWEEPS = 3


@register_jitable
def _touch(
    solids: FloatArray,
    margins: FloatArray,
    first: int,
    reach: float,
    a: Vec3,
    b: Vec3,
) -> Vec3:
    """Unit normal, in the world, of the solid that the segment a..b touches first from a.

    Zero where none is within ``reach`` of its margin.
    """
    earliest, normal = 2.0, (0.0, 0.0, 0.0)
    for s in range(len(solids) // WIDTH):
        limit = margins[first + s] + reach
        if bounds_apart(solids, s, limit, a, b):
            continue
        axes, core = axes_of(solids, s), core_of(solids, s)
        p = in_body(axes, sub(a, centre_of(solids, s)))
        d = in_body(axes, sub(b, a))
        if not segment_within(core, limit, p, d):
            continue
        low, high = 0.0, 1.0
        for _ in range(_HALVINGS):
            t = (low + high) / 2
            if dot(signed_distance_gradient(core, axpy(t, d, p))[1], d) > 0:
                high = t
            else:
                low = t
        if low < earliest:
            earliest = low
            normal = in_world(axes, signed_distance_gradient(core, axpy(low, d, p))[1])
    return normal


@register_jitable
def _legs(
    x: list[float], y: list[float], z: list[float], i: int, px: float, py: float, pz: float
) -> float:
    """Length of the path from point i - 1 by p to point i + 1."""
    return distance((x[i - 1], y[i - 1], z[i - 1]), (px, py, pz)) + distance(
        (px, py, pz), (x[i + 1], y[i + 1], z[i + 1])
    )


@register_jitable
def _fits(
    x: list[float],
    y: list[float],
    z: list[float],
    i: int,
    px: float,
    py: float,
    pz: float,
    solids: FloatArray,
    margins: FloatArray,
) -> bool:
    """Whether point i can be p: both its legs are clear."""
    count = len(solids) // WIDTH
    before = count if i == 1 else 0
    after = 2 * count if i == len(x) - 2 else 0
    return not blocked(
        solids, margins, before, (x[i - 1], y[i - 1], z[i - 1]), (px, py, pz)
    ) and not blocked(solids, margins, after, (px, py, pz), (x[i + 1], y[i + 1], z[i + 1]))


@register_jitable
def _straightened(
    x: list[float],
    y: list[float],
    z: list[float],
    i: int,
    solids: FloatArray,
    margins: FloatArray,
) -> None:
    """Move point i towards the chord of its neighbours as far as its legs stay clear."""
    before = distance((x[i - 1], y[i - 1], z[i - 1]), (x[i], y[i], z[i]))
    after = distance((x[i], y[i], z[i]), (x[i + 1], y[i + 1], z[i + 1]))
    if before + after == 0:
        return
    share = before / (before + after)
    dx = x[i - 1] + share * (x[i + 1] - x[i - 1]) - x[i]
    dy = y[i - 1] + share * (y[i + 1] - y[i - 1]) - y[i]
    dz = z[i - 1] + share * (z[i + 1] - z[i - 1]) - z[i]
    low, high, step = 0.0, 1.0, 0.5**_STEPS
    for _ in range(_STEPS):
        px, py, pz = x[i] + step * dx, y[i] + step * dy, z[i] + step * dz
        if _fits(x, y, z, i, px, py, pz, solids, margins):
            low = step
        elif low == 0:
            break
        else:
            high = step
        step = (low + high) / 2
    if low > 0:
        x[i] += low * dx
        y[i] += low * dy
        z[i] += low * dz


@register_jitable
def _slid(
    x: list[float],
    y: list[float],
    z: list[float],
    i: int,
    solids: FloatArray,
    margins: FloatArray,
    bounds: FloatArray,
    reach: float,
) -> None:
    """Move point i along the surfaces that its legs touch to where the legs are shortest.

    Both legs stay in the planes in which they touch, so the point moves along the line in which
    these meet; where there is only one plane, along the pull of the legs within it.
    """
    count = len(solids) // WIDTH
    before = count if i == 1 else 0
    after = 2 * count if i == len(x) - 2 else 0
    ax, ay, az = x[i - 1] - x[i], y[i - 1] - y[i], z[i - 1] - z[i]
    bx, by, bz = x[i + 1] - x[i], y[i + 1] - y[i], z[i + 1] - z[i]
    to_a = math.sqrt(ax * ax + ay * ay + az * az)
    to_b = math.sqrt(bx * bx + by * by + bz * bz)
    if to_a == 0 or to_b == 0:
        return
    mx, my, mz = _touch(
        solids, margins, before, reach, (x[i], y[i], z[i]), (x[i - 1], y[i - 1], z[i - 1])
    )
    nx, ny, nz = _touch(
        solids, margins, after, reach, (x[i], y[i], z[i]), (x[i + 1], y[i + 1], z[i + 1])
    )
    wx, wy, wz = my * nz - mz * ny, mz * nx - mx * nz, mx * ny - my * nx
    if wx * wx + wy * wy + wz * wz < 1e-8:
        if nx == 0 and ny == 0 and nz == 0:
            nx, ny, nz = mx, my, mz
        wx, wy, wz = ax / to_a + bx / to_b, ay / to_a + by / to_b, az / to_a + bz / to_b
        into = wx * nx + wy * ny + wz * nz
        wx, wy, wz = wx - into * nx, wy - into * ny, wz - into * nz
    size = math.sqrt(wx * wx + wy * wy + wz * wz)
    if size < 1e-9:
        return
    wx, wy, wz = wx / size, wy / size, wz / size
    # On a line the way from a to b is shortest where the mirror image of b about it is in line.
    along_a = ax * wx + ay * wy + az * wz
    along_b = bx * wx + by * wy + bz * wz
    off_a = math.sqrt(max(to_a * to_a - along_a * along_a, 0.0))
    off_b = math.sqrt(max(to_b * to_b - along_b * along_b, 0.0))
    if off_a + off_b == 0:
        return
    step = (along_a * off_b + along_b * off_a) / (off_a + off_b)
    for _ in range(6):
        px, py, pz = x[i] + step * wx, y[i] + step * wy, z[i] + step * wz
        inside = (
            bounds[0] <= px <= bounds[3]
            and bounds[1] <= py <= bounds[4]
            and bounds[2] <= pz <= bounds[5]
        )
        if (
            inside
            and _legs(x, y, z, i, px, py, pz) < to_a + to_b
            and _fits(x, y, z, i, px, py, pz, solids, margins)
        ):
            x[i], y[i], z[i] = px, py, pz
            return
        step /= 4


@register_jitable
def _settled(
    x: list[float],
    y: list[float],
    z: list[float],
    solids: FloatArray,
    margins: FloatArray,
    bounds: FloatArray,
    sweeps: int,
    settled: float,
) -> None:
    """Drop, straighten and slide the points in turn until the path gets no shorter."""
    count = len(solids) // WIDTH
    length = length_of(x, y, z)
    for _ in range(sweeps):
        i = 1
        while i < len(x) - 1:
            first = ((1 if i == 1 else 0) + (2 if i == len(x) - 2 else 0)) * count
            if not blocked(
                solids,
                margins,
                first,
                (x[i - 1], y[i - 1], z[i - 1]),
                (x[i + 1], y[i + 1], z[i + 1]),
            ):
                x.pop(i)
                y.pop(i)
                z.pop(i)
                continue
            _straightened(x, y, z, i, solids, margins)
            _slid(x, y, z, i, solids, margins, bounds, 1e-3 * length)
            i += 1
        before = length
        length = length_of(x, y, z)
        if before - length < settled * length:
            break


@register_jitable
def _split(
    x: list[float],
    y: list[float],
    z: list[float],
    solids: FloatArray,
    margins: FloatArray,
    worth: float,
) -> bool:
    """Cut each corner, as far from it on both legs, where that wins ``worth``; whether any was."""
    any_cut = False
    i = 1
    while i < len(x) - 1 and len(x) < _MOST_POINTS:
        before = distance((x[i - 1], y[i - 1], z[i - 1]), (x[i], y[i], z[i]))
        after = distance((x[i], y[i], z[i]), (x[i + 1], y[i + 1], z[i + 1]))
        if before == 0 or after == 0:
            i += 1
            continue
        ax, ay, az = (
            (x[i - 1] - x[i]) / before,
            (y[i - 1] - y[i]) / before,
            (z[i - 1] - z[i]) / before,
        )
        bx, by, bz = (x[i + 1] - x[i]) / after, (y[i + 1] - y[i]) / after, (z[i + 1] - z[i]) / after
        # between two bends each takes half of the leg
        high = min(before if i == 1 else before / 2, after if i == len(x) - 2 else after / 2)
        won = 2 - distance((ax, ay, az), (bx, by, bz))
        low, cut = 0.0, worth / max(won, 1e-12)
        if cut < high:
            for _ in range(_STEPS):
                if not blocked(
                    solids,
                    margins,
                    0,
                    (x[i] + cut * ax, y[i] + cut * ay, z[i] + cut * az),
                    (x[i] + cut * bx, y[i] + cut * by, z[i] + cut * bz),
                ):
                    low = cut
                elif low == 0:
                    break
                else:
                    high = cut
                cut = (low + high) / 2
        if low > 0:
            x.insert(i + 1, x[i] + low * bx)
            y.insert(i + 1, y[i] + low * by)
            z.insert(i + 1, z[i] + low * bz)
            x[i] += low * ax
            y[i] += low * ay
            z[i] += low * az
            any_cut = True
            i += 1
        i += 1
    return any_cut


@register_jitable
def _shortcut(
    x: list[float], y: list[float], z: list[float], solids: FloatArray, margins: FloatArray
) -> list[int]:
    """The shortest way from first to last by points of the path that see each other."""
    last = len(x) - 1
    count = len(solids) // WIDTH
    cost = [0.0]
    parent = [0]
    for j in range(1, last + 1):
        best, by = math.inf, j - 1
        for i in range(max(0, j - _LOOK_BACK), j):
            if j - i > _CLOSELY and i % _STRIDE != 0:
                continue
            through = cost[i] + distance((x[i], y[i], z[i]), (x[j], y[j], z[j]))
            first = ((1 if i == 0 else 0) + (2 if j == last else 0)) * count
            if through < best and (
                i == j - 1
                or not blocked(solids, margins, first, (x[i], y[i], z[i]), (x[j], y[j], z[j]))
            ):
                best, by = through, i
        cost.append(best)
        parent.append(by)
    kept = [last]
    while kept[-1] != 0:
        kept.append(parent[kept[-1]])
    return kept[::-1]


@register_jitable
def length_of(x: list[float], y: list[float], z: list[float]) -> float:
    """Length of a path."""
    length = 0.0
    for i in range(1, len(x)):
        length += distance((x[i - 1], y[i - 1], z[i - 1]), (x[i], y[i], z[i]))
    return length


@register_jitable
def tighten(
    x: list[float],
    y: list[float],
    z: list[float],
    solids: FloatArray,
    margins: FloatArray,
    bounds: FloatArray,
    worth: float,
) -> tuple[list[float], list[float], list[float]]:
    """Pull a path taut: never longer, and every new segment clear.

    Skips points that it can do without, then moves each to where its legs are shortest, on the
    planes in which these touch a solid, until the length stops improving. Then cuts the corners:
    around a rounded edge one point becomes several.

    Args:
        x, y, z: (n,) the path, n >= 2, its segments clear, [unit], world.
        solids: (k WIDTH,) rows, one after the other.
        margins: (4k,) distance from each solid that a segment keeps, [unit]: in general, from the
            first point, to the last point, from the first to the last.
        bounds: (6,) low and high corner of the box in which the path stays, [unit].
        worth: part of the length that a cut corner must win; inf for a first look, which cuts none
            and stops sooner.

    Returns:
        The coordinates of the new path, (m,) each.
    """
    kept = _shortcut(x, y, z, solids, margins)
    px, py, pz = [x[i] for i in kept], [y[i] for i in kept], [z[i] for i in kept]
    if worth == math.inf:
        _settled(px, py, pz, solids, margins, bounds, _GLANCE_SWEEPS, _GLANCE)
        return px, py, pz
    _settled(px, py, pz, solids, margins, bounds, _SWEEPS, _SETTLED)
    length = length_of(px, py, pz)
    for _ in range(_SPLITS):
        if not _split(px, py, pz, solids, margins, worth * length):
            break
        _settled(px, py, pz, solids, margins, bounds, _SETTLING, _SETTLED)
    return px, py, pz
