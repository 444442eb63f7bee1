"""Inputs of stage 4: degree and clearance."""

from __future__ import annotations

import viser

from abi.scene.scene import Scene
from app.panels.stages.fields import Fields, Widgets
from app.panels.widgets import clamp, range_hint

_CLEARANCE = "Distance that path and curve keep from every obstacle."


def spline_inputs(gui: viser.GuiApi, scene: Scene) -> Widgets:
    """Add widgets of the ``spline`` section of a scene."""
    high = _max_clearance(scene)
    return {
        "spline.degree": gui.add_slider(
            "degree",
            2,
            5,
            1,
            scene.spline.degree,
            hint="Of the curve's polynomials; the paper uses 3 and 4. From 2 to 5.",
        ),
        "spline.clearance": gui.add_slider(
            "clearance [{unit}]", 0.0, high, high / 100, clamp(scene.spline.clearance, 0.0, high)
        ),
    }


def fit_clearance(fields: Fields, scene: Scene) -> None:
    """Give the clearance's slider the range of a scene."""
    high, slider = _max_clearance(scene), fields["spline.clearance"]
    slider.max, slider.step = high, high / 100
    slider.hint = range_hint(_CLEARANCE, 0.0, high, scene.unit)


def _max_clearance(scene: Scene) -> float:
    return float(f"{max(scene.workspace.size) / 6:.2g}")
