"""Obstacles as solids that other programs know, in metres."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, assert_never

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, Obstacles
from abi.obstacles.pose import METRES, Vec3, rotation
from abi.obstacles.primitives import Box, Capsule, Cylinder, Sphere

Quaternion = tuple[float, float, float, float]


def _no_triangles() -> FloatArray:
    return read_only(np.empty((0, 3, 3)))


@dataclass(frozen=True, eq=False)
class Solid:
    """A box, sphere, cylinder or triangle mesh.

    Attributes:
        kind: which of them.
        size: edges of the box; diameter thrice of the sphere; diameter twice and height of the
            cylinder, whose axis is its z; of a mesh 1, [m].
        position: of its centre, world, [m].
        wxyz: its orientation, a unit quaternion.
        triangles: of a mesh, shape (m, 3, 3), world, [m]; empty otherwise.
    """

    kind: Literal["box", "sphere", "cylinder", "mesh"]
    size: Vec3
    position: Vec3 = (0.0, 0.0, 0.0)
    wxyz: Quaternion = (1.0, 0.0, 0.0, 0.0)
    triangles: FloatArray = field(default_factory=_no_triangles)


def solids(obstacle: Obstacles, unit: Literal["m", "cm", "mm"]) -> tuple[tuple[Solid, ...], ...]:
    """For each obstacle, solids whose union it is; a capsule is a cylinder and two spheres."""
    return tuple(_of(shape, METRES[unit]) for shape in obstacle)


def _of(shape: Obstacle, metres: float) -> tuple[Solid, ...]:
    if isinstance(shape, MeshShape):
        return (Solid("mesh", (1.0, 1.0, 1.0), triangles=shape.triangles() * metres),)
    centre, wxyz = _scaled(shape.position, metres), shape.wxyz
    if isinstance(shape, Box):
        return (Solid("box", _scaled(shape.size, metres), centre, wxyz),)
    width = 2 * shape.radius * metres
    ball = (width, width, width)
    if isinstance(shape, Sphere):
        return (Solid("sphere", ball, centre, wxyz),)
    height = shape.height * metres
    column = Solid("cylinder", (width, width, height), centre, wxyz)
    if isinstance(shape, Cylinder):
        return (column,)
    if not isinstance(shape, Capsule):
        assert_never(shape)
    half = rotation(wxyz)[:, 2] * height / 2
    ends = (_scaled(np.add(centre, side * half), 1.0) for side in (-1, 1))
    return (column, *(Solid("sphere", ball, end, wxyz) for end in ends))


def _scaled(vector: Vec3 | FloatArray, factor: float) -> Vec3:
    x, y, z = (float(number) * factor for number in vector)
    return (x, y, z)
