"""Inputs of stage 4: degree and clearance."""

from __future__ import annotations

from typing import Any

import viser

from abi.scene.scene import Scene
from app.panels.widgets import DIGITS, Wake, clamp


class SplinePanel:
    """The ``spline`` section of a scene."""

    def __init__(self, gui: viser.GuiApi, scene: Scene, wake: Wake) -> None:
        self.degree = gui.add_slider(
            "degree",
            2,
            5,
            1,
            scene.spline.degree,
            hint="Of the curve's polynomials; the paper uses 3 and 4.",
        )
        high = _max_clearance(scene)
        self.clearance = gui.add_slider(
            f"clearance [{scene.unit}]",
            0.0,
            high,
            high / 100,
            clamp(scene.spline.clearance, 0.0, high),
            hint="Distance that path and curve keep from every obstacle.",
        )
        self.clearance.precision = DIGITS
        self.degree.on_update(wake)
        self.clearance.on_update(wake)
        self.write(scene)

    def read(self) -> dict[str, Any]:
        """Read the section as typed."""
        return {"spline": {"degree": self.degree.value, "clearance": self.clearance.value}}

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        high = _max_clearance(scene)
        self.clearance.label = f"clearance [{scene.unit}]"
        self.clearance.max, self.clearance.step = high, high / 100
        self.degree.value = scene.spline.degree
        self.clearance.value = scene.spline.clearance


def _max_clearance(scene: Scene) -> float:
    return float(f"{max(scene.workspace.size) / 6:.2g}")
