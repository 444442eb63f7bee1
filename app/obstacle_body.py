"""The surface of an obstacle as a node of the scene."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import viser

from abi.arrays import FloatArray, IntArray
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle
from abi.obstacles.primitives import Box, Capsule, Cylinder, Sphere
from app import style
from app.mesh_picture import drawn_triangles

Body = viser.BoxHandle | viser.IcosphereHandle | viser.MeshHandle

_OPACITY, _LEAST_OPACITY = 0.62, 0.25
_SUBDIVISIONS = 8


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
    if isinstance(obstacle, Box):
        return scene.add_box(name, dimensions=obstacle.size, **look)
    if isinstance(obstacle, Sphere):
        return scene.add_icosphere(name, radius=obstacle.radius, subdivisions=_SUBDIVISIONS, **look)
    if isinstance(obstacle, MeshShape):
        vertices, faces = drawn_triangles(obstacle.surface)
        vertices = vertices * np.float32(obstacle.factor)
        return scene.add_mesh_simple(name, vertices, faces, flat_shading=True, **look)
    vertices, faces = _round_body(obstacle)
    return scene.add_mesh_simple(name, vertices, faces, **look)


def _round_body(obstacle: Cylinder | Capsule) -> tuple[FloatArray, IntArray]:
    """Vertices and triangles of a cylinder or a capsule along z, from one of radius 1."""
    half = obstacle.height / 2
    if isinstance(obstacle, Cylinder):
        vertices, faces = _unit_cylinder()
        return vertices * np.array([obstacle.radius, obstacle.radius, half], np.float32), faces
    vertices, faces = _unit_capsule()
    away = np.sign(vertices[:, 2:]) * np.array([0, 0, half - obstacle.radius], np.float32)
    return vertices * np.float32(obstacle.radius) + away, faces


@cache
def _unit_cylinder() -> tuple[FloatArray, IntArray]:
    """Of radius 1 and from -1 to 1 along z."""
    from trimesh import creation  # here, since it takes long to import

    mesh = creation.cylinder(radius=1, height=2, sections=48)
    return mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32)


@cache
def _unit_capsule() -> tuple[FloatArray, IntArray]:
    """Of radius 1 with the centres of its caps at -1 and 1 along z."""
    from trimesh import creation  # here, since it takes long to import

    mesh = creation.capsule(radius=1, height=2, count=(24, 24))
    mesh.apply_translation((0, 0, -mesh.bounds.mean(axis=0)[2]))
    return mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32)


def add_edges(scene: viser.SceneApi, name: str, mesh: MeshShape) -> viser.MeshHandle:
    """Add the edges of a mesh's triangles, in its own frame."""
    vertices, faces = drawn_triangles(mesh.surface)
    vertices = vertices * np.float32(mesh.factor)
    colour = style.EXCLUDED
    return scene.add_mesh_simple(name, vertices, faces, color=colour, wireframe=True, opacity=0.6)
