"""Inputs of stage 5 and the motion: fit of the quadratic, curve to follow, speed profile."""

from __future__ import annotations

from typing import Any

import viser

from abi.scene.scene import Scene
from app.panels.widgets import DIGITS, Choice, Wake

FITS = {
    "least squares": "least_squares",
    "nearest clear one": "clear",
    "fewest clear pieces": "pieces",
}
FOLLOWED = {
    "quadratic if clear, else B-spline": "auto",
    "quadratic": "quadratic",
    "B-spline": "bspline",
}


class MotionPanel:
    """The ``quadratic`` and ``motion`` sections of a scene."""

    def __init__(self, gui: viser.GuiApi, scene: Scene, wake: Wake) -> None:
        self.fit = Choice(
            gui,
            "fit",
            FITS,
            "Least squares is the paper's and may enter an obstacle; the others keep clear.",
            wake,
        )
        self.curve = Choice(gui, "arm follows", FOLLOWED, "The curve that the arm executes.", wake)
        self.speed = gui.add_number("speed V", 1.0, step=0.1, hint="Cruise speed.")
        self.rates = gui.add_vector2(
            "a1, a3", (1.0, 1.0), step=0.1, hint="Speeding up from rest, and braking to rest."
        )
        self.speed.precision = self.rates.precision = DIGITS
        self.speed.on_update(wake)
        self.rates.on_update(wake)
        self.write(scene)

    def read(self) -> dict[str, Any]:
        """Read the sections as typed."""
        return {
            "quadratic": {"mode": self.fit.read()},
            "motion": {
                "curve": self.curve.read(),
                "speed": self.speed.value,
                "acceleration": self.rates.value[0],
                "deceleration": self.rates.value[1],
            },
        }

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        self.speed.label = f"V [{scene.unit}/s]"
        self.rates.label = f"a1, a3 [{scene.unit}/s²]"
        self.fit.write(scene.quadratic.mode)
        self.curve.write(scene.motion.curve)
        self.speed.value = scene.motion.speed
        self.rates.value = (scene.motion.acceleration, scene.motion.deceleration)
