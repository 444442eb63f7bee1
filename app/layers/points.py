"""Point clouds as all layers draw them."""

from __future__ import annotations

import numpy as np
import viser

from abi.arrays import FloatArray
from app.style import Colour


def add_points(
    scene: viser.SceneApi,
    name: str,
    points: FloatArray,
    colour: Colour,
    size: float,
    visible: bool = True,
) -> viser.PointCloudHandle:
    """Add ``points`` (n, 3), [unit], world, as discs of diameter ``size``, [unit]."""
    return scene.add_point_cloud(
        name,
        points.astype(np.float32),
        colour,
        point_size=size,
        point_shape="circle",
        precision="float32",
        visible=visible,
    )
