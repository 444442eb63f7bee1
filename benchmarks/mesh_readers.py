"""Triangles of a mesh by other readers of its file: trimesh, meshio and pycollada."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import trimesh


def by_trimesh(file: Path) -> trimesh.Trimesh:
    """Those of trimesh."""
    return trimesh.load_mesh(str(file), process=False)


def by_meshio(file: Path) -> trimesh.Trimesh:
    """Those of meshio, which is of the extra ``bench``; polygons are cut into fans."""
    import meshio

    mesh = meshio.read(file)
    cells = [block.data for block in mesh.cells if block.dim == 2]
    faces = [
        np.stack([cell[:, 0], cell[:, k], cell[:, k + 1]], axis=1)
        for cell in map(np.asarray, cells)
        for k in range(1, cell.shape[1] - 1)
    ]
    return trimesh.Trimesh(mesh.points[:, :3], np.vstack(faces), process=False)


def by_pycollada(file: Path) -> trimesh.Trimesh:
    """Those of pycollada, placed in the scene as the file says, in the unit of the file."""
    import collada

    document = collada.Collada(str(file), ignore=[collada.common.DaeUnsupportedError])
    corners = []
    for geometry in document.scene.objects("geometry"):
        for part in geometry.primitives():
            if isinstance(part, collada.lineset.BoundLineSet):
                continue
            triangles = part.triangleset() if hasattr(part, "triangleset") else part
            corners.append(triangles.vertex[triangles.vertex_index].reshape(-1, 3))
    vertices = np.vstack(corners).astype(float)
    return trimesh.Trimesh(vertices, np.arange(len(vertices)).reshape(-1, 3), process=False)


READERS: Mapping[str, tuple[Callable[[Path], trimesh.Trimesh], frozenset[str]]] = {
    "trimesh": (by_trimesh, frozenset({".stl", ".obj", ".glb", ".ply", ".off", ".3mf", ".dae"})),
    "meshio": (by_meshio, frozenset({".stl", ".obj", ".ply", ".off"})),
    "pycollada": (by_pycollada, frozenset({".dae"})),
}
"""Readers by their names, and the endings of the files that each is asked for."""
