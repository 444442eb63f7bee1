"""Bounding volume hierarchy over the triangles of a surface, and the far field of its nodes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, IntArray, flat, read_only
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, IDS
from abi.errors import ArgumentError
from abi.obstacles.triangle_mesh.bvh_kernels import order_of_leaves, slabs_of_nodes
from abi.obstacles.triangle_mesh.per_surface import per_surface
from abi.obstacles.triangle_mesh.surface import Surface
from abi.obstacles.vector_kernels import Vec3, axpy, dot, vec3_at

_LEAF = 4  # triangles that a leaf has, at least, in the mean: fewer cost memory, more cost tests

_MANY = 10_000
"""Triangles with which Python would take longer than the compiler."""


class TriangleTree(NamedTuple):
    """A complete binary tree of boxes: node k has the children 2 k + 1 and 2 k + 2.

    Attributes:
        boxes: lowest and highest corner of each node's box, flat (6 n,).
        leaves: leaf i, which is node (n - 1) / 2 + i, holds the triangles from ``leaves[i]`` up to
            ``leaves[i + 1]``.
        corners: corners of the triangles, in the order of the leaves, flat (9 m,).
        slabs: of each node a unit vector, 0 where its triangles have no common side, and the most
            and the least of its products with their corners, flat (5 n,). Of a smooth surface they
            are much thinner than the boxes.
        size: largest coordinate, without its sign.
    """

    boxes: FloatArray
    leaves: IntArray
    corners: FloatArray
    slabs: FloatArray
    size: float


NO_TREE = TriangleTree(FLOATS, IDS, FLOATS, FLOATS, 1.0)
"""Example of a tree to compile kernels with."""


@jitable(forceinline=True)
def box_of(tree: TriangleTree, node: int) -> tuple[Vec3, Vec3]:
    """Lowest and highest corner of a node's box."""
    return vec3_at(tree.boxes, 6 * node), vec3_at(tree.boxes, 6 * node + 3)


@jitable(forceinline=True)
def highest(direction: Vec3, low: Vec3, high: Vec3) -> float:
    """Largest product of a direction with the points of a box."""
    x, y, z = direction
    top: float = x * (high[0] if x > 0.0 else low[0])
    top += y * (high[1] if y > 0.0 else low[1])
    top += z * (high[2] if z > 0.0 else low[2])
    return top


@jitable(forceinline=True)
def highest_in_slab(tree: TriangleTree, node: int, direction: Vec3) -> float:
    """Upper bound, up to rounding, of a direction's product with the points of a node.

    The slab bounds the part of the direction along its normal, the box bounds the rest.
    """
    low, high = box_of(tree, node)
    normal = vec3_at(tree.slabs, 5 * node)
    along = dot(direction, normal)
    height = tree.slabs[5 * node + (3 if along > 0.0 else 4)]
    top: float = along * height + highest(axpy(-along, normal, direction), low, high)
    return top


def build_tree(triangles: FloatArray) -> TriangleTree:
    """Build the tree over triangles (m, 3, 3), cut where it is cheapest to search."""
    triangles = arguments.numbers("triangles", triangles, (-1, 3, 3), infinite=True)
    count = len(triangles)
    if not count:
        raise ArgumentError("triangles", [], "one triangle or more")
    if count > _MANY:
        order_of_leaves.compile()
        slabs_of_nodes.compile()
    depth = max(0, int(np.log2(max(count / _LEAF, 1))))
    order, leaves = np.empty(count, dtype=np.int32), np.empty(2**depth + 1, dtype=np.int32)
    own = np.concatenate([triangles.min(axis=1), triangles.max(axis=1)], axis=1)
    order_of_leaves(flat(own), np.empty(count), order, leaves)
    sorted_ = triangles[order]
    low = np.minimum.reduceat(sorted_.min(axis=1), leaves[:-1])
    high = np.maximum.reduceat(sorted_.max(axis=1), leaves[:-1])
    boxes = np.concatenate([of_all_nodes(low, np.min), of_all_nodes(high, np.max)], axis=1)
    begins, corners = read_only(leaves), read_only(sorted_.ravel())
    return TriangleTree(
        read_only(boxes.ravel()),
        begins,
        corners,
        _slabs(begins, corners),
        float(np.abs(triangles).max()),
    )


@per_surface
def tree_of(surface: Surface) -> TriangleTree:
    """The tree over a surface, in the file's coordinates."""
    return build_tree(surface.vertices[surface.faces])


def moved(tree: TriangleTree, centre: FloatArray, scale: float) -> TriangleTree:
    """The tree of the same triangles with ``centre`` (3,) as the origin, times ``scale`` > 0."""
    centre = arguments.numbers("centre", centre, (3,))
    scale = arguments.number("scale", scale, 0.0)
    # rounding is monotonic: what is least before is least after
    boxes = (tree.boxes.reshape(-1, 3) - centre) * scale
    corners = (tree.corners.reshape(-1, 3) - centre) * scale
    packed = read_only(corners.ravel())
    size = float(np.abs(boxes[:2]).max())
    return TriangleTree(
        read_only(boxes.ravel()),
        tree.leaves,
        packed,
        _slabs(tree.leaves, packed),  # anew: far from the origin they have fewer digits
        size,
    )


def _slabs(leaves: IntArray, corners: FloatArray) -> FloatArray:
    slabs = np.zeros(5 * (2 * len(leaves) - 3))
    slabs_of_nodes(leaves, corners, slabs)
    return read_only(slabs)


class Dipoles(NamedTuple):
    """First term of the far field of each node's triangles (Barill and others, 2018, section 3).

    A surface is inside where any of its layers winds. Each has a tree of its own, all of which
    follow one another here; that of a single layer is the surface's.

    Attributes:
        centres: middles of the nodes' triangles, weighted by area, flat (3 n,).
        radii: (n,) of balls around the centres that hold the nodes' boxes.
        normals: sums of the triangles' normals, as long as their areas, flat (3 n,).
        areas: (n,) sums of the triangles' areas.
        leaves, corners: of the trees, see ``TriangleTree``.
        layers: (k + 1,) leaves of all trees before each layer's, and of all.
    """

    centres: FloatArray
    radii: FloatArray
    normals: FloatArray
    areas: FloatArray
    leaves: IntArray
    corners: FloatArray
    layers: IntArray


NO_DIPOLES = Dipoles(*4 * (FLOATS,), IDS, FLOATS, IDS)
"""Example of dipoles to compile kernels with."""


def dipoles(*trees: TriangleTree) -> Dipoles:
    """Dipoles of all nodes of trees, one for each layer."""
    if len(trees) > 1:
        return _one_after_another([dipoles(tree) for tree in trees])
    (tree,) = trees
    a, b, c = tree.corners.reshape(-1, 3, 3).transpose(1, 0, 2)
    normals = np.cross(b - a, c - a) / 2
    areas = np.linalg.norm(normals, axis=1)[:, None]
    columns = np.concatenate([normals, areas * (a + b + c) / 3, areas], axis=1)
    sums = of_all_nodes(np.add.reduceat(columns, tree.leaves[:-1]), np.sum)
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
        tree.leaves,
        tree.corners,
        read_only(np.array([0, len(tree.leaves) - 1], dtype=np.int32)),
    )


def _one_after_another(each: Sequence[Dipoles]) -> Dipoles:
    begins = np.cumsum([0, *(len(one.corners) // 9 for one in each)], dtype=np.int32)
    leaves = [one.leaves + first for one, first in zip(each, begins, strict=False)]
    layers = np.cumsum([0, *(len(one.leaves) - 1 for one in each)], dtype=np.int32)
    rest = (np.concatenate(one) for one in zip(*(one[:4] for one in each), strict=True))
    corners = np.concatenate([one.corners for one in each])
    return Dipoles._make(map(read_only, (*rest, np.concatenate(leaves), corners, layers)))


def of_all_nodes(leaves: FloatArray, reduce: Callable[..., FloatArray]) -> FloatArray:
    """Values (n, k) of a complete tree's nodes from its leaves', reduced over both children."""
    levels = [leaves]
    while len(levels[0]) > 1:
        levels.insert(0, reduce(levels[0].reshape(-1, 2, leaves.shape[1]), axis=1))
    return np.concatenate(levels)
