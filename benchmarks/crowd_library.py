"""Distance of a path to many obstacles by FCL, with its tree over all of them."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from abi.arrays import FloatArray
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, Obstacles

_THIN = 1e-9
"""Height of a capsule that stands for a sphere, [unit]."""


class FclCrowd:
    """Obstacles in FCL's dynamic tree, one model for all meshes of the same surface."""

    def __init__(self, obstacles: Obstacles) -> None:
        import fcl

        self._fcl: Any = fcl
        self._models: dict[tuple[str, float], Any] = {}
        self._objects = [
            fcl.CollisionObject(self._shape(one), self._pose(one)) for one in obstacles
        ]
        self._tree: Any = fcl.DynamicAABBTreeCollisionManager()
        self._tree.registerObjects(self._objects)
        self._tree.setup()

    def move(self, number: int, obstacle: Obstacle) -> None:
        """Move an obstacle to where it is now."""
        self._objects[number].setTransform(self._pose(obstacle))
        self._tree.update(self._objects[number])

    def distance(self, points: FloatArray) -> float:
        """Least distance of a polyline (k, 3) that is in no obstacle, [unit]."""
        fcl, least = self._fcl, np.inf
        for p, q in itertools.pairwise(points):
            triangle = fcl.BVHModel()
            triangle.beginModel(3, 1)
            triangle.addSubModel(np.stack([p, q, q]), np.array([[0, 1, 2]]))
            triangle.endModel()
            data = fcl.DistanceData()
            self._tree.distance(fcl.CollisionObject(triangle), data, fcl.defaultDistanceCallback)
            least = min(least, data.result.min_distance)
        return float(least)

    def _pose(self, one: Obstacle) -> Any:
        return self._fcl.Transform(np.array(one.wxyz), np.array(one.position))

    def _shape(self, one: Obstacle) -> Any:
        fcl = self._fcl
        if isinstance(one, MeshShape):
            key = one.surface.digest, one.factor
            if key not in self._models:
                model = self._models[key] = fcl.BVHModel()
                vertices = one.surface.vertices * one.factor
                model.beginModel(len(vertices), len(one.surface.faces))
                model.addSubModel(vertices, one.surface.faces)
                model.endModel()
            return self._models[key]
        a, b, c, radius, is_cylinder = one.core()
        if is_cylinder:
            return fcl.Cylinder(a, 2 * c)
        if radius == 0:
            return fcl.Box(2 * a, 2 * b, 2 * c)
        if a == b == 0:
            return fcl.Capsule(radius, max(2 * c, _THIN))  # of a sphere from a triangle it says 0
        raise ValueError(f"FCL has no shape such as {one.shape}")
