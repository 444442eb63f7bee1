"""Cylinders with flat ends."""

from __future__ import annotations

from typing import Literal, Self

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.obstacles.convex_shape import (
    ConvexShape,
    dot,
    excess_direction,
    excess_distance,
    unit_vectors,
)
from abi.obstacles.pose import Length, Vec3
from abi.obstacles.primitive_kernels import Core
from abi.obstacles.revolution import revolved


class Cylinder(ConvexShape):
    """A cylinder with flat ends along the body's z, centred; ``radius``, ``height`` in [unit]."""

    shape: Literal["cylinder"] = "cylinder"
    radius: Length
    height: Length

    @classmethod
    def of_length(cls, length: float, position: Vec3) -> Self:
        """A cylinder as wide as it is high."""
        return cls(radius=length / 2, height=length, position=position)

    def core(self) -> Core:
        """The cylinder itself."""
        return Core(self.radius, self.radius, self.height / 2, 0.0, 1.0)

    def surface(self, sides: int) -> tuple[FloatArray, IntArray]:
        """Half a rectangle, turned."""
        r, h = self.radius, self.height / 2
        return revolved(np.array([(0.0, -h), (r, -h), (r, h), (0.0, h)]), sides)

    def half_extents(self, rotation: FloatArray) -> FloatArray:
        """Those of two discs, the ends."""
        radial = np.hypot(rotation[:, 0], rotation[:, 1])
        return np.asarray(np.abs(rotation[:, 2]) * self.height / 2 + radial * self.radius)

    def _excess(self, x: FloatArray) -> FloatArray:
        radial = np.hypot(x[:, 0], x[:, 1]) - self.radius
        return np.stack([radial, np.abs(x[:, 2]) - self.height / 2], axis=1)

    def _distance(self, x: FloatArray) -> FloatArray:
        return excess_distance(self._excess(x))

    def _gradient(self, x: FloatArray) -> FloatArray:
        direction = excess_direction(self._excess(x))
        radial = unit_vectors(x[:, :2], np.array([1.0, 0.0])) * direction[:, :1]
        return np.concatenate([radial, np.copysign(direction[:, 1:], x[:, 2:])], axis=1)

    def _nearest_parameter(self, p: FloatArray, d: FloatArray) -> FloatArray:
        # Past the rim the minimum is the root of a quartic; bisection on the slope's sign is as
        # exact and needs no case.
        low, high = np.zeros(len(p)), np.ones(len(p))
        for _ in range(50):
            t = (low + high) / 2
            rising = dot(self._gradient(p + t[:, None] * d), d) > 0
            low, high = np.where(rising, low, t), np.where(rising, t, high)
        return np.asarray((low + high) / 2)
