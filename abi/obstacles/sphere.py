"""Balls."""

from __future__ import annotations

from typing import Literal, Self

from abi.arrays import FloatArray, IntArray
from abi.obstacles.convex_shape import ConvexShape
from abi.obstacles.pose import Length, Vec3
from abi.obstacles.primitive_kernels import Core
from abi.obstacles.revolution import quarter_circles, revolved


class Sphere(ConvexShape):
    """A ball; ``radius`` in [unit]."""

    shape: Literal["sphere"] = "sphere"
    radius: Length

    @classmethod
    def of_length(cls, length: float, position: Vec3) -> Self:
        """A ball with a diameter of ``length``."""
        return cls(radius=length / 2, position=position)

    def core(self) -> Core:
        """A point with a radius."""
        return Core(0.0, 0.0, 0.0, self.radius, 0.0)

    def surface(self, sides: int) -> tuple[FloatArray, IntArray]:
        """Half a circle, turned."""
        return revolved(quarter_circles(self.radius, 0.0, sides), sides)
