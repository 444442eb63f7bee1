"""Points that a diagnosis names, such as the free point nearest to a blocked start."""

from __future__ import annotations

import numpy as np

from abi.errors import NoPath
from abi.explain.reason import Reason
from abi.planner.plan import Plan
from app.layers.points import Points
from app.state.frame import Frame, Layer
from app.ui import style
from app.ui.layout import Layout


class MarkersLayer(Layer):
    """Large bright points."""

    def __init__(self, layout: Layout) -> None:
        self._drawn: Reason | None = None
        self._cloud = Points(layout.client.scene, "/marks")

    def draw(self, frame: Frame) -> None:
        """Mark the reason's points; none without a reason."""
        # a search that is stepped through has a node of that colour
        reason = frame.reason if frame.theatre is None else None
        if reason is self._drawn:
            return
        self._drawn = reason
        if reason is None or len(reason.points) == 0 or _are_reached(reason, frame.plan):
            self._cloud.show(False)
            return
        size = 0.03 * max(frame.plan.scene.workspace.size)
        self._cloud.draw(reason.points, style.MARK, size, visible=True)


def _are_reached(reason: Reason, plan: Plan) -> bool:
    """Check if the points are the nodes that the start reaches, which another layer draws."""
    if not isinstance(plan.error, NoPath) or plan.error.reached is None or plan.graph is None:
        return False
    reached = plan.graph.points[np.sort(plan.error.reached)]
    return np.array_equal(reached, reason.points)
