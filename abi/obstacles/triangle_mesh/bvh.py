"""Bounding volume hierarchy over the triangles of a surface, and the far field of its nodes."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from abi.arrays import FloatArray, IntArray, flat, read_only
from abi.compiled import FLOATS, IDS
from abi.obstacles.triangle_mesh.bvh_kernels import order_of_leaves
from abi.obstacles.triangle_mesh.surface import Surface
from abi.obstacles.vector_kernels import Vec3, vec3_at

_LEAF = 4  # triangles that a leaf has, about: fewer cost memory, more cost tests


class TriangleTree(NamedTuple):
    """A complete binary tree of boxes: node k has the children 2 k + 1 and 2 k + 2.

    Attributes:
        boxes: lowest and highest corner of each node's box, flat (6 n,).
        leaves: leaf i, which is node (n - 1) / 2 + i, holds the triangles from ``leaves[i]`` up to
            ``leaves[i + 1]``.
        corners: corners of the triangles, in the order of the leaves, flat (9 m,).
        size: largest coordinate, without its sign.
    """

    boxes: FloatArray
    leaves: IntArray
    corners: FloatArray
    size: float


NO_TREE = TriangleTree(FLOATS, IDS, FLOATS, 1.0)
"""In an example: a tree."""


@register_jitable
def box_of(tree: TriangleTree, node: int) -> tuple[Vec3, Vec3]:
    """Lowest and highest corner of a node's box."""
    return vec3_at(tree.boxes, 6 * node), vec3_at(tree.boxes, 6 * node + 3)


def build_tree(triangles: FloatArray) -> TriangleTree:
    """Build the tree over triangles (m, 3, 3): halve each box at the median of its widest axis."""
    count = len(triangles)
    depth = max(0, int(np.log2(max(count / _LEAF, 1))))
    order = np.empty(count, dtype=np.int32)
    order_of_leaves(flat(triangles.mean(axis=1)), depth, np.empty(count), order)
    leaves = count * np.arange(2**depth + 1) // 2**depth
    sorted_ = triangles[order]
    low = np.minimum.reduceat(sorted_.min(axis=1), leaves[:-1])
    high = np.maximum.reduceat(sorted_.max(axis=1), leaves[:-1])
    boxes = np.concatenate([_of_all_nodes(low, np.min), _of_all_nodes(high, np.max)], axis=1)
    return TriangleTree(
        read_only(boxes.ravel()),
        read_only(leaves.astype(np.int32)),
        read_only(sorted_.ravel()),
        float(np.abs(triangles).max()),
    )


@lru_cache(maxsize=16)
def tree_of(surface: Surface) -> TriangleTree:
    """The tree over a surface, in the file's coordinates; those of the last 16 are kept."""
    return build_tree(surface.vertices[surface.faces])


def moved(tree: TriangleTree, centre: FloatArray, scale: float) -> TriangleTree:
    """The tree of the same triangles where ``centre`` (3,) is the origin, times ``scale`` > 0."""
    # rounding is monotonic: what is least before is least after
    boxes = (tree.boxes.reshape(-1, 3) - centre) * scale
    corners = (tree.corners.reshape(-1, 3) - centre) * scale
    size = float(np.abs(boxes[:2]).max())
    return TriangleTree(read_only(boxes.ravel()), tree.leaves, read_only(corners.ravel()), size)


def coarser(tree: TriangleTree) -> TriangleTree:
    """The tree without its last level: leaves have twice as many triangles."""
    count = len(tree.leaves) - 1
    if count == 1:
        return tree
    boxes = tree.boxes[: -6 * count]
    return TriangleTree(boxes, read_only(tree.leaves[::2].copy()), tree.corners, tree.size)


class Dipoles(NamedTuple):
    """First term of the far field of each node's triangles (Barill and others, 2018, section 3).

    Attributes:
        centres: middles of the nodes' triangles, weighted by area, flat (3 n,).
        radii: (n,) of balls around the centres that hold the nodes' boxes.
        normals: sums of the triangles' normals, as long as their areas, flat (3 n,).
        areas: (n,) sums of the triangles' areas.
    """

    centres: FloatArray
    radii: FloatArray
    normals: FloatArray
    areas: FloatArray


NO_DIPOLES = Dipoles(FLOATS, FLOATS, FLOATS, FLOATS)
"""In an example: dipoles."""


def dipoles(tree: TriangleTree) -> Dipoles:
    """Dipoles of all nodes of a tree."""
    a, b, c = tree.corners.reshape(-1, 3, 3).transpose(1, 0, 2)
    normals = np.cross(b - a, c - a) / 2
    areas = np.linalg.norm(normals, axis=1)[:, None]
    columns = np.concatenate([normals, areas * (a + b + c) / 3, areas], axis=1)
    sums = _of_all_nodes(np.add.reduceat(columns, tree.leaves[:-1]), np.sum)
    low, high = np.split(tree.boxes.reshape(-1, 6), 2, axis=1)
    area = sums[:, 6:]
    middle = (low + high) / 2
    centres = np.divide(sums[:, 3:6], area, out=middle, where=area > 0)
    radii = np.linalg.norm(np.maximum(centres - low, high - centres), axis=1)
    return Dipoles(
        read_only(centres.ravel()),
        read_only(radii),
        read_only(sums[:, :3].ravel()),
        read_only(area.ravel()),
    )


def _of_all_nodes(leaves: FloatArray, reduce: Callable[..., FloatArray]) -> FloatArray:
    """Values (n, k) of all nodes from those of the leaves, reduced over both children."""
    levels = [leaves]
    while len(levels[0]) > 1:
        levels.insert(0, reduce(levels[0].reshape(-1, 2, leaves.shape[1]), axis=1))
    return np.concatenate(levels)
