"""Obstacles as solids that other programs know, in metres."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.obstacles.convex_shape import ConvexShape
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, Obstacles
from abi.obstacles.pose import METRES, UNTURNED, Quaternion, Vec3

KINDS = ("box", "sphere", "cylinder")
"""Convex shapes that other programs know."""


@dataclass(frozen=True, eq=False)
class Solid:
    """A box, sphere, cylinder or triangle mesh.

    Attributes:
        kind: which of them, one of ``KINDS`` or "mesh".
        size: edges of the box; diameter thrice of the sphere; diameter twice and height of the
            cylinder, whose axis is its z; of a mesh 1, [m].
        position: of its centre, world, [m].
        wxyz: its orientation, a unit quaternion.
        triangles: of a mesh, shape (m, 3, 3), world, [m]; empty otherwise.
    """

    kind: str
    size: Vec3
    position: Vec3 = (0.0, 0.0, 0.0)
    wxyz: Quaternion = UNTURNED
    triangles: FloatArray = field(default_factory=lambda: read_only(np.empty((0, 3, 3))))


def solids(obstacle: Obstacles, unit: Literal["m", "cm", "mm"]) -> tuple[tuple[Solid, ...], ...]:
    """For each obstacle, solids whose union it is; a capsule is a cylinder and two spheres."""
    return tuple(_of(shape, METRES[unit]) for shape in obstacle)


def _of(shape: Obstacle, metres: float) -> tuple[Solid, ...]:
    if isinstance(shape, MeshShape):
        return (_mesh(shape.triangles() * metres),)
    return tuple(_solid(part, metres) for part in shape.parts())


def _solid(shape: ConvexShape, metres: float) -> Solid:
    """A convex shape by name, or by its triangles if other programs do not know it."""
    if shape.shape not in KINDS:
        return _mesh(shape.triangles() * metres)
    core = shape.core()
    size = _scaled(2 * (np.array(core[:3]) + core.radius), metres)
    return Solid(shape.shape, size, _scaled(shape.position, metres), shape.wxyz)


def _mesh(triangles: FloatArray) -> Solid:
    return Solid("mesh", (1.0, 1.0, 1.0), triangles=triangles)


def _scaled(vector: Vec3 | FloatArray, factor: float) -> Vec3:
    x, y, z = (float(number) * factor for number in vector)
    return (x, y, z)
