"""Convex solids as rows of numbers: their signed distance, and what comes near to them.

Plain Python that numba compiles with its caller; uncompiled it runs on lists. Mostly numbers and
tuples are handed over, for arrays are counted in and out at every call.

A solid is ``WIDTH`` numbers: centre (3), the body's axes in the world (9), half sizes of its core
(3), radius around the core, 1 for a cylinder and 0 otherwise, its bounds low and high (6). A box
is a core alone, a sphere and a capsule are a core with a radius. A cylinder's core is its own
radius, twice, and its half height.
"""

from __future__ import annotations

import math

from numba.extending import register_jitable

from abi.arrays import FloatArray

WIDTH = 23
"""Numbers that describe a solid."""

Point = tuple[float, float, float]
Core = tuple[float, float, float, float, float]
Axes = tuple[Point, Point, Point]

_STEPS = 90


@register_jitable
def gap(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> float:
    """Distance of two points."""
    return math.sqrt((ax - bx) ** 2 + (ay - by) ** 2 + (az - bz) ** 2)


@register_jitable
def core_of(solids: FloatArray, s: int) -> Core:
    """Half sizes of a solid's core, the radius around it, and whether it is a cylinder."""
    k = WIDTH * s + 12
    return solids[k], solids[k + 1], solids[k + 2], solids[k + 3], solids[k + 4]


@register_jitable
def axes_of(solids: FloatArray, s: int) -> Axes:
    """The body's axes in the world."""
    k = WIDTH * s + 3
    return (
        (solids[k], solids[k + 1], solids[k + 2]),
        (solids[k + 3], solids[k + 4], solids[k + 5]),
        (solids[k + 6], solids[k + 7], solids[k + 8]),
    )


@register_jitable
def in_body(axes: Axes, x: float, y: float, z: float) -> Point:
    """A direction of the world in the body's axes."""
    return (
        axes[0][0] * x + axes[0][1] * y + axes[0][2] * z,
        axes[1][0] * x + axes[1][1] * y + axes[1][2] * z,
        axes[2][0] * x + axes[2][1] * y + axes[2][2] * z,
    )


@register_jitable
def in_world(axes: Axes, x: float, y: float, z: float) -> Point:
    """A direction of the body's axes in the world."""
    return (
        axes[0][0] * x + axes[1][0] * y + axes[2][0] * z,
        axes[0][1] * x + axes[1][1] * y + axes[2][1] * z,
        axes[0][2] * x + axes[1][2] * y + axes[2][2] * z,
    )


@register_jitable
def distance(core: Core, x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """Signed distance of a body point, and a unit subgradient of it."""
    side = 1.0 if x >= 0 else -1.0
    front = 1.0 if y >= 0 else -1.0
    top = 1.0 if z >= 0 else -1.0
    if core[4] == 1:
        wide = math.sqrt(x * x + y * y)
        u, v = (x / wide, y / wide) if wide > 0 else (1.0, 0.0)
        a, c = wide - core[0], abs(z) - core[2]
        if a > 0 and c > 0:
            away = math.sqrt(a * a + c * c)
            return away, a / away * u, a / away * v, c / away * top
        if a >= c:
            return a, u, v, 0.0
        return c, 0.0, 0.0, top
    a, b, c = abs(x) - core[0], abs(y) - core[1], abs(z) - core[2]
    p, q, r = max(a, 0.0), max(b, 0.0), max(c, 0.0)
    away = math.sqrt(p * p + q * q + r * r)
    if away > 0:
        return away - core[3], p / away * side, q / away * front, r / away * top
    if a >= b and a >= c:
        return a - core[3], side, 0.0, 0.0
    if b >= c:
        return b - core[3], 0.0, front, 0.0
    return c - core[3], 0.0, 0.0, top


@register_jitable
def level(core: Core, x: float, y: float, z: float) -> float:
    """Signed distance of a body point."""
    a, b, c = abs(x) - core[0], abs(y) - core[1], abs(z) - core[2]
    if core[4] == 1:
        a = math.sqrt(x * x + y * y) - core[0]
        b = -core[0]
    most = max(a, max(b, c))
    if most > 0:
        a, b, c = max(a, 0.0), max(b, 0.0), max(c, 0.0)
        most = math.sqrt(a * a + b * b + c * c)
    return most - core[3]


@register_jitable
def near(
    core: Core,
    margin: float,
    px: float,
    py: float,
    pz: float,
    dx: float,
    dy: float,
    dz: float,
) -> bool:
    """Whether the segment from p to p + d, in the body's axes, comes nearer than ``margin``.

    The distance is convex along the segment, so a tangent at t bounds it from below: on one side
    of t it stays above the margin, on the other it does so for a known stretch. What is left is
    looked at where the slope is likely to be zero.
    """
    low, high = 0.0, 1.0
    before, falling, after, rising = 0.0, 0.0, 1.0, 0.0  # where the slope was seen last, and what
    square = dx * dx + dy * dy + dz * dz
    # nearest to the centre: what comes too near does so there for the most part
    t = min(max(-(px * dx + py * dy + pz * dz) / square, 0.0), 1.0) if square > 0 else 0.0
    for step in range(_STEPS):
        away, gx, gy, gz = distance(core, px + t * dx, py + t * dy, pz + t * dz)
        if away < margin:
            return True
        slope = gx * dx + gy * dy + gz * dz
        if slope < 0:
            low = max(low, t - (away - margin) / slope)
            before, falling = t, slope
        elif slope > 0:
            high = min(high, t - (away - margin) / slope)
            after, rising = t, slope
        else:
            return False
        if low >= high:
            return False
        if falling == 0:
            t = low
        elif rising == 0:
            t = high
        else:
            t = before - falling * (after - before) / (rising - falling)
            if step % 3 == 2 or t <= low or t >= high:
                t = (low + high) / 2
    return False


@register_jitable
def within(solids: FloatArray, margin: float, x: float, y: float, z: float) -> bool:
    """Whether a point of the world is nearer than ``margin`` to a solid."""
    for s in range(len(solids) // WIDTH):
        k = WIDTH * s
        if (
            x - solids[k + 20] >= margin
            or solids[k + 17] - x >= margin
            or y - solids[k + 21] >= margin
            or solids[k + 18] - y >= margin
            or z - solids[k + 22] >= margin
            or solids[k + 19] - z >= margin
        ):
            continue
        px, py, pz = in_body(
            axes_of(solids, s), x - solids[k], y - solids[k + 1], z - solids[k + 2]
        )
        if level(core_of(solids, s), px, py, pz) < margin:
            return True
    return False


@register_jitable
def apart(
    solids: FloatArray,
    s: int,
    margin: float,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
) -> bool:
    """Whether the bounds of the segment a..b are farther than ``margin`` from those of a solid."""
    k = WIDTH * s + 17
    result: bool = (
        min(ax, bx) - solids[k + 3] >= margin
        or solids[k] - max(ax, bx) >= margin
        or min(ay, by) - solids[k + 4] >= margin
        or solids[k + 1] - max(ay, by) >= margin
        or min(az, bz) - solids[k + 5] >= margin
        or solids[k + 2] - max(az, bz) >= margin
    )
    return result


@register_jitable
def blocked(
    solids: FloatArray,
    margins: FloatArray,
    first: int,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
) -> bool:
    """Whether the segment a..b comes nearer to a solid than that solid's margin.

    Args:
        solids: (k WIDTH,) rows, one after the other.
        margins: [unit]; those of the k solids begin at ``first``.
        first: index.
        ax, ay, az: one end, [unit], world.
        bx, by, bz: the other end.
    """
    return blocker(solids, margins, first, 0, ax, ay, az, bx, by, bz) >= 0


@register_jitable
def blocker(
    solids: FloatArray,
    margins: FloatArray,
    first: int,
    guess: int,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
) -> int:
    """A solid to which the segment a..b comes nearer than that solid's margin, or -1.

    Args:
        solids, margins, first, ax, ay, az, bx, by, bz: see ``blocked``.
        guess: the solid that is looked at first.
    """
    lx, ly, lz = min(ax, bx), min(ay, by), min(az, bz)
    hx, hy, hz = max(ax, bx), max(ay, by), max(az, bz)
    count = len(solids) // WIDTH
    for turn in range(count):
        s = guess if turn == 0 else (turn - 1 if turn <= guess else turn)
        k, margin = WIDTH * s, margins[first + s]
        if (
            lx - solids[k + 20] >= margin
            or solids[k + 17] - hx >= margin
            or ly - solids[k + 21] >= margin
            or solids[k + 18] - hy >= margin
            or lz - solids[k + 22] >= margin
            or solids[k + 19] - hz >= margin
        ):
            continue
        axes = (
            (solids[k + 3], solids[k + 4], solids[k + 5]),
            (solids[k + 6], solids[k + 7], solids[k + 8]),
            (solids[k + 9], solids[k + 10], solids[k + 11]),
        )
        core = (solids[k + 12], solids[k + 13], solids[k + 14], solids[k + 15], solids[k + 16])
        px, py, pz = in_body(axes, ax - solids[k], ay - solids[k + 1], az - solids[k + 2])
        dx, dy, dz = in_body(axes, bx - ax, by - ay, bz - az)
        if near(core, margin, px, py, pz, dx, dy, dz):
            return s
    return -1
