"""Nodes and edges near a triangle mesh, by libraries: VTK, trimesh with Embree, FCL, and Coal.

VTK measures how far nodes are, Embree casts rays to tell which are inside, and FCL and Coal collide
edges, as capsules of the margin's radius, with the triangles: of what installs, each does what it
does best. What is not installed is left out.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
import trimesh

from abi.arrays import BoolArray, FloatArray
from abi.obstacles.mesh_shape import MeshShape
from tests.abi import mesh_oracles

_NODES_NEED = ("vtkmodules", "embreex")

_EDGES_NEED = (("fcl",), ("coal", "eigenpy"))
"""Modules that each library for edges needs."""


def installed(modules: tuple[str, ...]) -> bool:
    """Check whether all of some modules are installed."""
    return all(importlib.util.find_spec(module) is not None for module in modules)


def can_compare() -> bool:
    """Check whether there are libraries for nodes and for edges."""
    return installed(_NODES_NEED) and any(map(installed, _EDGES_NEED))


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


class EdgeLibrary(Protocol):
    """A library that tells which edges come too near to a mesh."""

    def lost(self, starts: FloatArray, ends: FloatArray, margin: float) -> BoolArray:
        """Mask (n,) of the edges (n, 3) that touch the mesh or come nearer than the margin."""


def edge_libraries(mesh: MeshShape) -> list[EdgeLibrary]:
    """Those that are installed."""
    libraries: tuple[Callable[[MeshShape], EdgeLibrary], ...] = (_Fcl, _Coal)
    found = zip(libraries, _EDGES_NEED, strict=True)
    return [library(mesh) for library, modules in found if installed(modules)]


class _Fcl:
    """FCL, by a tree of its own."""

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
        """Flags (n,) of the segments that come nearer than the margin."""
        fcl, lost = self._fcl, np.zeros(len(starts), dtype=np.bool_)
        sizes, wxyz, middles = _along(starts, ends)
        request = fcl.CollisionRequest()
        for i in range(len(starts)):
            capsule = fcl.Capsule(margin, sizes[i])
            edge = fcl.CollisionObject(capsule, fcl.Transform(wxyz[i], middles[i]))
            lost[i] = fcl.collide(edge, self._mesh, request, fcl.CollisionResult()) > 0
        return lost


class _Coal:
    """Coal, the successor of HPP-FCL, by a tree of oriented boxes and swept spheres."""

    def __init__(self, mesh: MeshShape) -> None:
        import coal
        import eigenpy

        corners = mesh.triangles().reshape(-1, 3)
        faces = np.arange(len(corners)).reshape(-1, 3)
        model = coal.BVHModelOBBRSS()
        model.beginModel(len(faces), len(corners))
        model.addVertices(corners)
        model.addTriangles(faces)
        model.endModel()
        self._coal: Any = coal
        self._quaternion: Any = eigenpy.Quaternion
        self._mesh = model

    def lost(self, starts: FloatArray, ends: FloatArray, margin: float) -> BoolArray:
        """Flags (n,) of the segments that come nearer than the margin."""
        coal, lost = self._coal, np.zeros(len(starts), dtype=np.bool_)
        sizes, wxyz, middles = _along(starts, ends)
        request, here = coal.CollisionRequest(), coal.Transform3s.Identity()
        for i in range(len(starts)):
            capsule, turned = coal.Capsule(margin, sizes[i]), self._quaternion(*wxyz[i])
            there = coal.Transform3s(turned, middles[i])
            result = coal.CollisionResult()
            lost[i] = coal.collide(capsule, there, self._mesh, here, request, result) > 0
        return lost


def _along(starts: FloatArray, ends: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Lengths (n,) of edges, the shortest turns (n, 4) from z to them, and their middles (n, 3)."""
    along = ends - starts
    sizes = np.linalg.norm(along, axis=1)
    wxyz = np.stack(
        [1 + along[:, 2] / sizes, -along[:, 1] / sizes, along[:, 0] / sizes, 0 * sizes], axis=1
    )
    wxyz[wxyz[:, 0] < 1e-9] = (0.0, 1.0, 0.0, 0.0)
    wxyz /= np.linalg.norm(wxyz, axis=1, keepdims=True)
    return np.asarray(sizes), wxyz, (starts + ends) / 2
