"""The tetrahedral mesh: its edges, its nodes, the excluded ones, and their counts."""

from __future__ import annotations

import html

import numpy as np
import viser

from abi import progress
from abi.arrays import FloatArray, IntArray
from abi.planner.plan import Plan
from abi.search.subset import edges_in_all, fits, subset
from app.drawing import glb
from app.drawing.straight_lines import straight_lines
from app.layers.points import add_points, set_lines, set_points
from app.shared.computed_once import once_a_plan
from app.stages.catalogue import SHOWN_STAGES
from app.state.frame import Frame
from app.ui import style
from app.ui.layout import Layout
from app.ui.numbers import format_setting

EDGE_BUDGET = 30_000
"""Edges a tab is sent at the most; of a larger mesh only a part is shown."""

_COUNTS_PENDING = style.paragraph("… counted when your hand rests.")
_VIEW_NAMES = {
    "near": "those nearest to path and obstacles",
    "slice_x": "a slice across x",
    "slice_y": "a slice across y",
    "slice_z": "a slice across z",
    "surface": "those at the workspace's sides and at the obstacles",
}
_FEW = 300
"""Nodes taken out up to which each is drawn in full size."""
_ABOUT_EDGES = frozenset(name for name, one in SHOWN_STAGES.items() if "edges" in one.layers)
"""Stages of a lecture that show nothing but the mesh, which is to be seen from the last row."""
_ARM_NOTE = ", or the arm would, with its tool tip there"


class MeshLayer:
    """Edges as one line set, nodes as points, and a note with their counts."""

    def __init__(self, layout: Layout) -> None:
        self._scene = layout.client.scene
        with layout.folders["graph"]:
            self._text = layout.client.gui.add_html("")
        self._edges: viser.GlbHandle | None = None
        self._clouds = {
            name: add_points(self._scene, f"/mesh/{name}") for name in ("nodes", "excluded")
        }
        self._seen: tuple[object, ...] = ()
        self._drawn: tuple[object, ...] = ()
        self._written: tuple[object, ...] = ()
        self._note = ""
        self._stale = False

    def __call__(self, frame: Frame) -> None:
        """Draw the plan's mesh, or the part of it that the frame asks for.

        While the input changes or a newer plan is made, a mesh over the edge budget keeps its last
        picture, without the excluded nodes, which no longer fit.

        Raises:
            CancelledError: something else has been chosen. What takes long comes before what is
                drawn of it, so that the next frame finds the picture whole.
        """
        changes = frame.interactive, frame.outdated
        seen = frame.plan, frame.mesh_view, frame.stage, changes
        if seen != self._seen:
            self._draw_mesh(frame)
            self._seen = seen
        # of the scene before there may still be one, which is not true of this one
        known = frame.plan.free is not None
        if self._edges is not None:
            self._edges.visible = known and "edges" in frame.shown
        for name, cloud in self._clouds.items():
            fits_not = self._stale and name == "excluded"
            cloud.visible = known and name in frame.shown and not fits_not
        if self._stale and frame.outdated:
            return
        if (state := (frame.plan, self._note)) != self._written:
            counts = _COUNTS_PENDING if frame.plan.partial else _counts(frame.plan, self._note)
            self._written, self._text.content = state, counts

    def _draw_mesh(self, frame: Frame) -> None:
        plan, view = frame.plan, frame.mesh_view
        solid = frame.stage in _ABOUT_EDGES
        whole = plan.free is None or fits(plan.free, EDGE_BUDGET)
        # the part of a large mesh that is shown depends on the path
        state = (plan.free, plan.graph, view, None if whole else plan.path, solid)
        if plan.free is None or state == self._drawn:
            self._stale = False
            return
        waits = frame.interactive or frame.outdated
        self._stale = waits and self._edges is not None and not whole
        if self._stale:
            return
        points, edges, excluded = _part(plan, view)
        picture = _picture(plan, view, solid)
        self._drawn = state
        self._note = ""
        in_all = edges_in_all(plan.free, plan.graph)
        if len(edges) < in_all:
            self._note = f"{len(edges):,} of {in_all:,} edges shown: {_VIEW_NAMES[view]}"
        self._edges = set_lines(self._scene, "/mesh/edges", self._edges, picture)
        size = min(0.05 * plan.free.mesh.pitch, 0.008 * max(plan.scene.workspace.size))
        set_points(self._clouds["nodes"], points, style.MESH, size)
        # many, as where the whole arm avoids, are smaller: what matters lies among them
        share = float(np.clip((_FEW / max(len(excluded), 1)) ** 0.5, 0.4, 1.0))
        set_points(self._clouds["excluded"], excluded, style.EXCLUDED, 1.6 * share * size)


@once_a_plan
def _part(plan: Plan, view: str) -> tuple[FloatArray, IntArray, FloatArray]:
    """Nodes, edges and excluded nodes of a plan's mesh that a view shows, see :func:`subset`."""
    assert plan.free is not None
    near = plan.path.points if plan.path is not None else np.array([plan.scene.start])
    return subset(plan.free, plan.graph, plan.scene.obstacles, near, view, EDGE_BUDGET)


@once_a_plan
def _picture(plan: Plan, view: str, solid: bool) -> bytes:
    """Edges of that part as binary glTF, ``solid`` or faint; empty where there are none."""
    points, edges, _ = _part(plan, view)
    progress.check()
    if not len(edges):
        return b""
    lines = points, edges
    if plan.mesh is not None and plan.mesh.stencil is not None:
        lines = straight_lines(*lines, plan.mesh.stencil)
    return glb.line_set(*lines, style.MESH, 1.0 if solid else _opacity(len(edges)))


def _opacity(edges: int) -> float:
    """Opacity of so many edges: fainter the more there are, to leave the paths visible."""
    return float(np.clip(0.22 * (1000 / max(edges, 1)) ** 0.5, 0.07, 0.22))


@once_a_plan
def _counts(plan: Plan, note: str) -> str:
    """Counts of the mesh and its graph as HTML, with the ``note`` on the part that is drawn."""
    if plan.graph is None or plan.mesh is None or plan.free is None:
        return ""
    graph = plan.graph
    progress.check()
    excluded = int(plan.free.excluded.sum())
    lie = "node lies" if excluded == 1 else "nodes lie"
    lines = [
        f"Spacing {format_setting(plan.mesh.pitch)} {plan.scene.unit}{_divides(plan)}; "
        f"{plan.free.tetrahedra_kept:,} tetrahedra; {excluded:,} {lie} in "
        f"an obstacle or too near one{_ARM_NOTE if plan.scene.arm.avoid else ''}.",
        f"{graph.removed_edges:,} edges removed{_crossing_note(len(graph.crossing))}.",
    ]
    if note:
        lines.append(html.escape(note) + ".")
    return style.paragraph("<br>".join(lines))


def _divides(plan: Plan) -> str:
    """Reason why the spacing is not the one asked for; empty where it is."""
    assert plan.mesh is not None
    asked, made = format_setting(plan.scene.mesh.pitch), format_setting(plan.mesh.pitch)
    return "" if asked == made else " (so that it divides the workspace)"


def _crossing_note(count: int) -> str:
    if not count:
        return ""
    words = "joins two free nodes but passes" if count == 1 else "join two free nodes but pass"
    return f"; {count:,} of these {words} through an obstacle"
