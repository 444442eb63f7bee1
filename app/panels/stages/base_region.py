"""The region in which a base is searched: a box, as numbers and as a gizmo in the scene."""

from __future__ import annotations

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.errors import SceneError
from abi.explain.find_base import default_region
from abi.obstacles.pose import Vec3
from abi.scene.scene import Scene
from app.drawing.box import box_edges
from app.drawing.lines import NO_SEGMENTS, Segments, add_line
from app.panels.length_step import length_step
from app.panels.widgets import VectorBox, Wake
from app.ui import style

_HANDLE = 0.12
"""Length of the gizmo's arrows, as a part of the region's longest side."""


class BaseRegion:
    """Middle and sides of a box, which belong to the tab and to no scene."""

    def __init__(self, client: viser.ClientHandle, scene: Scene, wake: Wake) -> None:
        gui = client.gui
        self.shown = gui.add_checkbox(
            "show the region", False, hint="Move it by its arrows; its size is set below."
        )
        self.shown.on_update(wake)
        self.middle = VectorBox(gui, "region centre", 0.1, "Centre of the box.", wake)
        self.sides = VectorBox(
            gui, "region size", 0.1, "With 0 the base stays as it is along that axis.", wake
        )
        self.gizmo = client.scene.add_transform_controls(
            "/base_region",
            disable_rotations=True,
            disable_sliders=True,
            line_width=3.0,
            depth_test=False,
            opacity=0.9,
            visible=False,
        )
        self.gizmo.on_update(wake)
        self._box = add_line(client.scene, "/base_region/box", style.MARK, 2.5)
        self._of: tuple[object, ...] = ()
        self._size: FloatArray = np.zeros(3)
        self._boxed: FloatArray = np.full(3, np.nan)
        self.write(scene)

    @property
    def corners(self) -> tuple[Vec3, Vec3]:
        """Low and high corner, [unit], world."""
        middle = np.asarray(self.gizmo.position, dtype=float)
        low, high = (middle - self._size / 2).tolist(), (middle + self._size / 2).tolist()
        return (low[0], low[1], low[2]), (high[0], high[1], high[2])

    def read(self) -> None:
        """Take what was typed or dragged.

        Raises:
            SceneError: a side is no length.
        """
        if (middle := self.middle.typed("region.middle")) is not None:
            self.gizmo.position = np.array(middle)
        self.middle.show(self.gizmo.position)
        sides = self.sides.typed("region.sides")
        if sides is not None and min(sides) < 0:
            self.sides.write(self._size)
            raise SceneError("region.sides", list(sides), "lengths from 0 on")
        if sides is not None:
            self._size = np.array(sides, dtype=float)

    def write(self, scene: Scene) -> None:
        """Begin with the usual region where the workspace is another."""
        of = scene.workspace, scene.unit, scene.arm.model
        if of == self._of:
            return
        self._of = of
        low, high = (np.array(corner) for corner in default_region(scene))
        self.gizmo.position = (low + high) / 2
        self._size = high - low
        self.middle.write(self.gizmo.position)
        self.sides.write(self._size)
        self.middle.handle.step = self.sides.handle.step = length_step(scene)
        self.middle.handle.label = f"region centre [{scene.unit}]"
        self.sides.handle.label = f"region size [{scene.unit}]"

    def draw(self) -> None:
        """Draw the box where it is shown."""
        self.gizmo.visible = bool(self.shown.value)
        if not (self._boxed == self._size).all():
            self._boxed = self._size
            self.gizmo.scale = _HANDLE * float(self._size.max(initial=1e-3))
            self._box.points = _edges(self._size)


def _edges(size: FloatArray) -> Segments:
    """Edges (n, 2, 3) of a box around the origin; those of no length are left out."""
    lines = box_edges(-size / 2, size / 2)
    lines = lines[np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) > 0]
    return lines.astype(np.float32) if len(lines) else NO_SEGMENTS
