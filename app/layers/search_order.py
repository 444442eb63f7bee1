"""Nodes that a search has expanded so far, in colours that tell their order."""

from __future__ import annotations

import numpy as np

from abi.arrays import IntArray
from app.layers.points import Points
from app.state.frame import Frame, Layer
from app.ui import style
from app.ui.colour_scale import scale_colours
from app.ui.layout import Layout

NODE_BUDGET = 20_000
"""Nodes a tab is sent at the most."""


class SearchOrderLayer(Layer):
    """Nodes in the order in which the chosen algorithm expanded them."""

    def __init__(self, layout: Layout) -> None:
        self._cloud = Points(layout.client.scene, "/search/reached")
        self._latest = Points(layout.client.scene, "/search/latest")
        self._drawn: object = None

    def draw(self, frame: Frame) -> None:
        """Draw the first part of the expansions; without a path, what the start reaches."""
        plan = frame.plan
        result = plan.path
        reached = getattr(plan.error, "reached", None)
        state: object
        if frame.theatre is not None:  # which has nodes in these colours of its own
            order, state = np.zeros(0, np.int32), None
        elif result is not None and plan.graph is not None:
            order = result.order[: frame.visited]
            state = (result, len(order))
        else:
            order = np.zeros(0, np.int32) if reached is None else reached
            state = (plan.error, len(order))
        if state == self._drawn:
            return
        self._drawn = state
        if plan.graph is None or len(order) == 0:
            self._cloud.show(False)
            self._latest.show(False)
            return
        pitch, points = plan.graph.mesh.pitch, plan.graph.points
        if result is None:
            nodes = _thinned(order)
            self._latest.show(False)
            # in the colour that the page's hint names
            self._cloud.draw(points[nodes], style.A_STAR, 0.08 * pitch, visible=True)
            return
        # Bellman-Ford may expand a node again: the last time counts
        found, from_end = np.unique(order[::-1], return_index=True)
        nodes, ranks = _thinned(found), _thinned((len(order) - 1 - from_end).astype(np.int32))
        colours = scale_colours(style.HEAT, ranks / max(result.expanded - 1, 1))
        self._cloud.draw(points[nodes], colours, 0.13 * pitch, visible=True)
        self._latest.draw(points[order[-1:]], style.MARK, 0.26 * pitch, visible=True)


def _thinned(nodes: IntArray) -> IntArray:
    """Thin out the nodes to be drawn to those that the budget allows."""
    return nodes[:: -(-len(nodes) // NODE_BUDGET)]
