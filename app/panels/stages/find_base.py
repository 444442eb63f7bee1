"""Search for the arm's best base, in steps of one plan each: region, start, stop, and the best.

The region is a box, as numbers and as a gizmo in the scene.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.errors import SceneError
from abi.explain.base_map import BaseMap
from abi.explain.find_base import base_maps, default_region
from abi.obstacles.pose import Vec3
from abi.scene.scene import Scene
from app.drawing.box import box_edges
from app.drawing.lines import NO_SEGMENTS, Segments, add_line
from app.panels.length_step import length_step
from app.panels.stages.base_result import base_result
from app.panels.widgets import VectorBox, Wake, pressed
from app.state.frame import Frame
from app.ui import style
from app.ui.numbers import unbroken

_HANDLE = 0.12
"""Length of the gizmo's arrows, as a part of the region's longest side."""
_PORTION = 0.005
"""Seconds between two plans, in which other tabs and the hand have their turn."""
_INTRO = "Tries the base at many places in a region and shows how long the curve is from each."


class FindBasePanel:
    """Folder of stage 6: region, progress, and what was found.

    The region belongs to the tab and to no scene.

    Attributes:
        whose: of which legs the search is, as a part of a sentence; empty where there is one.
    """

    def __init__(self, client: viser.ClientHandle, scene: Scene, wake: Wake) -> None:
        gui = client.gui
        with gui.add_folder("Find a base", expand_by_default=False):
            gui.add_html(style.paragraph(_INTRO))
            self._add_region(client, wake)
            self.find = gui.add_button("Find a base", hint="Searches the region while you go on.")
            self.progress = gui.add_progress_bar(0.0, visible=False)
            self.put = gui.add_button(
                "Put the arm here", hint="Moves the base to the best place found.", visible=False
            )
            self._text = gui.add_html("", visible=False)
        self.find.on_click(wake)
        self.put.on_click(wake)
        self._maps: Iterator[BaseMap] | None = None
        self._found: BaseMap | None = None
        self._asked = False
        self.whose = ""
        self._showed = False  # whether the region is shown only for the search
        self._drawn: tuple[object, ...] = ()
        self._region_of: tuple[object, ...] = ()
        self._size: FloatArray = np.zeros(3)
        self._boxed: FloatArray = np.full(3, np.nan)
        self.write(scene)

    def _add_region(self, client: viser.ClientHandle, wake: Wake) -> None:
        """Add the region's numbers, its gizmo and its box."""
        gui = client.gui
        self.show_region = gui.add_checkbox(
            "show the region", False, hint="Move it by its arrows; its size is set below."
        )
        self.show_region.on_update(wake)
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

    @property
    def corners(self) -> tuple[Vec3, Vec3]:
        """Low and high corner of the region, [unit], world."""
        middle = np.asarray(self.gizmo.position, dtype=float)
        low, high = (middle - self._size / 2).tolist(), (middle + self._size / 2).tolist()
        return (low[0], low[1], low[2]), (high[0], high[1], high[2])

    @property
    def running(self) -> bool:
        """Whether there is another place to try."""
        return self._asked or self._maps is not None

    def timeout(self) -> float | None:
        """Time until the next portion, [s]; None while none is due."""
        return _PORTION if self.running else None

    def read(self) -> dict[str, Any]:
        """Take the region and the buttons; no section of the scene.

        Raises:
            SceneError: a side of the region is no length.
        """
        if pressed(self.find):
            self._asked = not self.running
            self._maps = None
        if (middle := self.middle.typed("region.middle")) is not None:
            self.gizmo.position = np.array(middle)
        self.middle.show(self.gizmo.position)
        sides = self.sides.typed("region.sides")
        if sides is not None and min(sides) < 0:
            self.sides.write(self._size)
            raise SceneError("region.sides", list(sides), "lengths from 0 on")
        if sides is not None:
            self._size = np.array(sides, dtype=float)
        return {}

    def write(self, scene: Scene) -> None:
        """Begin with the usual region where the workspace is another."""
        of = scene.workspace, scene.unit, scene.arm.model
        if of == self._region_of:
            return
        self._region_of = of
        low, high = (np.array(corner) for corner in default_region(scene))
        self.gizmo.position = (low + high) / 2
        self._size = high - low
        self.middle.write(self.gizmo.position)
        self.sides.write(self._size)
        self.middle.handle.step = self.sides.handle.step = length_step(scene)
        self.middle.handle.label = f"region centre [{scene.unit}]"
        self.sides.handle.label = f"region size [{scene.unit}]"

    def accepted_change(self) -> dict[str, Any] | None:
        """The base whose button was pressed since the last call, as a change of the scene."""
        best = None if self._found is None else self._found.best
        if not pressed(self.put) or best is None:
            return None
        return {"arm": {"base": list(best.base)}}

    def step(self, scene: Scene, leg: int | None = None) -> None:
        """Plan with the base at one more place.

        Args:
            scene: the scene.
            leg: number of the leg, from 0, where it is one; the first is the scene with all legs.
        """
        if self._asked:
            self._asked = False
            count = len(scene.tasks)
            self.whose = f" for leg {leg + 1} alone" if leg else ""
            self.whose = f" for all {count} legs" if count > 1 else self.whose
            self._showed |= not self.show_region.value
            self.show_region.value = True
            self._maps = base_maps(scene, *self.corners)
        if self._maps is not None:
            self._found = next(self._maps, self._found)
            if self._found is None or self._found.is_done:
                self._maps = None

    def found(self, scene: Scene) -> BaseMap | None:
        """Findings for ``scene``, wherever its base; forgotten once all else is another."""
        found = self._found
        if found is None or scene is found.scene or _with_base(scene, found) == found.scene:
            return found
        self._found = self._maps = None
        if self._showed:
            self._showed = self.show_region.value = False
        return None

    def draw(self, frame: Frame) -> None:
        """Show region, progress and result."""
        self._draw_region()
        state = frame.bases, self.running
        if state == self._drawn:
            return
        self._drawn = state
        found = frame.bases
        self.find.label = "Stop" if self.running else "Find a base"
        self.progress.visible = self.running
        self._text.visible = found is not None
        best = None if found is None else found.best
        self.put.visible = best is not None
        if found is not None:
            done, of = found.planned
            self.progress.value = min(100.0, 100 * done / of)
            self._text.content = unbroken(style.paragraph(base_result(found, self.whose)))

    def _draw_region(self) -> None:
        """Draw the region's box where it is shown."""
        self.gizmo.visible = bool(self.show_region.value)
        if not (self._boxed == self._size).all():
            self._boxed = self._size
            self.gizmo.scale = _HANDLE * float(self._size.max(initial=1e-3))
            self._box.points = _edges(self._size)


def _edges(size: FloatArray) -> Segments:
    """Edges (n, 2, 3) of a box around the origin; those of no length are left out."""
    lines = box_edges(-size / 2, size / 2)
    lines = lines[np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) > 0]
    return lines.astype(np.float32) if len(lines) else NO_SEGMENTS


def _with_base(scene: Scene, found: BaseMap) -> Scene:
    """Scene whose arm stands where it stood when the search for a base began."""
    arm = scene.arm.model_copy(update={"base": found.scene.arm.base})
    return scene.model_copy(update={"arm": arm})
