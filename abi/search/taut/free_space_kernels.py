"""Free space: the box that contains a path, and the convex solids that it keeps away from.

Plain Python that numba compiles with its caller; uncompiled it runs on lists.
"""

from __future__ import annotations

from typing import NamedTuple

from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS
from abi.obstacles.primitive_kernels import WIDTH
from abi.obstacles.primitive_tree_kernels import blocked
from abi.obstacles.vector_kernels import Vec3


class FreeSpace(NamedTuple):
    """Set of points that a path may take.

    Attributes:
        solids: (k WIDTH,) rows, one after the other, see ``abi.obstacles.primitive_kernels``.
        margins: (4k,) distance from each solid that a segment keeps, [unit]: in general, from the
            first point, to the last point, from the first to the last.
        low: low corner of the box, [unit], world.
        high: high corner.
    """

    solids: FloatArray
    margins: FloatArray
    low: Vec3
    high: Vec3


SPACE = FreeSpace(FLOATS, FLOATS, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
"""Example of free space."""


@jitable
def kind_of(i: int, j: int, last: int) -> int:
    """Number of the margin that counts from point i to point j of a path that ends at ``last``."""
    return (1 if i == 0 else 0) + (2 if j == last else 0)


@jitable(inline="always")  # else the arrays are counted in and out: 4 % of ``pull``
def is_clear(space: FreeSpace, kind: int, a: Vec3, b: Vec3) -> bool:
    """Check whether the segment a..b keeps its margins from all solids.

    Args:
        space: free space.
        kind: see :func:`kind_of`.
        a: one end, [unit], world.
        b: the other end.
    """
    count = len(space.solids) // WIDTH
    return not blocked(space.solids, space.margins, kind * count, a, b)


@jitable
def in_bounds(space: FreeSpace, p: Vec3) -> bool:
    """Check whether a point lies in the box."""
    low, high = space.low, space.high
    return low[0] <= p[0] <= high[0] and low[1] <= p[1] <= high[1] and low[2] <= p[2] <= high[2]
