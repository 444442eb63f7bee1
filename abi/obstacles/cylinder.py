"""Cylinders with flat ends."""

from __future__ import annotations

from typing import Literal, Self

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.obstacles.convex_shape import ConvexShape
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
