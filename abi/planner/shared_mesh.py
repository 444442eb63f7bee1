"""Meshes that planners share: tables of a large one take megabytes, and never change."""

from __future__ import annotations

from weakref import WeakValueDictionary

from abi.scene.settings import MeshSettings, Workspace
from abi.tet_mesh.tet_mesh import TetMesh, tetrahedralise

_IN_USE: WeakValueDictionary[tuple[Workspace, MeshSettings], TetMesh] = WeakValueDictionary()


def shared_mesh(workspace: Workspace, settings: MeshSettings) -> TetMesh:
    """Return the mesh of a box that is in use, or a new one, as :func:`tetrahedralise` makes it."""
    key = workspace, settings
    mesh = _IN_USE.get(key)
    return mesh or _IN_USE.setdefault(key, tetrahedralise(workspace, settings))
