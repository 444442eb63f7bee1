"""Table of the convex shapes that an obstacle can have.

A new shape is a file beside this one, with a child of
:class:`abi.obstacles.convex_shape.ConvexShape`, and its class in the union here.
"""

from __future__ import annotations

from typing import get_args

from abi.obstacles.box import Box
from abi.obstacles.capsule import Capsule
from abi.obstacles.cylinder import Cylinder
from abi.obstacles.sphere import Sphere

__all__ = ["PRIMITIVES", "Box", "Capsule", "Cylinder", "Primitive", "Sphere"]

Primitive = Box | Sphere | Cylinder | Capsule

PRIMITIVES: dict[str, type[Primitive]] = {
    kind.model_fields["shape"].default: kind for kind in get_args(Primitive)
}
"""The classes by the names of the shapes, as a scene file has them."""
