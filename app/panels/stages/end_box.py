"""Joints with which a URDF arm begins or ends."""

from __future__ import annotations

import math
from typing import Any, Literal

import viser

from abi.obstacles.pose import METRES
from abi.robot.urdf.held_joints import planned_joints
from abi.scene.arm_end import ArmEnd
from abi.scene.scene import Scene
from app.panels.widgets import Wake

_POSE = "a pose of the tool tip"


class EndBox:
    """Text of the joints at one end, in degrees and lengths, or of a named state; empty for any."""

    def __init__(self, gui: viser.GuiApi, end: Literal["start", "goal"], wake: Wake) -> None:
        self._end = end
        self.handle = gui.add_text(
            f"joints at {end} [°]",
            "",
            hint="One number for each joint, from the base on, or a state that the SRDF names. "
            f"Empty for any that put the tool tip at the {end}, as once that is dragged.",
        )
        self.handle.on_update(wake)
        self._shown = ""
        self._kept: ArmEnd | None = None
        self._slides: tuple[bool, ...] = ()

    def read(self) -> Any:
        """The end as typed: the scene's own while its text is unchanged."""
        text = self.handle.value.strip()
        if text == self._shown:
            return self._kept
        if not text:
            return None
        try:
            numbers = [float(word) for word in text.replace(",", " ").split()]
        except ValueError:
            return {"state": text}
        slides = [*self._slides, *[False] * len(numbers)]
        pairs = zip(numbers, slides, strict=False)
        return {"joints": [one if slide else math.radians(one) for one, slide in pairs]}

    def follow(self, scene: Scene) -> None:
        """Show the end of a scene if it is another one than before, and no newer one is typed."""
        end: ArmEnd | None = getattr(scene.arm, self._end)
        if end == self._kept:
            return
        untouched = self.handle.value.strip() == self._shown
        if untouched or self.read() == (None if end is None else end.model_dump()):
            self.write(scene)

    def write(self, scene: Scene) -> None:
        """Show the end of a scene."""
        arm = scene.arm
        kept: ArmEnd | None = getattr(arm, self._end)
        self._kept = kept
        kinds = {joint.name: joint.kind == "prismatic" for joint in arm.robot.joints}
        self._slides = tuple(kinds[name] for name in planned_joints(arm.robot, arm.tool))
        metres = METRES[scene.unit]
        text = ""
        if kept is not None and kept.state is not None:
            text = kept.state
        elif kept is not None and (at := arm.joints_at(self._end, metres)) is not None:
            shown = [at[name] / metres if kinds[name] else math.degrees(at[name]) for name in at]
            text = ", ".join(f"{round(number, 3):g}" for number in shown)
        elif kept is not None:
            text = _POSE
        self._shown = self.handle.value = text
