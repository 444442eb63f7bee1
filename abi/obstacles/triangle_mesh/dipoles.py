"""What the triangles below each node of a tree look like from far: one dipole."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.obstacles.triangle_mesh.bvh import TriangleTree


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


def dipoles(tree: TriangleTree) -> Dipoles:
    """The dipoles of all nodes of a tree."""
    a, b, c = tree.corners.reshape(-1, 3, 3).transpose(1, 0, 2)
    normals = np.cross(b - a, c - a) / 2
    areas = np.linalg.norm(normals, axis=1)[:, None]
    columns = np.concatenate([normals, areas * (a + b + c) / 3, areas], axis=1)
    level = np.add.reduceat(columns, tree.leaves[:-1])
    levels = [level]
    while len(level) > 1:
        level = level.reshape(-1, 2, 7).sum(axis=1)
        levels.append(level)
    sums = np.concatenate(levels[::-1])
    low, high = tree.low.reshape(-1, 3), tree.high.reshape(-1, 3)
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
