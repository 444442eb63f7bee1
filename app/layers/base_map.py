"""Heat map of bases: a tile at each place that was tried, coloured by the curve's length."""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray

from abi.explain.base_map import BaseMap
from abi.obstacles.pose import Vec3
from app.state.frame import Draw, Frame
from app.ui import style
from app.ui.colour_scale import scale_colours
from app.ui.layout import Layout
from app.ui.numbers import format_length

_VERTICES = np.array([[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.5, 0.5, 0], [-0.5, 0.5, 0]], np.float32)
_FACES = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
_GAP, _SMALL = 0.94, 0.5
"""Side of a tile as a part of its cell's: of one layer, and of several."""
_OPACITY = 0.8
_PIN = 0.012
"""Radius of the mark of the best, as a part of the workspace's size."""


def base_map_layer(layout: Layout) -> Draw:
    """Tiles level with the bases, grey without a plan, and a pin at the best."""
    scene = layout.client.scene
    root = scene.add_frame("/bases", show_axes=False)
    nodes: list[viser.BatchedMeshHandle | viser.IcosphereHandle] = []
    drawn: tuple[object, ...] = ()

    def draw(frame: Frame) -> None:
        nonlocal drawn
        root.visible = "bases" in frame.shown
        found = frame.bases
        if drawn == (found, frame.label_scale):
            return
        drawn = found, frame.label_scale
        while nodes:
            nodes.pop().remove()
        if found is not None and found.cells:
            nodes.append(_add_tiles(scene, found))
            if found.best is not None and found.best.length is not None:
                best = found.best.base, found.best.length
                nodes.append(_add_pin(scene, found, *best, frame.label_scale))

    return draw


def _add_tiles(scene: viser.SceneApi, found: BaseMap) -> viser.BatchedMeshHandle:
    layered = found.cells[0].cell[2] > 0
    sides = np.array([cell.cell for cell in found.cells])
    # a region that is thin in one direction still has tiles that are seen
    sides = np.where(sides > 0, sides, sides.max(initial=1e-3) / 4)
    scales = sides * ((_SMALL if layered else _GAP), (_SMALL if layered else _GAP), 1.0)
    turns = np.zeros((len(sides), 4), np.float32)
    turns[:, 0] = 1
    return scene.add_batched_meshes_simple(
        "/bases/tiles",
        _VERTICES,
        _FACES,
        turns,
        np.array([cell.base for cell in found.cells], np.float32),
        batched_scales=scales.astype(np.float32),
        batched_colors=_colours(found),
        lod="off",
        opacity=_OPACITY,
        side="double",
        cast_shadow=False,
        receive_shadow=False,
    )


def _add_pin(
    scene: viser.SceneApi, found: BaseMap, base: Vec3, length: float, scale: float
) -> viser.IcosphereHandle:
    """A pin at the best base, with the length of the curve from there."""
    size = max(found.scene.workspace.size)
    pin = scene.add_icosphere(
        "/bases/best", radius=_PIN * size, color=style.MARK, position=np.array(base)
    )
    # goes with the pin
    scene.add_label(
        "/bases/best/label",
        f"best base · {format_length(length)} {found.scene.unit}",
        anchor="bottom-center",
        position=(0.0, 0.0, 2 * _PIN * size),
        depth_test=False,
        font_screen_scale=scale,
    )
    return pin


def _colours(found: BaseMap) -> NDArray[np.uint8]:
    """Colour (n, 3) of each cell: from the shortest length to the longest, grey without a plan."""
    least, most = found.lengths or (0.0, 0.0)
    lengths = np.array([np.nan if one.length is None else one.length for one in found.cells])
    shares = (lengths - least) / (most - least) if most > least else np.zeros(len(lengths))
    colours = scale_colours(style.HEAT, np.nan_to_num(shares))
    colours[np.isnan(lengths)] = style.FADED
    return colours
