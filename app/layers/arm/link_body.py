"""Body of an arm's link: all the solids that it is drawn with, as one mesh."""

from __future__ import annotations

import functools
import operator
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from abi.arrays import FloatArray
from abi.robot.urdf.robot import LinkShape
from app.ui import style

if TYPE_CHECKING:
    import trimesh


def link_glbs(shapes: Sequence[LinkShape], pose: FloatArray, scale: float) -> tuple[bytes, bytes]:
    """Binary glTF of a link in its own colours, and in that of what touches something.

    Args:
        shapes: what it is drawn with, all with colours.
        pose: of the link in the frame that moves it, (4, 4), in the unit of the shapes.
        scale: factor from that unit to the scene's.
    """
    mesh = link_mesh(shapes, pose, scale)
    own = _glb(mesh)
    _colour(mesh, np.tile(np.array(style.TOUCHING, np.uint8), (len(mesh.faces), 1)))
    return own, _glb(mesh)


def link_mesh(shapes: Sequence[LinkShape], pose: FloatArray, scale: float) -> trimesh.Trimesh:
    """Mesh of a link in its own colours; arguments as for :func:`link_glbs`."""
    parts = [_solid(shape, pose @ shape.pose) for shape in shapes]
    mesh = functools.reduce(operator.add, parts)
    mesh.apply_scale(scale)  # type: ignore[no-untyped-call]
    pairs = zip(shapes, parts, strict=True)
    colours = [np.broadcast_to(shape.colours, (len(part.faces), 3)) for shape, part in pairs]
    _colour(mesh, np.concatenate(colours))
    return mesh


def _solid(shape: LinkShape, pose: FloatArray) -> trimesh.Trimesh:
    import trimesh  # here, since it takes long to import

    stretch = np.ones(4)
    mesh: trimesh.Trimesh
    # of size 1 at first: trimesh drops small faces as it makes them
    if shape.kind == "mesh":
        mesh = trimesh.Trimesh(shape.vertices, shape.faces, process=False)
    elif shape.kind == "box":
        mesh, stretch[:3] = trimesh.creation.box((1.0, 1.0, 1.0)), shape.size
    elif shape.kind == "sphere":
        mesh, stretch[:3] = trimesh.creation.icosphere(3), shape.size[0]
    else:
        radius, length, _ = shape.size
        mesh = trimesh.creation.cylinder(1.0, 1.0, sections=32)
        stretch[:3] = radius, radius, length
    mesh.apply_transform(pose @ np.diag(stretch))
    return mesh


def _colour(mesh: trimesh.Trimesh, colours: np.ndarray) -> None:
    """Give each face a colour, (m, 3)."""
    from trimesh.visual import ColorVisuals

    mesh.visual = ColorVisuals(mesh, face_colors=colours)


def _glb(mesh: trimesh.Trimesh) -> bytes:
    data = mesh.export(file_type="glb")
    assert isinstance(data, bytes)
    return data
