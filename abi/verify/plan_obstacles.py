"""Obstacles of a plan's scene, each number taken exactly."""

from __future__ import annotations

import contextlib
from fractions import Fraction
from functools import partial
from pathlib import Path

from abi import assets
from abi.errors import SceneError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle
from abi.obstacles.primitives import Box, Capsule, Cylinder, Sphere
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.obstacles.triangle_mesh.surface import Surface
from abi.scene.scene import Scene
from abi.verify.exact.mesh import ExactMesh
from abi.verify.exact.solids import ExactSolid, vector


def meshes_beside(folder: Path, shipped: list[str]) -> MeshSource:
    """Mesh files in a plan's folder, or else those of the shipped scenes.

    Args:
        folder: the plan's.
        shipped: to which the names of the files are added that are taken from the shipped scenes.
    """
    return MeshSource(folder=folder, otherwise=partial(_of_shipped_scenes, folder, shipped))


def _of_shipped_scenes(folder: Path, shipped: list[str], name: str, error: SceneError) -> Surface:
    """The surface of a file of the shipped scenes; of one that is beside the plan, the error."""
    # a file that is there but is no mesh is what was meant
    if not (folder / name).exists():
        with contextlib.suppress(SceneError):
            surface = MeshSource(folder=assets.path("scenes")).surface(name)
            shipped.append(name)
            return surface
    expected = f"{error.expected}, beside the plan or in the folder or zip of --meshes"
    raise SceneError(error.field, name, expected) from None


def obstacles_of(scene: Scene) -> list[ExactSolid | ExactMesh]:
    """Solids of a plan's scene as it was read: what was planned with, and nothing else of the file.

    Raises:
        SceneError: a shape cannot be checked.
    """
    return [_obstacle(shape) for shape in scene.obstacles]


def _obstacle(shape: Obstacle) -> ExactSolid | ExactMesh:
    position, turn = vector(shape.position), shape.wxyz
    if isinstance(shape, MeshShape):
        surface = shape.surface
        content = surface.vertices, surface.faces, surface.closed
        return ExactMesh(*content, shape.factor, position, turn, surface.layers)
    zero = Fraction(0)
    half, disc, ball = (zero, zero, zero), zero, zero
    if isinstance(shape, Box):
        a, b, c = vector(shape.size)
        half = (a / 2, b / 2, c / 2)
    elif isinstance(shape, Sphere | Cylinder | Capsule):
        radius = Fraction(shape.radius)
        disc, ball = (radius, zero) if isinstance(shape, Cylinder) else (zero, radius)
        height = 0.0 if isinstance(shape, Sphere) else shape.height
        half = (zero, zero, Fraction(height) / 2)
    else:
        raise SceneError("scene.obstacles.shape", shape.shape, "one that can be checked")
    return ExactSolid(half, disc, ball, position, turn)
