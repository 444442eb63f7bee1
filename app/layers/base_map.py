"""Heat map of bases: a tile at each place that was tried, coloured by the curve's length."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import viser
from numpy.typing import NDArray

from abi.explain.base_map import BaseMap
from app.state.frame import Frame, Layer, Switch
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


class BaseMapLayer(Layer):
    """Tiles level with the bases, grey without a plan, and a pin at the best."""

    switches: ClassVar[tuple[Switch, ...]] = (
        Switch(
            "bases",
            "bases tried (heat map)",
            style.HEAT[0],
            hint="After Find a base in stage 6: yellow where the curve is shortest, dark blue "
            "where it is longest, grey where there is no plan.",
        ),
    )

    def __init__(self, layout: Layout) -> None:
        self._scene = layout.client.scene
        self._root = self._scene.add_frame("/bases", show_axes=False)
        self._tiles: viser.BatchedMeshHandle | None = None
        self._pin: viser.IcosphereHandle | None = None
        self._drawn: tuple[object, ...] = ()

    def draw(self, frame: Frame) -> None:
        """Draw the map, if there is one."""
        self._root.visible = "bases" in frame.shown
        found = frame.bases
        if (found, frame.label_scale) == self._drawn:
            return
        self._drawn = found, frame.label_scale
        for handle in (self._tiles, self._pin):
            if handle is not None:
                handle.remove()
        self._tiles = self._pin = None
        if found is not None and found.cells:
            self._draw_tiles(found)
            self._draw_best(found, frame.label_scale)

    def _draw_tiles(self, found: BaseMap) -> None:
        layered = found.cells[0].cell[2] > 0
        sides = np.array([cell.cell for cell in found.cells])
        # a region that is thin in one direction still has tiles that are seen
        sides = np.where(sides > 0, sides, sides.max(initial=1e-3) / 4)
        scales = sides * ((_SMALL if layered else _GAP), (_SMALL if layered else _GAP), 1.0)
        turns = np.zeros((len(sides), 4), np.float32)
        turns[:, 0] = 1
        self._tiles = self._scene.add_batched_meshes_simple(
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

    def _draw_best(self, found: BaseMap, scale: float) -> None:
        best = found.best
        if best is None or best.length is None:
            return
        size = max(found.scene.workspace.size)
        place = np.array(best.base)
        self._pin = self._scene.add_icosphere(
            "/bases/best", radius=_PIN * size, color=style.MARK, position=place
        )
        # goes with the pin
        self._scene.add_label(
            "/bases/best/label",
            f"best base · {format_length(best.length)} {found.scene.unit}",
            anchor="bottom-center",
            position=(0.0, 0.0, 2 * _PIN * size),
            depth_test=False,
            font_screen_scale=scale,
        )


def _colours(found: BaseMap) -> NDArray[np.uint8]:
    """Colour (n, 3) of each cell: from the shortest length to the longest, grey without a plan."""
    least, most = found.lengths or (0.0, 0.0)
    lengths = np.array([np.nan if one.length is None else one.length for one in found.cells])
    shares = (lengths - least) / (most - least) if most > least else np.zeros(len(lengths))
    colours = scale_colours(style.HEAT, np.nan_to_num(shares))
    colours[np.isnan(lengths)] = style.FADED
    return colours
