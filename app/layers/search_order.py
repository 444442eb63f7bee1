"""What a search has reached so far, node by node."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import viser

from app import style
from app.frame import Frame, Switch
from app.layout import Layout

NODE_BUDGET = 20_000


class SearchOrderLayer:
    """Colours the nodes in the order in which the chosen algorithm expanded them."""

    switches: ClassVar[tuple[Switch, ...]] = ()

    def __init__(self, layout: Layout) -> None:
        self._scene = layout.client.scene
        self._cloud: viser.PointCloudHandle | None = None
        self._drawn: object = None

    def draw(self, frame: Frame) -> None:
        """Draw the first part of the expansions.

        Without a path and with nothing asked for, what the start can reach is shown instead.
        """
        plan = frame.plan
        result = plan.path
        reached = getattr(plan.error, "reached", None)
        if result is not None and plan.graph is not None:
            count = round(frame.expanded_share * result.expanded)
            state: object = (result, count)
            order = result.order[:count]
            colour = style.ALGORITHMS[result.algorithm][1]
        else:
            count = 0 if reached is None else len(reached)
            state = (plan.error, count)
            order = np.zeros(0, np.int32) if reached is None else reached
            colour = style.A_STAR  # as the sentence says
        if state == self._drawn:
            return
        self._drawn = state
        if plan.graph is None or len(order) == 0:
            if self._cloud is not None:
                self._cloud.visible = False
            return
        nodes = np.unique(order)
        stride = -(-len(nodes) // NODE_BUDGET)
        self._cloud = self._scene.add_point_cloud(
            "/search/reached",
            plan.graph.points[nodes[::stride]].astype(np.float32),
            colour,
            point_size=(0.13 if result is not None else 0.08) * plan.graph.pitch,
            point_shape="circle",
            precision="float32",
        )
