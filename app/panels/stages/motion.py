"""Inputs of stage 5 and the motion: fit of the quadratic, curve to follow, speed profile."""

from __future__ import annotations

from typing import Any

import viser

from abi.arm_planning.motion_law import LAWS
from abi.scene.scene import Scene
from app.panels.length_step import length_step
from app.panels.stages.fields import Fields
from app.panels.widgets import Wake

FITS = {
    "paper's fit (may hit)": "least_squares",
    "closest that does not hit": "clear",
    "several joined curves, none hitting": "pieces",
}
FOLLOWED = {
    "quadratic if it keeps clear": "auto",
    "quadratic": "quadratic",
    "B-spline": "bspline",
}
_LAWS = {one.label: name for name, one in LAWS.items()}
_JERK_STEPS = 10
"""Steps of a length that are one of the jerk, which is a larger number."""


class MotionPanel:
    """The ``quadratic`` and ``motion`` sections of a scene."""

    def __init__(self, gui: viser.GuiApi, scene: Scene, wake: Wake) -> None:
        self.fit = gui.add_dropdown(
            "curve",
            tuple(FITS),
            hint="The paper's least-squares arc may enter an obstacle. The closest arc that does "
            "not, or several joined smoothly, stay clear.",
        )
        self.curve = gui.add_dropdown(
            "arm follows",
            tuple(FOLLOWED),
            hint="The curve that the arm executes: the B-spline where the quadratic comes too "
            "close.",
        )
        self.law = gui.add_dropdown(
            "motion",
            tuple(_LAWS),
            hint="The paper's three phases heed only the tool tip. The others also keep the joints "
            "within their speeds and accelerations.",
        )
        self.speed = gui.add_number(
            "speed [{unit}/s]", 1.0, step=0.1, hint="Of the tool tip, once it has sped up. Above 0."
        )
        self.rates = gui.add_vector2(
            "speed up, brake [{unit}/s²]",
            (1.0, 1.0),
            step=0.1,
            hint="Acceleration from rest, and deceleration to rest. Both above 0.",
        )
        self.joint_acceleration = gui.add_number(
            "joints [rad/s²]", 1.0, step=0.1, hint="Largest acceleration of any joint. Above 0."
        )
        self.jerk = gui.add_number(
            "jerk [{unit}/s³]", 1.0, step=1.0, hint="Largest jerk of the tool tip. Above 0."
        )
        self._shown = ""
        widgets = {
            "quadratic.mode": self.fit,
            "motion.curve": self.curve,
            "motion.law": self.law,
            "motion.speed": self.speed,
            "motion.acceleration motion.deceleration": self.rates,
            "motion.joint_acceleration": self.joint_acceleration,
            "motion.jerk": self.jerk,
        }
        options = {"quadratic.mode": FITS, "motion.curve": FOLLOWED, "motion.law": _LAWS}
        self._fields = Fields(widgets, wake, options)
        self.write(scene)

    def read(self) -> dict[str, Any]:
        """Read the sections as typed."""
        self._show_limits()
        return self._fields.read()

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        step = length_step(scene)
        self.speed.step = self.rates.step = step
        self.jerk.step = _JERK_STEPS * step
        self._fields.write(scene)
        self._show_limits()

    def _show_limits(self) -> None:
        """Show the boxes that the chosen law asks for."""
        if (law := self.law.value) == self._shown:
            return
        self._shown = law
        uses = LAWS[_LAWS[law]].uses if law in _LAWS else frozenset()
        self.speed.visible, self.rates.visible = "speed" in uses, "acceleration" in uses
        self.joint_acceleration.visible = "joint_acceleration" in uses
        self.jerk.visible = "jerk" in uses
