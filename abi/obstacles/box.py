"""Boxes."""

from __future__ import annotations

from itertools import product
from typing import Literal, Self

import numpy as np

from abi.arrays import FloatArray, IntArray, read_only
from abi.obstacles.convex_shape import ConvexShape
from abi.obstacles.pose import Length, Vec3
from abi.obstacles.primitive_kernels import Core

_CORNERS = read_only(np.array(list(product((-0.5, 0.5), repeat=3))))
# two triangles a face, anticlockwise seen from outside
_FACES = read_only(
    np.array(
        [
            *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5)),
            *((0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6)),
            *((0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
        ]
    )
)


class Box(ConvexShape):
    """A box; ``size`` is its full extent along the body's x, y, z, [unit]."""

    shape: Literal["box"] = "box"
    size: tuple[Length, Length, Length]

    @classmethod
    def of_length(cls, length: float, position: Vec3) -> Self:
        """A cube with edges of ``length``."""
        return cls(size=(length, length, length), position=position)

    def core(self) -> Core:
        """The box itself."""
        x, y, z = self.size
        return Core(x / 2, y / 2, z / 2, 0.0, 0.0)

    def surface(self, sides: int) -> tuple[FloatArray, IntArray]:
        """Two triangles a face."""
        return _CORNERS * np.array(self.size), _FACES
