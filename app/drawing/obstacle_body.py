"""The surface of an obstacle as a node of the scene."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle
from abi.obstacles.primitives import Box, Sphere
from app.drawing.mesh_picture import drawn_triangles
from app.ui import style

Body = viser.BoxHandle | viser.IcosphereHandle | viser.MeshHandle

_OPACITY, _LEAST_OPACITY = 0.62, 0.25
_SUBDIVISIONS, _SIDES = 8, 40


def add_body(scene: viser.SceneApi, name: str, obstacle: Obstacle, share: float = 0.0) -> Body:
    """Add the obstacle's surface, in its own frame.

    Args:
        scene: to draw in.
        name: of the node.
        obstacle: its shape and size count.
        share: its size as a part of the workspace's: what fills it does not hide the path.
    """
    opacity = _OPACITY - (_OPACITY - _LEAST_OPACITY) * min(max(1.5 * share - 0.5, 0.0), 1.0)
    look: dict[str, Any] = {"color": style.OBSTACLE, "opacity": opacity, "side": "double"}
    # what the page can make by itself is not sent
    if isinstance(obstacle, Box):
        return scene.add_box(name, dimensions=obstacle.size, **look)
    if isinstance(obstacle, Sphere):
        return scene.add_icosphere(name, radius=obstacle.radius, subdivisions=_SUBDIVISIONS, **look)
    if isinstance(obstacle, MeshShape):
        vertices, faces = drawn_triangles(obstacle.surface)
        vertices = vertices * np.float32(obstacle.factor)
        return scene.add_mesh_simple(name, vertices, faces, flat_shading=True, **look)
    vertices, faces = obstacle.surface(_SIDES)
    return scene.add_mesh_simple(name, vertices.astype(np.float32), faces.astype(np.uint32), **look)


def add_edges(scene: viser.SceneApi, name: str, mesh: MeshShape) -> viser.MeshHandle:
    """Add the edges of a mesh's triangles, in its own frame."""
    vertices, faces = drawn_triangles(mesh.surface)
    vertices = vertices * np.float32(mesh.factor)
    colour = style.EXCLUDED
    return scene.add_mesh_simple(name, vertices, faces, color=colour, wireframe=True, opacity=0.6)
