"""Obstacles of a plan's scene, each number taken exactly."""

from __future__ import annotations

import contextlib
from fractions import Fraction
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


class PlanMeshes(MeshSource):
    """Mesh files beside a plan, or else those of the shipped scenes.

    Attributes:
        shipped: names of the files taken from the shipped scenes.
    """

    def __init__(self, folder: Path) -> None:
        super().__init__(folder=folder)
        self.shipped: list[str] = []
        self._folder = folder

    def surface(self, name: str) -> Surface:
        """Source of the meshes, as in :class:`MeshSource`."""
        try:
            return super().surface(name)
        except SceneError as error:
            # a file that is there but is no mesh is what was meant
            if not (self._folder / name).exists():
                with contextlib.suppress(SceneError):
                    surface = MeshSource(folder=assets.path("scenes")).surface(name)
                    self.shipped.append(name)
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
        return ExactMesh(
            surface.vertices, surface.faces, surface.closed, shape.factor, position, turn
        )
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
