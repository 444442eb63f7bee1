"""Convex solids as the rows of numbers by which the kernels know them."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.obstacles.memory import ByIdentity
from abi.obstacles.pose import rotation
from abi.obstacles.primitive_kernels import WIDTH
from abi.obstacles.primitives import Box, Capsule, Cylinder, MeshShape, Obstacles, Sphere

Solid = Box | Sphere | Cylinder | Capsule

_NONE = read_only(np.zeros(0))


@ByIdentity
def rows(obstacles: Obstacles) -> FloatArray:
    """The rows of the convex solids among the obstacles; see :func:`packed`."""
    return packed(parted(obstacles)[0])


@ByIdentity
def meshes(obstacles: Obstacles) -> tuple[MeshShape, ...]:
    """The triangle meshes among the obstacles."""
    return parted(obstacles)[1]


def parted(obstacles: Obstacles) -> tuple[tuple[Solid, ...], tuple[MeshShape, ...]]:
    """The convex solids among the obstacles, and the triangle meshes."""
    solids = tuple(shape for shape in obstacles if not isinstance(shape, MeshShape))
    if len(solids) == len(obstacles):
        return solids, ()
    return solids, tuple(shape for shape in obstacles if isinstance(shape, MeshShape))


def packed(solids: tuple[Solid, ...]) -> FloatArray:
    """The rows of the solids, one after the other, (k ``WIDTH``,); see ``primitive_kernels``."""
    if len(solids) == 1:
        return _row(solids[0])
    return read_only(np.concatenate([_row(solid) for solid in solids])) if solids else _NONE


@lru_cache(maxsize=1024)
def _row(solid: Solid) -> FloatArray:
    axes = _axes(solid.wxyz)
    a, b, c, radius, is_cylinder = core = _core(solid)
    reach = [
        abs(axes[k + 6]) * c + math.hypot(axes[k], axes[k + 3]) * a
        if is_cylinder
        else abs(axes[k]) * a + abs(axes[k + 3]) * b + abs(axes[k + 6]) * c + radius
        for k in range(3)
    ]
    (x, y, z), (u, v, w) = solid.position, reach
    row = np.array([x, y, z, *axes, *core, x - u, y - v, z - w, x + u, y + v, z + w])
    assert len(row) == WIDTH
    return read_only(row)


@lru_cache(maxsize=1024)
def _axes(wxyz: tuple[float, float, float, float]) -> tuple[float, ...]:
    """The body's axes in the world, one after the other (9,)."""
    return tuple(rotation(wxyz).T.ravel().tolist())


def _core(solid: Solid) -> tuple[float, float, float, float, float]:
    """Half sizes of the core, the radius around it, and whether it is a cylinder."""
    if isinstance(solid, Box):
        x, y, z = solid.size
        return x / 2, y / 2, z / 2, 0.0, 0.0
    if isinstance(solid, Cylinder):
        return solid.radius, solid.radius, solid.height / 2, 0.0, 1.0
    height = solid.height if isinstance(solid, Capsule) else 0.0
    return 0.0, 0.0, height / 2, solid.radius, 0.0
