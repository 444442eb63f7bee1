"""Points that a reason speaks of, such as the free point nearest to a blocked start."""

from __future__ import annotations

import numpy as np
import viser

from abi.planner.diagnosis import Reason
from abi.scene.scene import Scene
from app import style


class MarkersLayer:
    """Bright balls that nothing hides for long."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self._scene = client.scene
        self._cloud: viser.PointCloudHandle | None = None

    def draw(self, reason: Reason | None, scene: Scene) -> None:
        """Mark the reason's points; none without a reason."""
        if reason is None or len(reason.points) == 0:
            if self._cloud is not None:
                self._cloud.visible = False
            return
        self._cloud = self._scene.add_point_cloud(
            "/marks",
            reason.points.astype(np.float32),
            style.TRACE,
            point_size=0.03 * max(scene.workspace.size),
            point_shape="circle",
            precision="float32",
        )
