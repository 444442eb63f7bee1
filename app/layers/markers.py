"""Points that a diagnosis names, such as the free point nearest to a blocked start."""

from __future__ import annotations

from typing import ClassVar

from abi.planner.reason import Reason
from app import style
from app.frame import Frame, Switch
from app.layers.points import Points
from app.layout import Layout


class MarkersLayer:
    """Large bright points."""

    switches: ClassVar[tuple[Switch, ...]] = ()

    def __init__(self, layout: Layout) -> None:
        self._drawn: Reason | None = None
        self._cloud = Points(layout.client.scene, "/marks")

    def draw(self, frame: Frame) -> None:
        """Mark the reason's points; none without a reason."""
        reason = frame.reason
        if reason is self._drawn:
            return
        self._drawn = reason
        if reason is None or len(reason.points) == 0:
            self._cloud.show(False)
            return
        size = 0.03 * max(frame.plan.scene.workspace.size)
        self._cloud.draw(reason.points, style.MARK, size, visible=True)
