"""Joints with which a URDF arm begins or ends, as text."""

from __future__ import annotations

import math
from typing import Any, Literal

import viser

from abi.obstacles.pose import METRES
from abi.robot.urdf.held_joints import planned_joints
from abi.scene.arm_end import ArmEnd
from abi.scene.scene import Scene

End = Literal["start", "goal"]

_POSE = "a pose of the tool tip"


def add_end(gui: viser.GuiApi, end: End) -> viser.GuiTextHandle:
    """Add a box for the joints at one end, or a named state; empty for any."""
    return gui.add_text(
        f"joints at {end} [°]",
        "",
        hint="One number for each joint, from the base on, or a state that the SRDF names. "
        f"Empty for any that put the tool tip at the {end}, as once that is dragged.",
    )


def end_text(scene: Scene, end: End) -> str:
    """Joints at one end of a scene, in degrees and lengths, or the name of their state."""
    arm, metres = scene.arm, METRES[scene.unit]
    kept: ArmEnd | None = getattr(arm, end)
    if kept is None:
        return ""
    if kept.state is not None:
        return kept.state
    at = arm.joints_at(end, metres)
    if at is None:
        return _POSE
    slides = _slides(scene)
    shown = [at[name] / metres if slides[name] else math.degrees(at[name]) for name in at]
    return ", ".join(f"{round(number, 3):g}" for number in shown)


def typed_end(text: str, scene: Scene) -> Any:
    """Field of a scene for what was typed: numbers of the joints of its arm, or a state."""
    if not text:
        return None
    try:
        numbers = [float(word) for word in text.replace(",", " ").split()]
    except ValueError:
        return {"state": text}
    known = _slides(scene)
    slides = [known[name] for name in planned_joints(scene.arm.robot, scene.arm.tool)]
    pairs = zip(numbers, [*slides, *[False] * len(numbers)], strict=False)
    return {"joints": [one if slide else math.radians(one) for one, slide in pairs]}


def _slides(scene: Scene) -> dict[str, bool]:
    """Whether each joint of a scene's robot slides, by its name."""
    return {joint.name: joint.kind == "prismatic" for joint in scene.arm.robot.joints}
