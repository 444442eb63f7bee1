"""A surface as kernels take it, its place in the world, and room for what they ask of it.

What is asked in the world is answered in the surface's body frame: centred on its bounding box, in
the unit of its file.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.obstacles.primitive_kernels import Axes, in_body
from abi.obstacles.triangle_mesh.bvh import NO_DIPOLES, NO_TREE, Dipoles, TriangleTree
from abi.obstacles.triangle_mesh.closest_point_kernels import DEPTH
from abi.obstacles.triangle_mesh.distance_grid_kernels import NO_GRID, DistanceGrid
from abi.obstacles.vector_kernels import Vec3, sub

SAMPLES = 32
"""Parts into which a segment that enters a solid is cut to bound its depth."""

TOUCHING = 1e-12
"""Part of the surface's size that counts as touching it."""


class SurfaceTables(NamedTuple):
    """A surface as the kernels take it, in its body frame.

    Attributes:
        tree: over its triangles.
        dipoles: of the nodes of the tree.
        grid: signed distances around it.
        closed: whether it has an inside.
        extent: longest side of its bounding box.
        error: bound of the error of a point's distance where that is 0, and of what it grows by
            with the distance.
    """

    tree: TriangleTree
    dipoles: Dipoles
    grid: DistanceGrid
    closed: bool
    extent: float
    error: tuple[float, float]


class Placement(NamedTuple):
    """Pose of the body frame in the world.

    Attributes:
        origin: its origin, [unit], world.
        axes: its axes, in the world.
        factor: scene's [unit] per unit of the body frame.
    """

    origin: Vec3
    axes: Axes
    factor: float


class DescentWorkspace(NamedTuple):
    """Room for descents of a tree.

    Attributes:
        waiting: (``DEPTH``,) nodes.
        squares: (``DEPTH``,) their squared distances.
        stack: (128,) nodes of a tree of dipoles.
        latest: (1,) place of the triangle that the last segment was too near to, or -1: the next
            one, beside it, often is, too.
        nearest: (1,) place of the triangle that the last point was nearest to, or -1.
        samples: (``SAMPLES`` + 1,) signed distances along a segment, or bounds of them from below.
        known: (``SAMPLES`` + 1,) which are no bounds.
    """

    waiting: IntArray
    squares: FloatArray
    stack: IntArray
    latest: IntArray
    nearest: IntArray
    samples: FloatArray
    known: BoolArray


NO_TABLES = SurfaceTables(NO_TREE, NO_DIPOLES, NO_GRID, True, 1.0, (0.0, 0.0))
"""In an example: a surface."""

NO_PLACEMENT = Placement((0.0, 0.0, 0.0), ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), 1.0)
"""In an example: a placement."""


@jitable
def new_room() -> DescentWorkspace:
    """Room for descents."""
    waiting, stack = np.empty(DEPTH, np.int32), np.empty(128, np.int32)
    latest, nearest = np.full(1, -1, np.int32), np.full(1, -1, np.int32)
    samples, known = np.empty(SAMPLES + 1), np.zeros(SAMPLES + 1, np.bool_)
    return DescentWorkspace(waiting, np.empty(DEPTH), stack, latest, nearest, samples, known)


@jitable
def to_surface(placement: Placement, p: Vec3) -> Vec3:
    """A point of the world in the body frame."""
    x, y, z = in_body(placement.axes, sub(p, placement.origin))
    return x / placement.factor, y / placement.factor, z / placement.factor
