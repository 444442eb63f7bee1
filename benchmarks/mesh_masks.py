"""Exclusions by triangle meshes, against distances by another library."""

from __future__ import annotations

import numpy as np

from abi.arrays import BoolArray, FloatArray
from abi.obstacles.mesh_shape import MeshShape
from abi.planner.planner import plan
from abi.scene.scene import Scene
from abi.search.graph import Graph
from tests.abi import mesh_oracles

_INNER = 17
_ROUNDING = 1e-8
_SAMPLE = 300


def mask_fault(scene: Scene) -> str:
    """Name the first fault of the nodes and edges that a plan keeps or leaves out; "" without one.

    A node that is kept keeps the margin, one that is left out does not. Edges between free nodes
    are sampled densely: none of an open one is too near, and one of a shut one is, but for the
    distance between samples. Winding numbers tell inside from outside, of a sample of the nodes.
    """
    # the arm may leave out more
    graph = plan(scene.replace(arm=scene.arm.model_dump() | {"avoid": False})).graph
    if graph is None:
        return ""
    margin = scene.spline.clearance + scene.workspace.slack
    shapes = [mesh for mesh in scene.obstacles if isinstance(mesh, MeshShape)]
    away = np.min([_distances(mesh, graph.mesh.points) for mesh in shapes], axis=0)
    inside = np.zeros(len(away), dtype=np.bool_)
    known = np.zeros(len(away), dtype=np.bool_)
    random = np.random.default_rng(0)
    for which in (graph.excluded & (away > margin), ~graph.excluded):
        rows = np.flatnonzero(which)
        rows = random.permutation(rows)[:_SAMPLE]
        inside[rows] = _inside_any(shapes, graph.mesh.points[rows])
        known[rows] = True
    too_near = (away < margin - _ROUNDING) | inside
    if (too_near & ~graph.excluded).any():
        return "a node is kept that is too near"
    if (graph.excluded & (away > margin + _ROUNDING) & known & ~inside).any():
        return "a node is left out that is far"
    return _edge_fault(graph, shapes, away, margin)


def _edge_fault(graph: Graph, shapes: list[MeshShape], away: FloatArray, margin: float) -> str:
    points, ends = graph.mesh.points, graph.edges
    of_mesh = ends[(ends < len(points)).all(axis=1)]
    for pairs, is_open in ((of_mesh, True), (graph.crossing, False)):
        sizes = np.linalg.norm(points[pairs[:, 1]] - points[pairs[:, 0]], axis=1)
        near = away[pairs].sum(axis=1) < 2 * margin + sizes
        if not is_open and not near.all():
            return "an edge is shut that is far"
        pairs, sizes = pairs[near], sizes[near]
        share = np.linspace(0, 1, _INNER)[:, None, None]
        samples = points[pairs[:, 0]] + share * (points[pairs[:, 1]] - points[pairs[:, 0]])
        least = np.full(len(pairs), np.inf)
        for mesh in shapes:
            found = _distances(mesh, samples.reshape(-1, 3)).reshape(_INNER, -1)
            least = np.minimum(least, found.min(axis=0, initial=np.inf))
        if is_open and (least < margin - _ROUNDING).any():
            return "an edge is open that is too near"
        between = sizes / (2 * (_INNER - 1))
        if not is_open and (least > margin + between + 1e-7).any():
            return "an edge is shut that is far"
    return ""


def _distances(mesh: MeshShape, points: FloatArray) -> FloatArray:
    triangles = mesh.triangles()
    faces = np.arange(3 * len(triangles), dtype=np.int32).reshape(-1, 3)
    return mesh_oracles.distances((triangles.reshape(-1, 3), faces), points)


def _inside_any(shapes: list[MeshShape], points: FloatArray) -> BoolArray:
    inside = np.zeros(len(points), dtype=np.bool_)
    for mesh in shapes:
        low, high = mesh.bounds()
        rows = np.flatnonzero(((points > low) & (points < high)).all(axis=1))
        if mesh.closed and len(rows):
            numbers = mesh_oracles.winding_numbers(mesh.triangles(), points[rows])
            inside[rows] |= np.abs(numbers) > 0.5
    return inside
