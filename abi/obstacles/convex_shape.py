"""Convex shapes placed in the world, and their signed distance.

Each is convex, so its signed distance is a convex function of the point
(Boyd and Vandenberghe, Convex Optimization, 2004, section 3.2.5 and exercise 8.5). Two things rest
on that: along a segment it has no local minimum but the global one, and every tangent bounds it
from below. Triangle meshes (:mod:`abi.obstacles.mesh_shape`) need not be convex. Lengths are in the
scene's [unit]; arrays of points are in the world frame unless named body.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from functools import lru_cache
from typing import ClassVar, Self

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, IntArray, flat, read_only
from abi.obstacles import obstacle_set_kernels as kernels
from abi.obstacles.pose import Posed, Quaternion, Vec3, rotation
from abi.obstacles.primitive_kernels import BOUNDS, WIDTH, Core
from abi.obstacles.primitive_tree_kernels import TREE


class ConvexShape(Posed):
    """A convex solid and its pose.

    A child says its core, its surface and its first size.
    """

    convex: ClassVar[bool] = True

    shape: str

    @abstractmethod
    def core(self) -> Core:
        """The shape as the numbers that the kernels take, body."""

    @abstractmethod
    def surface(self, sides: int) -> tuple[FloatArray, IntArray]:
        """Triangles to draw, whose corners lie on the surface.

        Args:
            sides: of the polygon that stands for a circle.

        Returns:
            Vertices (v, 3), [unit], body, and their numbers in each triangle (m, 3).
        """

    @classmethod
    @abstractmethod
    def of_length(cls, length: float, position: Vec3) -> Self:
        """A shape about as long as ``length``, [unit], at a position, [unit], world."""

    def parts(self) -> tuple[ConvexShape, ...]:
        """Shapes whose union this is, for programs that know boxes, spheres and cylinders only."""
        return (self,)

    def triangles(self, sides: int = 24) -> FloatArray:
        """Triangles (m, 3, 3) of the surface, [unit], world."""
        vertices, faces = self.surface(sides)
        return np.asarray((vertices @ rotation(self.wxyz).T + np.array(self.position))[faces])

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Low and high corner, each (3,), of the tightest axis-parallel box, [unit], world."""
        numbers = row(self)
        return numbers[BOUNDS : BOUNDS + 3], numbers[BOUNDS + 3 : BOUNDS + 6]

    def signed_distance(self, points: FloatArray) -> FloatArray:
        """Euclidean distance (n,) of points (n, 3) to the surface, [unit]; negative inside."""
        points = arguments.points("points", points)
        distances = np.empty(len(points))
        kernels.signed_distances(flat(points), _alone(self), distances)
        return distances

    def signed_distance_gradient(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Signed distance (n,) of points (n, 3), [unit], and its gradient (n, 3), world.

        The gradient has length 1. Where it is not unique (on the medial axis, at edges) it is one
        of the valid ones, hence always a subgradient: d(x) >= d(p) + g(p) . (x - p) for all x.
        """
        points = arguments.points("points", points)
        gradients = np.empty(3 * len(points))
        nearest = read_only(np.zeros(len(points), dtype=np.int32))
        kernels.gradients(flat(points), _alone(self), nearest, gradients)
        return self.signed_distance(points), gradients.reshape(-1, 3)


@lru_cache(maxsize=8192)
def row(shape: ConvexShape) -> FloatArray:
    """The shape in the format of the kernels, without its place in a tree, (``TREE``,)."""
    axes = _axes(shape.wxyz)
    a, b, c, radius, is_cylinder = core = shape.core()
    half = [
        abs(axes[k + 6]) * c + math.hypot(axes[k], axes[k + 3]) * a
        if is_cylinder
        else abs(axes[k]) * a + abs(axes[k + 3]) * b + abs(axes[k + 6]) * c + radius
        for k in range(3)
    ]
    (x, y, z), (u, v, w) = shape.position, half
    numbers = np.array([x, y, z, *axes, *core, x - u, y - v, z - w, x + u, y + v, z + w])
    assert len(numbers) == TREE
    return read_only(numbers)


@lru_cache(maxsize=1024)
def _axes(wxyz: Quaternion) -> tuple[float, ...]:
    """The body's axes in the world, one after the other (9,)."""
    return tuple(rotation(wxyz).T.ravel().tolist())


def _alone(shape: ConvexShape) -> FloatArray:
    """The row of a shape in no tree, (``WIDTH``,)."""
    packed = np.zeros(WIDTH)
    packed[:TREE] = row(shape)
    return read_only(packed)
