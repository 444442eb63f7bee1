"""Three short arrows beside a corner of the workspace: where x, y and z lead, and their unit."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from abi.arrays import FloatArray
from abi.scene.settings import Workspace
from app.drawing.lines import Segments, add_line
from app.state.frame import Frame, Layer, Switch
from app.ui import style
from app.ui.layout import Layout

_LENGTH = 0.2
"""Of an arrow, as a part of the workspace's longest side."""
_HEAD = (0.72, 0.1)
"""Where an arrow's head begins, and its half width, as parts of the arrow's length."""
_APART = 0.09
"""Distance to the workspace's corner, along x and y, as a part of its longest side."""
_LETTERS = 0.85
"""Scale of the labels beside that of all others."""


class AxesLayer(Layer):
    """Arrows in the plots' colours of the axes; neither they nor their labels take the mouse."""

    switches: ClassVar[tuple[Switch, ...]] = (Switch("axes", "axes x, y, z", None),)

    def __init__(self, layout: Layout) -> None:
        scene = layout.client.scene
        self._corner = scene.add_frame("/axes", show_axes=False)
        self._arrows = [
            add_line(scene, f"/axes/{name}", colour, 2.0)
            for name, colour in zip("xyz", style.AXES, strict=True)
        ]
        self._labels = [
            scene.add_label(f"/axes/{name}/label", name, anchor="center-center") for name in "xyz"
        ]
        self._drawn: tuple[Workspace, str] | None = None

    def draw(self, frame: Frame) -> None:
        """Draw the arrows for a workspace and a unit."""
        self._corner.visible = "axes" in frame.shown
        for label in self._labels:
            label.font_screen_scale = round(_LETTERS * frame.label_scale, 3)
        state = frame.plan.scene.workspace, frame.plan.scene.unit
        if state != self._drawn:
            self._drawn = state
            self._place(*state)

    def _place(self, workspace: Workspace, unit: str) -> None:
        longest = max(workspace.size)
        # nearest to the usual camera, where nothing else is
        corner = np.array([workspace.max[0], workspace.min[1], workspace.min[2]])
        self._corner.position = corner + _APART * longest * np.array([1.0, -1.0, 0.0])
        for axis, (arrow, label) in enumerate(zip(self._arrows, self._labels, strict=True)):
            tip = _LENGTH * longest * np.eye(3)[axis]
            arrow.points = _arrow(tip, np.eye(3)[axis - 1 if axis else 1])
            # one unit for all: three would crowd so small a place
            label.text = f"z [{unit}]" if axis == 2 else "xyz"[axis]
            label.position = 1.2 * tip


def _arrow(tip: FloatArray, side: FloatArray) -> Segments:
    """Segments (3, 2, 3) of an arrow from the origin to a tip (3,), its head along ``side``."""
    begin, width = _HEAD
    across = width * np.linalg.norm(tip) * side
    barbs = [begin * tip + across, begin * tip - across]
    return np.array([[np.zeros(3), tip], *([barb, tip] for barb in barbs)], np.float32)
