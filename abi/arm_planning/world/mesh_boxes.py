"""Boxes that stand for a triangle mesh in an arm's collision tests."""

from __future__ import annotations

import numpy as np

from abi import arguments
from abi.arm_planning.world.collision_world_kernels import box_rows
from abi.arrays import FloatArray, IntArray, flat
from abi.errors import ArgumentError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.pose import rotation
from abi.obstacles.primitive_kernels import WIDTH
from abi.obstacles.triangle_mesh.bvh import tree_of
from abi.obstacles.triangle_mesh.per_surface import per_surface
from abi.obstacles.triangle_mesh.surface import Surface
from abi.obstacles.vector_kernels import vec3_at

_MOST_TRIANGLES = 20_000
"""Number of triangles beyond which a mesh is replaced by the boxes of a tree's leaves."""


def write_boxes(mesh: MeshShape, rows: FloatArray) -> None:
    """Write the rows of the boxes of a mesh, flat (n ``WIDTH``,), 0 at first."""
    middles, halves, axes, inside = boxes_of(mesh.surface)
    count = len(inside) * WIDTH
    if arguments.numbers("rows", rows, (count,), infinite=True) is not rows:
        raise ArgumentError("rows", rows.dtype, "float64 without gaps, as it is written to")
    a, b, c = (vec3_at(flat(axis), 0) for axis in rotation(mesh.wxyz).T)
    flat_boxes = flat(middles), flat(halves), flat(axes)
    box_rows(*flat_boxes, (a, b, c), mesh.position, mesh.factor, rows)


@per_surface
def boxes_of(surface: Surface) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    """Boxes of a tree over the triangles, and a flat one for each triangle, in its plane.

    Of a mesh of many triangles these are left out. Each box holds those inside it: were a flat one
    to stick out, an arm could be clear of the one and in the way of the other.

    Returns:
        Middles (n, 3), half sizes (n, 3) and axes as columns (n, 3, 3), in the file's unit; and
        first and last but one of the boxes in each, 0 and 0 of the last ones, (n, 2).
    """
    tree = tree_of(surface)
    low, high = np.split(tree.boxes.reshape(-1, 6), 2, axis=1)
    nodes = len(low)
    inner = nodes // 2
    inside = np.zeros((nodes, 2), dtype=np.int32)
    inside[:inner] = 2 * np.arange(inner)[:, None] + (1, 3)
    upright = np.tile(np.eye(3), (nodes, 1, 1))
    if len(surface.faces) > _MOST_TRIANGLES:
        return (low + high) / 2, (high - low) / 2, upright, inside
    inside[inner:, 0], inside[inner:, 1] = tree.leaves[:-1] + nodes, tree.leaves[1:] + nodes
    corners = tree.corners.reshape(-1, 3, 3)
    sides = np.roll(corners, -1, axis=1) - corners
    begin = _side_of_smallest(sides)
    rows = np.arange(len(corners))
    first, second = sides[rows, begin], sides[rows, (begin + 1) % 3]
    # any orthonormal axes do: those of a triangle with no width are whatever comes out
    axes, _ = np.linalg.qr(np.stack([first, second, np.cross(first, second)], axis=2))
    own = np.einsum("nij,nki->nkj", axes, corners)
    middles = np.einsum("nij,nj->ni", axes, (own.min(axis=1) + own.max(axis=1)) / 2)
    halves = np.ptp(own, axis=1) / 2
    spread = np.einsum("nij,nj->ni", np.abs(axes), halves)
    low = _united(np.minimum, middles - spread, tree.leaves, inner)
    high = _united(np.maximum, middles + spread, tree.leaves, inner)
    return (
        np.concatenate([(low + high) / 2, middles]),
        np.concatenate([(high - low) / 2, halves]),
        np.concatenate([upright, axes]),
        np.concatenate([inside, np.zeros((len(corners), 2), dtype=np.int32)]),
    )


def _side_of_smallest(sides: FloatArray) -> IntArray:
    """Number of the side (n,) of each triangle along which the smallest flat box lies.

    Without an obtuse angle the boxes along all sides are as large; then the shortest around is, so
    that both halves of a rectangle are in that rectangle. ``sides`` are (n, 3, 3), one after the
    other.
    """
    lengths = np.linalg.norm(sides, axis=2)
    squares = np.maximum(lengths**2, np.finfo(float).tiny)
    # where along a side the corner off it lies, over the side's length
    off = 1 + np.einsum("nki,nki->nk", np.roll(sides, -1, axis=1), sides) / squares
    along = lengths * (np.maximum(off, 1) - np.minimum(off, 0))
    across = np.linalg.norm(np.cross(sides[:, :1], sides[:, 1:2]), axis=2) / np.sqrt(squares)
    areas, around = along * across, along + across
    least = areas.min(axis=1, keepdims=True)
    return np.asarray(np.where(areas <= least * (1 + 1e-9), around, np.inf).argmin(axis=1))


def _united(outer: np.ufunc, corners: FloatArray, leaves: IntArray, inner: int) -> FloatArray:
    """Outer corner (nodes, 3) of each box of a tree, from those of its leaves' contents."""
    united = np.empty((2 * inner + 1, 3))
    united[inner:] = outer.reduceat(corners, leaves[:-1])
    for k in range(inner - 1, -1, -1):
        united[k] = outer(united[2 * k + 1], united[2 * k + 2])
    return united
