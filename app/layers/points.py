"""Point clouds and sets of many straight lines as all layers draw them."""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray

from abi.arrays import FloatArray
from app.ui.style import Colour


def add_points(scene: viser.SceneApi, name: str) -> viser.PointCloudHandle:
    """Add a cloud without points yet, which is not seen."""
    return scene.add_point_cloud(
        name,
        np.zeros((0, 3), np.float32),
        np.zeros(3, np.uint8),
        point_shape="circle",
        precision="float32",
        visible=False,
    )


def set_points(
    cloud: viser.PointCloudHandle,
    points: FloatArray,
    colour: Colour | NDArray[np.uint8],
    size: float,
) -> None:
    """Draw ``points`` (n, 3), [unit], world, as discs of diameter ``size``, [unit].

    Args:
        cloud: of :func:`add_points`.
        points: where.
        colour: of all of them, or (n, 3) of each.
        size: of a disc.
    """
    colours = np.array(colour, np.uint8)
    if colours.size == 0:
        colours = np.zeros(3, np.uint8)  # without points, too, the page asks for a colour
    cloud.points, cloud.colors = points.astype(np.float32), colours
    cloud.point_size = size


def set_lines(
    scene: viser.SceneApi, name: str, before: viser.GlbHandle | None, data: bytes
) -> viser.GlbHandle | None:
    """Draw a set of lines of :mod:`app.drawing.glb` instead of those ``before``.

    Empty data take these away; then there is no handle.
    """
    if before is None:
        return scene.add_glb(name, data, cast_shadow=False, receive_shadow=False) if data else None
    if data:
        before.glb_data = data
        return before
    before.remove()
    return None
