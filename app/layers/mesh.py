"""The tetrahedral mesh: its edges, its nodes, and what the obstacles took away."""

from __future__ import annotations

import numpy as np
import viser

from abi.arrays import FloatArray, IntArray
from abi.planner.plan import Plan
from abi.tet_mesh.subset import excerpt, fits
from app import glb, style

EDGE_BUDGET = 30_000
"""Edges a tab is sent at the most; beyond it a part of the mesh is shown."""

_WHAT = {
    "near": "those nearest to path and obstacles",
    "slice_x": "a slice across x",
    "slice_y": "a slice across y",
    "slice_z": "a slice across z",
    "surface": "those at the workspace's sides and at the obstacles",
}


class MeshLayer:
    """Draws edges as one line set and nodes as points.

    Attributes:
        note: how much of the mesh is shown, empty when all is.
        behind: whether the picture waits for the hand to rest.
    """

    def __init__(self, client: viser.ClientHandle) -> None:
        self._scene = client.scene
        self._edges: viser.GlbHandle | None = None
        self._clouds: dict[str, viser.PointCloudHandle] = {}
        self._visible = {"edges": True, "nodes": True, "excluded": True}
        self._drawn: tuple[object, ...] = ()
        self.note = ""
        self.behind = False

    def draw(self, plan: Plan, view: str, hasty: bool) -> None:
        """Draw the plan's mesh.

        Args:
            plan: what was planned last.
            view: which part of the mesh to draw, of :data:`abi.tet_mesh.subset.VIEWS`.
            hasty: whether the hand may still move: then a mesh that is more than the tab is sent
                at once waits, and what it excludes is not shown meanwhile.
        """
        whole = plan.free is None or fits(plan.free, EDGE_BUDGET)
        # where not all is shown, what is near the path
        state = (plan.free, plan.graph, view, None if whole else plan.path)
        if plan.free is None or state == self._drawn:
            self.behind = False
            return
        self.behind = hasty and self._edges is not None and not whole
        if self.behind:
            self._hide("excluded")
            return
        self._drawn = state
        near = plan.path.points if plan.path is not None else np.array([plan.scene.start])
        part = excerpt(plan.free, plan.graph, plan.scene.obstacles, near, view, EDGE_BUDGET)
        self.note = ""
        if len(part.edges) < part.edges_in_all:
            self.note = f"{len(part.edges):,} of {part.edges_in_all:,} edges shown: {_WHAT[view]}"
        self._draw_edges(part.points, part.edges)
        size = min(0.05 * plan.free.mesh.pitch, 0.008 * max(plan.scene.workspace.size))
        self._draw_cloud("nodes", part.points, style.MESH, size)
        self._draw_cloud("excluded", part.excluded, style.EXCLUDED, 1.6 * size)

    def show(self, edges: bool, nodes: bool, excluded: bool) -> None:
        """Switch the three parts."""
        self._visible = {"edges": edges, "nodes": nodes, "excluded": excluded}
        if self._edges is not None:
            self._edges.visible = edges
        for name, cloud in self._clouds.items():
            cloud.visible = self._visible[name] and not (self.behind and name == "excluded")

    def _hide(self, name: str) -> None:
        if name in self._clouds:
            self._clouds[name].visible = False

    def _draw_edges(self, points: FloatArray, edges: IntArray) -> None:
        if len(edges) == 0:
            if self._edges is not None:
                self._edges.remove()
                self._edges = None
            return
        data = glb.lines(points, edges, style.MESH, _opacity(len(edges)))
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
    return float(np.clip(0.4 * (1000 / max(edges, 1)) ** 0.6, 0.1, 0.4))
