"""Body of an arm's link: all the solids that it is drawn with, as one mesh."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from abi.arrays import ByteArray, FloatArray, IntArray
from abi.robot.urdf.link import LinkShape
from app.drawing import solids
from app.drawing.glb import triangle_set
from app.ui import style

ColouredTriangles = tuple[FloatArray, IntArray, ByteArray]
"""Vertices (n, 3), [unit], faces (m, 3), and red, green and blue of the vertices, (n, 3)."""


def link_glbs(shapes: Sequence[LinkShape], pose: FloatArray, scale: float) -> tuple[bytes, bytes]:
    """Binary glTF of a link in its own colours, and in that of what touches something.

    Args:
        shapes: what it is drawn with, all with colours.
        pose: of the link in the frame that moves it, (4, 4), in the unit of the shapes.
        scale: factor from that unit to the scene's.
    """
    vertices, faces, colours = link_mesh(shapes, pose, scale)
    touching = np.tile(np.array(style.TOUCHING, np.uint8), (len(vertices), 1))
    return triangle_set(vertices, faces, colours), triangle_set(vertices, faces, touching)


def link_mesh(shapes: Sequence[LinkShape], pose: FloatArray, scale: float) -> ColouredTriangles:
    """Triangles of a link in its own colours; arguments as for :func:`link_glbs`."""
    parts = [_solid(shape, pose @ shape.pose) for shape in shapes]
    vertices, faces, colours = zip(*parts, strict=True)
    counts = [0, *np.cumsum([len(part) for part in vertices])[:-1]]
    return (
        scale * np.concatenate(vertices),
        np.concatenate([part + count for part, count in zip(faces, counts, strict=True)]),
        np.concatenate(colours),
    )


def _solid(shape: LinkShape, pose: FloatArray) -> ColouredTriangles:
    """A shape in the frame that has the ``pose`` of its own."""
    if shape.kind == "mesh":
        vertices, faces = shape.vertices, shape.faces
    elif shape.kind == "box":
        vertices, faces = solids.box()
        vertices = vertices * shape.size
    elif shape.kind == "sphere":
        vertices, faces = solids.sphere()
        vertices = vertices * shape.size[0]
    else:
        radius, length, _ = shape.size
        vertices, faces = solids.cylinder()
        vertices = vertices * (radius, radius, length)
    placed = vertices @ pose[:3, :3].T + pose[:3, 3]
    return _coloured(placed, faces, shape.colours)


def _coloured(vertices: FloatArray, faces: IntArray, colours: ByteArray) -> ColouredTriangles:
    """Triangles with a colour for all, (1, 3), or for each, (m, 3); none mixes at a vertex."""
    if len(colours) == 1:
        return vertices, faces, np.repeat(colours, len(vertices), axis=0)
    _, kinds = np.unique(colours, axis=0, return_inverse=True)
    corners = np.column_stack((faces.ravel(), np.repeat(kinds.ravel(), 3)))
    kept, first, places = np.unique(corners, axis=0, return_index=True, return_inverse=True)
    own = colours[first // 3]
    return vertices[kept[:, 0]], places.reshape(-1, 3).astype(np.int32), own
