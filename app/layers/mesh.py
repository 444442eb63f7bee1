"""The tetrahedral mesh: its edges, its nodes, what the obstacles took away, and the numbers."""

from __future__ import annotations

import html
from typing import ClassVar

import numpy as np
import viser

from abi.arrays import FloatArray, IntArray
from abi.planner.plan import Plan
from abi.search.subset import excerpt, fits
from app import glb, style
from app.frame import Frame, Switch
from app.layout import Layout

EDGE_BUDGET = 30_000
"""Edges a tab is sent at the most; beyond it a part of the mesh is shown."""

_WAITING = f"{style.BOX}… counted when your hand rests.</div>"
_WHAT = {
    "near": "those nearest to path and obstacles",
    "slice_x": "a slice across x",
    "slice_y": "a slice across y",
    "slice_z": "a slice across z",
    "surface": "those at the workspace's sides and at the obstacles",
}


class MeshLayer:
    """Draws edges as one line set and nodes as points, and writes how many there are."""

    switches: ClassVar[tuple[Switch, ...]] = (
        Switch("edges", "mesh edges", style.MESH),
        Switch("nodes", "mesh nodes", style.MESH),
        Switch("excluded", "excluded", style.EXCLUDED),
    )

    def __init__(self, layout: Layout) -> None:
        self._scene = layout.client.scene
        with layout.folders["graph"]:
            self._text = layout.client.gui.add_html("")
        self._edges: viser.GlbHandle | None = None
        self._clouds: dict[str, viser.PointCloudHandle] = {}
        self._seen: tuple[object, ...] = ()
        self._drawn: tuple[object, ...] = ()
        self._written: tuple[object, ...] = ()
        self._note = ""
        self._behind = False

    def draw(self, frame: Frame) -> None:
        """Draw the plan's mesh, or the part of it that the frame asks for.

        In haste a mesh that is more than the tab is sent at once waits, and what it excludes is not
        shown meanwhile.
        """
        if (seen := (frame.plan, frame.mesh_view, frame.hasty)) != self._seen:
            self._seen = seen
            self._draw_mesh(frame)
        if self._edges is not None:
            self._edges.visible = "edges" in frame.shown
        for name, cloud in self._clouds.items():
            cloud.visible = name in frame.shown and not (self._behind and name == "excluded")
        if (state := (frame.plan, frame.partial, self._note)) != self._written:
            self._written = state
            self._text.content = _WAITING if frame.partial else _numbers(frame.plan, self._note)

    def _draw_mesh(self, frame: Frame) -> None:
        plan, view = frame.plan, frame.mesh_view
        whole = plan.free is None or fits(plan.free, EDGE_BUDGET)
        # where not all is shown, what is near the path
        state = (plan.free, plan.graph, view, None if whole else plan.path)
        if plan.free is None or state == self._drawn:
            self._behind = False
            return
        self._behind = frame.hasty and self._edges is not None and not whole
        if self._behind:
            return
        self._drawn = state
        near = plan.path.points if plan.path is not None else np.array([plan.scene.start])
        part = excerpt(plan.free, plan.graph, plan.scene.obstacles, near, view, EDGE_BUDGET)
        self._note = ""
        if len(part.edges) < part.edges_in_all:
            self._note = f"{len(part.edges):,} of {part.edges_in_all:,} edges shown: {_WHAT[view]}"
        self._draw_edges(part.points, part.edges)
        size = min(0.05 * plan.free.mesh.pitch, 0.008 * max(plan.scene.workspace.size))
        self._draw_cloud("nodes", part.points, style.MESH, size)
        self._draw_cloud("excluded", part.excluded, style.EXCLUDED, 1.6 * size)

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
                visible=False,
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
            visible=False,
        )


def _opacity(edges: int) -> float:
    """Fainter the more there are, so that the paths inside stay to be seen."""
    return float(np.clip(0.4 * (1000 / max(edges, 1)) ** 0.6, 0.1, 0.4))


def _numbers(plan: Plan, note: str) -> str:
    """Counts of the mesh and its graph; ``note`` says how much of it is drawn."""
    if plan.graph is None or plan.mesh is None or plan.free is None:
        return ""
    graph = plan.graph
    lines = [
        f"Pitch {plan.mesh.pitch:.4g} {plan.scene.unit} (asked for {plan.scene.mesh.pitch:.4g}), "
        f"{plan.free.tetrahedra_kept:,} tetrahedra, {int(plan.free.excluded.sum()):,} nodes "
        "excluded.",
        f"{graph.removed_edges:,} edges removed{_crossing(len(graph.crossing))}.",
    ]
    if note:
        lines.append(html.escape(note) + ".")
    return style.BOX + "<br>".join(lines) + "</div>"


def _crossing(count: int) -> str:
    return f", {count:,} of them between two free nodes: they cross an obstacle" if count else ""
