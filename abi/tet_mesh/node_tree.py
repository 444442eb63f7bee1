"""A tree over the nodes of a mesh, for decisions about many at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, IntArray, flat, read_only
from abi.compiled import FLOATS, IDS
from abi.obstacles.triangle_mesh.bvh import of_all_nodes

_LEAF = 4
"""Approximate number of nodes in a leaf."""
_BITS = 10
"""Bits per axis of the cells by which the nodes are sorted."""


class NodeTree(NamedTuple):
    """A complete binary tree over points: branch k has the children 2 k + 1 and 2 k + 2.

    Attributes:
        points: the places, in the tree's order, flat (3 n,), [unit], world.
        order: their numbers (n,).
        leaves: leaf i, which is branch (m - 1) / 2 + i, holds the places from ``leaves[i]`` up to
            ``leaves[i + 1]`` in that order.
        balls: centre and radius of a ball around what each of the m branches holds, flat (4 m,).
    """

    points: FloatArray
    order: IntArray
    leaves: IntArray
    balls: FloatArray


NO_NODES = NodeTree(FLOATS, IDS, IDS, FLOATS)
"""Example for the compiler."""


def tree_over(points: FloatArray) -> NodeTree:
    """Build the tree over points (n, 3), [unit], world, sorted along Morton's curve."""
    points = arguments.points("points", points)
    order = np.argsort(_morton(points), kind="stable")
    ordered = points[order]
    depth = max(0, int(np.log2(max(len(points) / _LEAF, 1))))
    leaves = len(points) * np.arange(2**depth + 1) // 2**depth
    low, high = np.minimum.reduceat(ordered, leaves[:-1]), np.maximum.reduceat(ordered, leaves[:-1])
    low, high = of_all_nodes(low, np.min), of_all_nodes(high, np.max)
    radii = np.linalg.norm(high - low, axis=1, keepdims=True) / 2
    return NodeTree(
        flat(ordered),
        read_only(order.astype(np.int32)),
        read_only(leaves.astype(np.int32)),
        flat(np.concatenate([(low + high) / 2, radii], axis=1)),
    )


def _morton(points: FloatArray) -> IntArray:
    """Morton codes of points (n, 3)."""
    low = points.min(axis=0)
    size = max(float(np.ptp(points, axis=0).max()), 1e-300)
    cells = ((points - low) * ((2**_BITS - 1) / size)).astype(np.int32)
    codes = np.zeros(len(points), dtype=np.int32)
    for bit in range(_BITS):
        for axis in range(3):
            codes |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return codes
