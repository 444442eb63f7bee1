"""Capsules: cylinders with round caps."""

from __future__ import annotations

from typing import Literal, Self

from abi.arrays import FloatArray, IntArray
from abi.obstacles.convex_shape import ConvexShape
from abi.obstacles.cylinder import Cylinder
from abi.obstacles.pose import Length, Vec3, rotation
from abi.obstacles.primitive_kernels import Core
from abi.obstacles.revolution import quarter_circles, revolved
from abi.obstacles.sphere import Sphere


class Capsule(ConvexShape):
    """A cylinder with round caps along the body's z; ``height`` between the cap centres, [unit]."""

    shape: Literal["capsule"] = "capsule"
    radius: Length
    height: Length

    @classmethod
    def of_length(cls, length: float, position: Vec3) -> Self:
        """A capsule whose caps' centres are ``length`` apart."""
        return cls(radius=length / 3, height=length, position=position)

    def core(self) -> Core:
        """A segment of the z axis with a radius."""
        return Core(0.0, 0.0, self.height / 2, self.radius, 0.0)

    def surface(self, sides: int) -> tuple[FloatArray, IntArray]:
        """Two quarters of a circle and the line between them, turned."""
        return revolved(quarter_circles(self.radius, self.height / 2, sides), sides)

    def parts(self) -> tuple[ConvexShape, ...]:
        """A cylinder and two balls."""
        half = rotation(self.wxyz)[:, 2] * self.height / 2
        (a, b, c), (d, e, f) = (self.position - half).tolist(), (self.position + half).tolist()
        return (
            Cylinder.model_construct(
                radius=self.radius, height=self.height, position=self.position, wxyz=self.wxyz
            ),
            Sphere.model_construct(radius=self.radius, position=(a, b, c), wxyz=self.wxyz),
            Sphere.model_construct(radius=self.radius, position=(d, e, f), wxyz=self.wxyz),
        )
