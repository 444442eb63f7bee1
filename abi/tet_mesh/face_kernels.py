"""The space above the faces of a box, where only the distance to one face counts.

Plain Python that numba compiles with its caller. Positions p and steps r are in the body's axes;
cores are those of ``primitive_kernels``, except a cylinder's. The core of a capsule or a sphere has
no thickness, so nothing lies above its sides.
"""

from __future__ import annotations

from abi.compilation.jitable import jitable
from abi.obstacles.primitive_kernels import Core
from abi.obstacles.vector_kernels import Vec3

Aside = tuple[float, float, float, float, float, float]
"""Reach of edges along y and z that lead along x at all, along x and z, and along x and y."""

LONG = 1e7
"""Steps, more than any line has."""


@jitable
def _stay(p: float, r: float, limit: float) -> float:
    """For how many steps r, from p, a number stays within -limit..limit; -1 if it is not there."""
    if not -limit <= p <= limit:
        return -1.0
    ahead = limit - p if r > 0 else limit + p
    return ahead / abs(r) if ahead < LONG * abs(r) else LONG


@jitable
def stretch_in(core: Core, margin: float, p: Vec3, r: Vec3) -> float:
    """For how many steps r, from p, a line stays in what is over, and under, the faces of a box.

    For the face that p is over; -1 where it is over none.
    """
    over = margin + core.radius
    a, b, c = abs(p[0]) - core.x, abs(p[1]) - core.y, abs(p[2]) - core.z
    x, y, z = core.x, core.y, core.z
    if a >= b and a >= c:
        x += over
    elif b >= c:
        y += over
    else:
        z += over
    return min(_stay(p[0], r[0], x), min(_stay(p[1], r[1], y), _stay(p[2], r[2], z)))


@jitable
def stretch_along(core: Core, margin: float, reach: float, aside: Aside, p: Vec3, r: Vec3) -> float:
    """For how many steps r, from p, a line stays over a face of a box, away from its sides.

    No edge from there that leads to a free node comes too near. p is not excluded; -1 where it is
    not over a face like that, or where the box is so thin that an edge could lead through it.
    ``reach`` is how far edges lead.
    """
    over = margin + core.radius
    a, b, c = abs(p[0]) - core.x, abs(p[1]) - core.y, abs(p[2]) - core.z
    x, y, z = core.x, core.y, core.z
    if a >= b and a >= c:
        u, v, thick = p[0], r[0], x + over
        many = min(_stay(p[1], r[1], y - aside[0]), _stay(p[2], r[2], z - aside[1]))
    elif b >= c:
        u, v, thick = p[1], r[1], y + over
        many = min(_stay(p[0], r[0], x - aside[2]), _stay(p[2], r[2], z - aside[3]))
    else:
        u, v, thick = p[2], r[2], z + over
        many = min(_stay(p[0], r[0], x - aside[4]), _stay(p[1], r[1], y - aside[5]))
    if 2 * thick <= reach or abs(u) < thick:
        return -1.0
    return min(many, (abs(u) - thick) / abs(v)) if u * v < 0 else many


@jitable
def beside(core: Core, margin: float, p: Vec3, q: Vec3) -> bool:
    """Check if p and q are beyond the same face of a box by the margin, and all between them is."""
    over = margin + core.radius
    x, y, z = core.x + over, core.y + over, core.z + over
    return (
        (p[0] >= x and q[0] >= x)
        or (p[0] <= -x and q[0] <= -x)
        or (p[1] >= y and q[1] >= y)
        or (p[1] <= -y and q[1] <= -y)
        or (p[2] >= z and q[2] >= z)
        or (p[2] <= -z and q[2] <= -z)
    )
