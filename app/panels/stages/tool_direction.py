"""Direction in which a URDF arm's tool points, exactly or within an angle and for a time.

Its boxes, and the field ``arm.axis`` as they show and set it.
"""

from __future__ import annotations

import math
from typing import Any

import viser

from abi.obstacles.pose import Vec3
from abi.scene.held_axis import HeldAxis

DIRECTIONS: dict[str, Vec3 | None] = {
    "any": None,
    "down": (0.0, 0.0, -1.0),
    "up": (0.0, 0.0, 1.0),
    "along x": (1.0, 0.0, 0.0),
    "along −x": (-1.0, 0.0, 0.0),
    "along y": (0.0, 1.0, 0.0),
    "along −y": (0.0, -1.0, 0.0),
}
"""Directions by their labels."""
Percents = tuple[float, float]
"""Begin and end of the part of a motion for which a direction is held, [% of the time]."""


def add_direction(
    gui: viser.GuiApi,
) -> tuple[
    viser.GuiDropdownHandle[str],
    viser.GuiNumberHandle[float],
    viser.GuiVector2Handle,
]:
    """Add the boxes for a direction, how far it may be off [°], and for which part it is held."""
    direction = gui.add_dropdown(
        "gripper points",
        tuple(DIRECTIONS),
        hint="Direction in which the tip's z axis is held.",
        visible=False,
    )
    within = gui.add_number(
        "off by up to [°]",
        0.0,
        min=0.0,
        max=90.0,
        step=1.0,
        hint="At 0 it points so exactly, all the time, and the mesh is searched; else the "
        "motion is sought in the space of the joints.",
        visible=False,
    )
    part = gui.add_vector2(
        "from, to [% of the time]",
        (0.0, 100.0),
        min=(0.0, 0.0),
        max=(100.0, 100.0),
        step=5.0,
        hint="Before and after that the gripper may point anywhere.",
        visible=False,
    )
    return direction, within, part


def shown_axis(axis: Vec3 | HeldAxis | None) -> tuple[Vec3 | None, float, Percents]:
    """The direction of a scene as its boxes show it: itself, angle [°] and part, both rounded."""
    if not isinstance(axis, HeldAxis):
        return axis, 0.0, (0.0, 100.0)
    part = round(100 * axis.begin, 2), round(100 * axis.end, 2)
    return axis.direction, round(math.degrees(axis.tolerance), 2), part


def typed_axis(direction: Vec3 | None, within: float, part: Percents) -> Any:
    """The field ``arm.axis`` of what the boxes show; ``within`` in [°]."""
    if direction is None or within == 0:
        return direction
    begin, end = (share / 100 for share in part)
    tolerance = math.radians(within)
    return {"direction": direction, "tolerance": tolerance, "from": begin, "to": end}
