"""The surface of an obstacle as a node of the scene."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle
from abi.obstacles.primitives import Box, Cylinder, Sphere
from app import style

Body = viser.BoxHandle | viser.IcosphereHandle | viser.MeshHandle

_OPACITY = 0.62
_SUBDIVISIONS = 8


def add_body(scene: viser.SceneApi, name: str, obstacle: Obstacle) -> Body:
    """Add the obstacle's surface, in its own frame."""
    look: dict[str, Any] = {"color": style.OBSTACLE, "opacity": _OPACITY, "side": "double"}
    if isinstance(obstacle, Box):
        return scene.add_box(name, dimensions=obstacle.size, **look)
    if isinstance(obstacle, Sphere):
        return scene.add_icosphere(name, radius=obstacle.radius, subdivisions=_SUBDIVISIONS, **look)
    if isinstance(obstacle, MeshShape):
        vertices = (obstacle.surface.vertices * obstacle.factor).astype(np.float32)
        faces = obstacle.surface.faces.astype(np.uint32)
        return scene.add_mesh_simple(name, vertices, faces, flat_shading=True, **look)
    from trimesh import creation  # here, since it takes long to import

    if isinstance(obstacle, Cylinder):
        mesh = creation.cylinder(radius=obstacle.radius, height=obstacle.height, sections=48)
    else:
        mesh = creation.capsule(radius=obstacle.radius, height=obstacle.height, count=(24, 24))
        mesh.apply_translation((0, 0, -mesh.bounds.mean(axis=0)[2]))
    vertices, faces = mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32)
    return scene.add_mesh_simple(name, vertices, faces, **look)
