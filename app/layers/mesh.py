"""The tetrahedral mesh: its edges, its nodes, and what the obstacles took away."""

from __future__ import annotations

import numpy as np
import viser
from scipy.spatial import cKDTree

from abi.arrays import FloatArray, IntArray
from abi.plan import Plan
from app import glb, style

EDGE_BUDGET = 30_000
"""Edges a tab is sent at the most; beyond it those nearest to the path are shown."""
NODE_BUDGET = 20_000


class MeshLayer:
    """Draws edges as one line set and nodes as points."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self._scene = client.scene
        self._edges: viser.GlbHandle | None = None
        self._clouds: dict[str, viser.PointCloudHandle] = {}
        self._visible = {"edges": True, "nodes": True, "excluded": True}
        self._drawn: object = None
        self.note = ""

    def draw(self, plan: Plan) -> None:
        """Draw the plan's mesh; ``note`` says how much of it is shown when not all is."""
        if plan.free is self._drawn or plan.free is None or plan.mesh is None:
            return
        self._drawn = plan.free
        mesh, excluded = plan.mesh, plan.free.excluded
        near = plan.path.points if plan.path is not None else np.array([plan.scene.start])
        free_edges = plan.graph.edges if plan.graph is not None else mesh.edges
        points = plan.graph.points if plan.graph is not None else mesh.points
        if plan.graph is None:
            free_edges = free_edges[~excluded[free_edges].any(axis=1)]
        shown = _nearest(points[free_edges].mean(axis=1), near, EDGE_BUDGET)
        self.note = (
            ""
            if len(shown) == len(free_edges)
            else f"{len(shown):,} of {len(free_edges):,} edges shown, those nearest to the path"
        )
        self._draw_edges(points, free_edges[shown])
        size = min(0.05 * mesh.pitch, 0.008 * max(plan.scene.workspace.size))
        nodes = mesh.points[~excluded]
        nodes = nodes[_nearest(nodes, near, NODE_BUDGET)]
        gone = mesh.points[excluded]
        gone = gone[_nearest(gone, near, NODE_BUDGET)]
        self._draw_cloud("nodes", nodes, style.MESH, size)
        self._draw_cloud("excluded", gone, style.EXCLUDED, 1.6 * size)

    def show(self, edges: bool, nodes: bool, excluded: bool) -> None:
        """Switch the three parts."""
        self._visible = {"edges": edges, "nodes": nodes, "excluded": excluded}
        if self._edges is not None:
            self._edges.visible = edges
        for name, cloud in self._clouds.items():
            cloud.visible = self._visible[name]

    def _draw_edges(self, points: FloatArray, edges: IntArray) -> None:
        if len(edges) == 0:
            if self._edges is not None:
                self._edges.remove()
                self._edges = None
            return
        used, local = np.unique(edges, return_inverse=True)
        data = glb.lines(
            points[used], local.reshape(-1, 2).astype(np.int32), style.MESH, _opacity(len(edges))
        )
        if self._edges is None:
            self._edges = self._scene.add_glb(
                "/mesh/edges",
                data,
                visible=self._visible["edges"],
                cast_shadow=False,
                receive_shadow=False,
            )
        else:
            self._edges.glb_data = data

    def _draw_cloud(self, name: str, points: FloatArray, colour: style.Colour, size: float) -> None:
        self._clouds[name] = self._scene.add_point_cloud(
            f"/mesh/{name}",
            points.astype(np.float32),
            colour,
            point_size=size,
            point_shape="circle",
            precision="float32",
            visible=self._visible[name],
        )


def _opacity(edges: int) -> float:
    """Fainter the more there are, so that the paths inside stay to be seen."""
    return float(np.clip(0.4 * (1000 / max(edges, 1)) ** 0.6, 0.04, 0.4))


def _nearest(points: FloatArray, targets: FloatArray, budget: int) -> IntArray:
    """Indices of the ``budget`` points nearest to any target; all of them when they fit."""
    if len(points) <= budget:
        return np.arange(len(points), dtype=np.int32)
    distance, _ = cKDTree(targets).query(points)
    return np.sort(np.argpartition(distance, budget)[:budget]).astype(np.int32)
