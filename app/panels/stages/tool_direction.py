"""Direction in which a URDF arm's tool points: exactly, or within an angle and for a time."""

from __future__ import annotations

import math
from typing import Any

import viser

from abi.obstacles.pose import Vec3
from abi.scene.held_axis import HeldAxis, plain_axis
from app.panels.widgets import Wake

_DIRECTIONS: dict[str, Vec3 | None] = {
    "any": None,
    "down": (0.0, 0.0, -1.0),
    "up": (0.0, 0.0, 1.0),
    "along x": (1.0, 0.0, 0.0),
    "along −x": (-1.0, 0.0, 0.0),
    "along y": (0.0, 1.0, 0.0),
    "along −y": (0.0, -1.0, 0.0),
}
_OTHER = "as in the scene"


class ToolDirectionPanel:
    """Widgets for the direction, how far it may be off, and for which part of the motion it is."""

    def __init__(self, gui: viser.GuiApi, wake: Wake) -> None:
        self.direction = gui.add_dropdown(
            "gripper points",
            tuple(_DIRECTIONS),
            hint="Direction in which the tip's z axis is held.",
            visible=False,
        )
        self.within = gui.add_number(
            "off by up to [°]",
            0.0,
            min=0.0,
            max=90.0,
            step=1.0,
            hint="At 0 it points so exactly, all the time, and the mesh is searched; else the "
            "motion is sought in the space of the joints.",
            visible=False,
        )
        self.part = gui.add_vector2(
            "from, to [% of the time]",
            (0.0, 100.0),
            min=(0.0, 0.0),
            max=(100.0, 100.0),
            step=5.0,
            hint="Before and after that the gripper may point anywhere.",
            visible=False,
        )
        for handle in (self.direction, self.within, self.part):
            handle.on_update(wake)
        self._kept: Vec3 | HeldAxis | None = None
        self._shown = self._values()
        self._is_of_urdf = False

    def read(self) -> Any:
        """The field ``arm.axis`` as typed: the scene's own while nothing has changed."""
        self._show_what_counts()
        if self._values() == self._shown:
            return plain_axis(self._kept)
        kept = self._kept.direction if isinstance(self._kept, HeldAxis) else self._kept
        direction = _DIRECTIONS.get(self.direction.value, kept)
        if direction is None or self.within.value == 0:
            return direction
        begin, end = (share / 100 for share in self.part.value)
        tolerance = math.radians(self.within.value)
        return {"direction": direction, "tolerance": tolerance, "from": begin, "to": end}

    def write(self, axis: Vec3 | HeldAxis | None) -> None:
        """Show the direction of a scene."""
        held = axis if isinstance(axis, HeldAxis) else None
        direction = axis if held is None else held.direction
        label = next((one for one, other in _DIRECTIONS.items() if other == direction), _OTHER)
        if label == _OTHER and _OTHER not in self.direction.options:
            self.direction.options = (*_DIRECTIONS, _OTHER)
        self.direction.value = label
        self.within.value = 0.0 if held is None else round(math.degrees(held.tolerance), 2)
        shares = (0.0, 1.0) if held is None else (held.begin, held.end)
        self.part.value = (round(100 * shares[0], 2), round(100 * shares[1], 2))
        self._kept, self._shown = axis, self._values()
        self._show_what_counts()

    def show(self, shown: bool) -> None:
        """Show or hide it: only a URDF arm has it."""
        self._is_of_urdf = shown
        self._show_what_counts()

    def _show_what_counts(self) -> None:
        """Hide the boxes that mean nothing without a direction, or without an angle."""
        points = self._is_of_urdf and self.direction.value != "any"
        self.direction.visible = self._is_of_urdf
        self.within.visible = points
        self.part.visible = points and self.within.value != 0

    def _values(self) -> tuple[object, ...]:
        """What the widgets show."""
        return self.direction.value, self.within.value, tuple(self.part.value)
