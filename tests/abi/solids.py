"""Poses and supports of obstacles, worked out anew."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import Obstacle
from abi.obstacles.pose import Posed
from abi.obstacles.primitives import Box, Capsule, Cylinder, Sphere


def world_from_body(solid: Posed) -> FloatArray:
    """Homogeneous matrix (4, 4), translation in [unit]."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat(solid.wxyz, scalar_first=True).as_matrix()
    pose[:3, 3] = solid.position
    return pose


def support(solid: Obstacle, directions: FloatArray) -> FloatArray:
    """Greatest n·x (k,) over a solid for directions n (k, 3), world, [unit]."""
    n = directions @ world_from_body(solid)[:3, :3]
    along, across, length = np.abs(n[:, 2]), np.hypot(n[:, 0], n[:, 1]), np.linalg.norm(n, axis=1)
    match solid:
        case Box(size=size):
            reach = np.abs(n) @ np.array(size) / 2
        case Sphere(radius=radius):
            reach = radius * length
        case Cylinder(radius=radius, height=height):
            reach = along * height / 2 + radius * across
        case Capsule(radius=radius, height=height):
            reach = along * height / 2 + radius * length
        case _:
            raise AssertionError(f"{solid} has no support")
    return np.asarray(directions @ np.array(solid.position) + reach)
