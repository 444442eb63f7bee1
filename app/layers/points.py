"""Point clouds as all layers draw them."""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray

from abi.arrays import FloatArray
from app.ui.style import Colour


class Points:
    """One cloud, of which only what changes is sent."""

    def __init__(self, scene: viser.SceneApi, name: str) -> None:
        self._scene, self._name = scene, name
        self._cloud: viser.PointCloudHandle | None = None

    def draw(
        self,
        points: FloatArray,
        colour: Colour | NDArray[np.uint8],
        size: float,
        visible: bool | None = None,
    ) -> None:
        """Draw ``points`` (n, 3), [unit], world, as discs of diameter ``size``, [unit].

        Args:
            points: where.
            colour: of all of them, or (n, 3) of each.
            size: of a disc.
            visible: whether they are seen; None for as before, at first for seen.
        """
        colours = np.array(colour, np.uint8)
        if colours.size == 0:
            colours = np.zeros(3, np.uint8)  # without points, too, the page asks for a colour
        if self._cloud is None:
            self._cloud = self._scene.add_point_cloud(
                self._name,
                points.astype(np.float32),
                colours,
                point_size=size,
                point_shape="circle",
                precision="float32",
                visible=visible is not False,
            )
            return
        self._cloud.points = points.astype(np.float32)
        self._cloud.colors = colours
        self._cloud.point_size = size
        if visible is not None:
            self._cloud.visible = visible

    def show(self, on: bool) -> None:
        """Show or hide the cloud, if there is one."""
        if self._cloud is not None:
            self._cloud.visible = on
