"""Points that a diagnosis names, such as the free point nearest to a blocked start."""

from __future__ import annotations

from typing import ClassVar

import viser

from abi.planner.reason import Reason
from app import style
from app.frame import Frame, Switch
from app.layers.points import add_points
from app.layout import Layout


class MarkersLayer:
    """Large bright points."""

    switches: ClassVar[tuple[Switch, ...]] = ()

    def __init__(self, layout: Layout) -> None:
        self._scene = layout.client.scene
        self._drawn: Reason | None = None
        self._cloud: viser.PointCloudHandle | None = None

    def draw(self, frame: Frame) -> None:
        """Mark the reason's points; none without a reason."""
        reason = frame.reason
        if reason is self._drawn:
            return
        self._drawn = reason
        if reason is None or len(reason.points) == 0:
            if self._cloud is not None:
                self._cloud.visible = False
            return
        size = 0.03 * max(frame.plan.scene.workspace.size)
        self._cloud = add_points(self._scene, "/marks", reason.points, style.MARK, size)
