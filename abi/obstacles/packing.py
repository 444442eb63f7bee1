"""Convex primitives packed into the rows of numbers that the kernels take."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import assert_never

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.obstacles.pose import rotation
from abi.obstacles.primitive_kernels import WIDTH
from abi.obstacles.primitive_tree_kernels import TREE, link
from abi.obstacles.primitives import Box, Capsule, Cylinder, Primitive, Sphere


def pack(primitives: tuple[Primitive, ...]) -> FloatArray:
    """Rows of k primitives and their tree, flat (k ``WIDTH``,); see ``primitive_kernels``."""
    rows = np.zeros((len(primitives), WIDTH))
    for row, primitive in zip(rows, primitives, strict=True):
        row[:TREE] = _row(primitive)
    packed = rows.ravel()
    if len(rows):
        link(packed)
    return read_only(packed)


@lru_cache(maxsize=8192)
def _row(primitive: Primitive) -> FloatArray:
    axes = _axes(primitive.wxyz)
    a, b, c, radius, is_cylinder = core = _core(primitive)
    half = [
        abs(axes[k + 6]) * c + math.hypot(axes[k], axes[k + 3]) * a
        if is_cylinder
        else abs(axes[k]) * a + abs(axes[k + 3]) * b + abs(axes[k + 6]) * c + radius
        for k in range(3)
    ]
    (x, y, z), (u, v, w) = primitive.position, half
    row = np.array([x, y, z, *axes, *core, x - u, y - v, z - w, x + u, y + v, z + w])
    assert len(row) == TREE
    return read_only(row)


@lru_cache(maxsize=1024)
def _axes(wxyz: tuple[float, float, float, float]) -> tuple[float, ...]:
    """The body's axes in the world, one after the other (9,)."""
    return tuple(rotation(wxyz).T.ravel().tolist())


def _core(primitive: Primitive) -> tuple[float, float, float, float, float]:
    """Half sizes of the core, the radius around it, and whether it is a cylinder."""
    if isinstance(primitive, Box):
        x, y, z = primitive.size
        return x / 2, y / 2, z / 2, 0.0, 0.0
    if isinstance(primitive, Cylinder):
        return primitive.radius, primitive.radius, primitive.height / 2, 0.0, 1.0
    if isinstance(primitive, Capsule):
        return 0.0, 0.0, primitive.height / 2, primitive.radius, 0.0
    if isinstance(primitive, Sphere):
        return 0.0, 0.0, 0.0, primitive.radius, 0.0
    assert_never(primitive)
