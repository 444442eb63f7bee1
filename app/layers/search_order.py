"""Nodes that a search has expanded so far."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from app import style
from app.frame import Frame, Switch
from app.layers.points import Points
from app.layout import Layout

NODE_BUDGET = 20_000
"""Nodes a tab is sent at the most."""


class SearchOrderLayer:
    """Nodes in the order in which the chosen algorithm expanded them."""

    switches: ClassVar[tuple[Switch, ...]] = ()

    def __init__(self, layout: Layout) -> None:
        self._cloud = Points(layout.client.scene, "/search/reached")
        self._drawn: object = None

    def draw(self, frame: Frame) -> None:
        """Draw the first part of the expansions; without a path, what the start reaches."""
        plan = frame.plan
        result = plan.path
        reached = getattr(plan.error, "reached", None)
        if result is not None and plan.graph is not None:
            count = round(frame.expanded_share * result.expanded)
            state: object = (result, count)
            order = result.order[:count]
            colour = style.ALGORITHMS[result.algorithm][1]
        else:
            order = np.zeros(0, np.int32) if reached is None else reached
            state = (plan.error, len(order))
            colour = style.A_STAR  # as the page's hint says
        if state == self._drawn:
            return
        self._drawn = state
        if plan.graph is None or len(order) == 0:
            self._cloud.show(False)
            return
        nodes = np.unique(order)
        stride = -(-len(nodes) // NODE_BUDGET)
        points = plan.graph.points[nodes[::stride]]
        size = (0.13 if result is not None else 0.08) * plan.graph.pitch
        self._cloud.draw(points, colour, size, visible=True)
