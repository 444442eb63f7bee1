"""Inputs of stage 4: degree and clearance."""

from __future__ import annotations

import viser

from abi.scene.scene import Scene
from app.panels.stages.fields import Fields
from app.panels.widgets import Wake, clamp, range_hint

_CLEARANCE = "Distance that path and curve keep from every obstacle."


class SplinePanel:
    """The ``spline`` section of a scene."""

    def __init__(self, gui: viser.GuiApi, scene: Scene, wake: Wake) -> None:
        self.degree = gui.add_slider(
            "degree",
            2,
            5,
            1,
            scene.spline.degree,
            hint="Of the curve's polynomials; the paper uses 3 and 4. From 2 to 5.",
        )
        high = _max_clearance(scene)
        self.clearance = gui.add_slider(
            "clearance [{unit}]",
            0.0,
            high,
            high / 100,
            clamp(scene.spline.clearance, 0.0, high),
        )
        widgets = {"spline.degree": self.degree, "spline.clearance": self.clearance}
        self._fields = Fields(widgets, wake)
        self.read = self._fields.read
        self.write(scene)

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        high = _max_clearance(scene)
        self.clearance.max, self.clearance.step = high, high / 100
        self.clearance.hint = range_hint(_CLEARANCE, 0.0, high, scene.unit)
        self._fields.write(scene)


def _max_clearance(scene: Scene) -> float:
    return float(f"{max(scene.workspace.size) / 6:.2g}")
