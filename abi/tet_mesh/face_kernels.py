"""What lies over the faces of a box: where nothing but the distance to one face counts.

Plain Python that numba compiles with its caller. Places p and steps r are in the body's axes, cores
as in ``primitive_kernels`` but no cylinder's. A capsule's and a sphere's core has no thickness, so
that nothing lies over its sides.
"""

from __future__ import annotations

from numba.extending import register_jitable

from abi.obstacles.primitive_kernels import Core

LONG = 1e7
"""Steps, more than any line has."""


@register_jitable
def _stay(p: float, r: float, limit: float) -> float:
    """For how many steps r, from p, a number stays within -limit..limit; -1 if it is not there."""
    if not -limit <= p <= limit:
        return -1.0
    ahead = limit - p if r > 0 else limit + p
    return ahead / abs(r) if ahead < LONG * abs(r) else LONG


@register_jitable
def stretch_in(
    core: Core, margin: float, px: float, py: float, pz: float, rx: float, ry: float, rz: float
) -> float:
    """For how many steps r, from p, a line stays in what is over, and under, the faces of a box.

    For the face that p is over; -1 where it is over none.
    """
    over = margin + core[3]
    a, b, c = abs(px) - core[0], abs(py) - core[1], abs(pz) - core[2]
    x, y, z = core[0], core[1], core[2]
    if a >= b and a >= c:
        x += over
    elif b >= c:
        y += over
    else:
        z += over
    return min(_stay(px, rx, x), min(_stay(py, ry, y), _stay(pz, rz, z)))


@register_jitable
def stretch_along(
    core: Core,
    margin: float,
    reach: float,
    aside: tuple[float, ...],
    px: float,
    py: float,
    pz: float,
    rx: float,
    ry: float,
    rz: float,
) -> float:
    """For how many steps r, from p, a line stays over a face of a box, away from its sides.

    No edge from there that leads to a free node comes too near. p is not excluded; -1 where it is
    not over a face like that, or where the box is so thin that an edge could lead through it.
    ``aside`` is how far edges lead along y and z that lead along x at all, and so on, and ``reach``
    how far they lead.
    """
    over = margin + core[3]
    a, b, c = abs(px) - core[0], abs(py) - core[1], abs(pz) - core[2]
    x, y, z = core[0], core[1], core[2]
    if a >= b and a >= c:
        p, r, thick = px, rx, x + over
        many = min(_stay(py, ry, y - aside[0]), _stay(pz, rz, z - aside[1]))
    elif b >= c:
        p, r, thick = py, ry, y + over
        many = min(_stay(px, rx, x - aside[2]), _stay(pz, rz, z - aside[3]))
    else:
        p, r, thick = pz, rz, z + over
        many = min(_stay(px, rx, x - aside[4]), _stay(py, ry, y - aside[5]))
    if 2 * thick <= reach or abs(p) < thick:
        return -1.0
    return min(many, (abs(p) - thick) / abs(r)) if p * r < 0 else many


@register_jitable
def beside(
    core: Core,
    margin: float,
    px: float,
    py: float,
    pz: float,
    qx: float,
    qy: float,
    qz: float,
) -> bool:
    """Whether p and q are beyond the same face of a box by the margin, and all between them is."""
    over = margin + core[3]
    x, y, z = core[0] + over, core[1] + over, core[2] + over
    return (
        (px >= x and qx >= x)
        or (px <= -x and qx <= -x)
        or (py >= y and qy >= y)
        or (py <= -y and qy <= -y)
        or (pz >= z and qz >= z)
        or (pz <= -z and qz <= -z)
    )
