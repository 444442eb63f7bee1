"""Obstacles of a plan as written, each number taken exactly."""

from __future__ import annotations

import contextlib
from fractions import Fraction
from pathlib import Path
from typing import Any

from abi import assets
from abi.errors import SceneError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.primitives import Box, Capsule, Cylinder, Sphere
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.obstacles.triangle_mesh.surface import Surface
from abi.scene.scene import Scene
from abi.verify.exact.mesh import ExactMesh
from abi.verify.exact.solids import ExactSolid
from abi.verify.plan_fields import list_of, mapping, numbers_of, vector_of


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
            expected = f"{error.expected}, beside the plan or in the folder of --meshes"
            raise SceneError(error.field, name, expected) from None


def obstacles_of(data: Any, scene: Scene) -> list[ExactSolid | ExactMesh]:
    """Solids of a plan's scene, whose meshes ``scene`` has read.

    Raises:
        SceneError: a field has the wrong form.
    """
    entries = list_of("scene.obstacles", mapping("scene", data).get("obstacles", []))
    if len(entries) != len(scene.obstacles):
        raise SceneError("scene.obstacles", len(entries), "those of the scene")
    return [
        _obstacle(mapping("scene.obstacles", entry), shape)
        for entry, shape in zip(entries, scene.obstacles, strict=True)
    ]


def _obstacle(entry: dict[str, Any], shape: object) -> ExactSolid | ExactMesh:
    position = vector_of("scene.obstacles.position", entry.get("position", (0.0, 0.0, 0.0)))
    w, x, y, z = numbers_of("scene.obstacles.wxyz", entry.get("wxyz", (1.0, 0.0, 0.0, 0.0)))
    if isinstance(shape, MeshShape):
        surface = shape.surface
        return ExactMesh(
            surface.vertices, surface.faces, surface.closed, shape.factor, position, (w, x, y, z)
        )
    zero = Fraction(0)
    half, disc, ball = (zero, zero, zero), zero, zero
    if isinstance(shape, Box):
        a, b, c = vector_of("scene.obstacles.size", entry["size"])
        half = (a / 2, b / 2, c / 2)
    else:
        if not isinstance(shape, Sphere | Cylinder | Capsule):
            raise SceneError("scene.obstacles.shape", entry.get("shape"), "one that can be checked")
        radius = Fraction(entry["radius"])
        disc, ball = (radius, zero) if isinstance(shape, Cylinder) else (zero, radius)
        half = (zero, zero, Fraction(entry.get("height", 0)) / 2)
    return ExactSolid(half, disc, ball, position, (w, x, y, z))
