"""A tree of boxes over the triangles of a surface."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abi.arrays import FloatArray, IntArray, read_only

_LEAF = 4  # triangles, about


class TriangleTree(NamedTuple):
    """A complete binary tree of boxes: node k has the children 2 k + 1 and 2 k + 2.

    Attributes:
        low: lowest corners of the nodes' boxes, flat (3 n,).
        high: highest corners, flat (3 n,).
        leaves: leaf i, which is node (n - 1) / 2 + i, holds the triangles from ``leaves[i]`` up to
            ``leaves[i + 1]``.
        corners: corners of the triangles, in the order of the leaves, flat (9 m,).
        size: largest coordinate, without its sign.
    """

    low: FloatArray
    high: FloatArray
    leaves: IntArray
    corners: FloatArray
    size: float


def build(triangles: FloatArray) -> TriangleTree:
    """Build the tree over triangles (m, 3, 3): halve each box at the median of its widest axis."""
    count = len(triangles)
    levels = max(0, int(np.log2(max(count / _LEAF, 1))))
    centres = triangles.mean(axis=1)
    order = np.arange(count)
    for level in range(levels):
        bounds = count * np.arange(2**level + 1) // 2**level
        places = centres[order]
        spread = np.maximum.reduceat(places, bounds[:-1]) - np.minimum.reduceat(places, bounds[:-1])
        block = np.repeat(np.arange(2**level), np.diff(bounds))
        along = places[np.arange(count), spread.argmax(axis=1)[block]]
        order = order[np.lexsort((along, block))]
    leaves = count * np.arange(2**levels + 1) // 2**levels
    sorted_ = triangles[order]
    low = np.minimum.reduceat(sorted_.min(axis=1), leaves[:-1])
    high = np.maximum.reduceat(sorted_.max(axis=1), leaves[:-1])
    lows, highs = [low], [high]
    for _ in range(levels):
        low = low.reshape(-1, 2, 3).min(axis=1)
        high = high.reshape(-1, 2, 3).max(axis=1)
        lows.append(low)
        highs.append(high)
    return TriangleTree(
        read_only(np.concatenate(lows[::-1]).ravel()),
        read_only(np.concatenate(highs[::-1]).ravel()),
        read_only(leaves.astype(np.int32)),
        read_only(sorted_.ravel()),
        float(np.abs(triangles).max()),
    )
