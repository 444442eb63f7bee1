"""Marked nodes and points: what a search visited or reached, and what a diagnosis names."""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray

from abi.arrays import IntArray
from abi.explain.reason import Reason
from abi.planner.plan import Plan
from abi.search.search import SearchResult
from app.layers.points import add_points, set_points
from app.state.frame import Draw, Frame
from app.ui import style
from app.ui.colour_scale import scale_colours
from app.ui.layout import Layout

NODE_BUDGET = 20_000
"""Nodes a tab is sent at the most."""


def marks_layer(layout: Layout) -> Draw:
    """Nodes in the order in which the chosen algorithm expanded them, and large bright points.

    A search that is stepped through has nodes in these colours of its own: then there are none.
    """
    scene = layout.client.scene
    visited = add_points(scene, "/search/reached")
    latest = add_points(scene, "/search/latest")
    named = add_points(scene, "/marks")
    drawn: tuple[object, int] | None = None
    told: Reason | None = None

    def draw(frame: Frame) -> None:
        nonlocal drawn, told
        plan, result = frame.plan, frame.plan.path
        order = np.zeros(0, np.int32)
        if frame.theatre is None:
            order = _reached(plan) if result is None else result.order[: frame.visited]
        state = (plan.error if result is None else result), len(order)
        if state != drawn:
            drawn = state
            _draw_nodes(visited, latest, plan, order)
        reason = frame.reason if frame.theatre is None else None
        if reason is not told:
            told = reason
            named.visible = reason is not None and names_others(reason, plan)
            if reason is not None and named.visible:
                set_points(named, reason.points, style.MARK, 0.03 * max(plan.scene.workspace.size))

    return draw


def _draw_nodes(
    visited: viser.PointCloudHandle, latest: viser.PointCloudHandle, plan: Plan, order: IntArray
) -> None:
    """Draw the first part of a search's expansions, or what one that failed has reached."""
    some, result = plan.graph is not None and len(order) > 0, plan.path
    visited.visible = some
    latest.visible = some and result is not None
    if plan.graph is None or not some:
        return
    points, pitch = plan.graph.points, plan.graph.mesh.pitch
    if result is None:
        # in the colour that the page's hint names
        set_points(visited, points[_thinned(order)], style.A_STAR, 0.08 * pitch)
        return
    nodes, colours = _in_order(order, result)
    set_points(visited, points[nodes], colours, 0.13 * pitch)
    set_points(latest, points[order[-1:]], style.MARK, 0.26 * pitch)


def _reached(plan: Plan) -> IntArray:
    """Nodes that the start reaches where there is no path; none where there is a path."""
    return np.zeros(0, np.int32) if plan.error is None else plan.error.reached


def names_others(reason: Reason, plan: Plan) -> bool:
    """Check if a reason has points, and others than the nodes that the start reaches."""
    if plan.graph is None or not len(_reached(plan)):
        return len(reason.points) > 0
    reached = plan.graph.points[np.sort(_reached(plan))]
    return len(reason.points) > 0 and not np.array_equal(reached, reason.points)


def _in_order(order: IntArray, result: SearchResult) -> tuple[IntArray, NDArray[np.uint8]]:
    """Nodes (k,) that were expanded in an order, and the colour (k, 3) of each by its turn."""
    # Bellman-Ford may expand a node again: the last time counts
    found, from_end = np.unique(order[::-1], return_index=True)
    nodes, ranks = _thinned(found), _thinned((len(order) - 1 - from_end).astype(np.int32))
    return nodes, scale_colours(style.HEAT, ranks / max(result.expanded - 1, 1))


def _thinned(nodes: IntArray) -> IntArray:
    """Thin out the nodes to be drawn to those that the budget allows."""
    return nodes[:: -(-len(nodes) // NODE_BUDGET)]
