"""Nodes and edges near a triangle mesh, by libraries: VTK, trimesh with Embree, and FCL.

VTK measures how far nodes are, Embree casts rays to tell which are inside, and FCL collides edges,
as capsules of the margin's radius, with the triangles: of what installs, each does what it does
best. What is not installed is left out.
"""

from __future__ import annotations

import importlib.util
from typing import Any

import numpy as np
import trimesh

from abi.arrays import BoolArray, FloatArray
from abi.obstacles.mesh_shape import MeshShape
from tests.abi import mesh_oracles

NODES_NEED = ("vtkmodules", "embreex")
EDGES_NEED = ("fcl",)


def installed(modules: tuple[str, ...]) -> bool:
    """Whether all of some modules are installed."""
    return all(importlib.util.find_spec(module) is not None for module in modules)


class NodeLibraries:
    """Nodes that a mesh excludes, by VTK and Embree."""

    def __init__(self, mesh: MeshShape) -> None:
        triangles = mesh.triangles().reshape(-1, 3)
        faces = np.arange(len(triangles), dtype=np.int32).reshape(-1, 3)
        self._distances = mesh_oracles.Distances((triangles, faces))
        self._rays: Any = trimesh.Trimesh(*(triangles, faces), process=True)
        self._closed = mesh.closed

    def excluded(self, nodes: FloatArray, margin: float) -> BoolArray:
        """Mask (n,) of the nodes (n, 3) that are inside or nearer than the margin."""
        near = self._distances(nodes) < margin
        if self._closed:
            near |= self._rays.contains(nodes)
        return near


class EdgeLibrary:
    """Edges that come too near to a mesh, by FCL."""

    def __init__(self, mesh: MeshShape) -> None:
        import fcl

        corners = mesh.triangles().reshape(-1, 3)
        faces = np.arange(len(corners)).reshape(-1, 3)
        model = fcl.BVHModel()
        model.beginModel(len(corners), len(faces))
        model.addSubModel(corners, faces)
        model.endModel()
        self._fcl: Any = fcl
        self._mesh = fcl.CollisionObject(model)

    def lost(self, starts: FloatArray, ends: FloatArray, margin: float) -> BoolArray:
        """Mask (n,) of the edges (n, 3) that touch the mesh or come nearer than the margin."""
        fcl, lost = self._fcl, np.zeros(len(starts), dtype=np.bool_)
        along = ends - starts
        sizes = np.linalg.norm(along, axis=1)
        # the shortest turn from z to the edge
        wxyz = np.stack(
            [1 + along[:, 2] / sizes, -along[:, 1] / sizes, along[:, 0] / sizes, 0 * sizes], axis=1
        )
        wxyz[wxyz[:, 0] < 1e-9] = (0.0, 1.0, 0.0, 0.0)
        wxyz /= np.linalg.norm(wxyz, axis=1, keepdims=True)
        middles = (starts + ends) / 2
        request = fcl.CollisionRequest()
        for i in range(len(starts)):
            capsule = fcl.Capsule(margin, sizes[i])
            edge = fcl.CollisionObject(capsule, fcl.Transform(wxyz[i], middles[i]))
            lost[i] = fcl.collide(edge, self._mesh, request, fcl.CollisionResult()) > 0
        return lost
