"""Ghost: the curve of the plan before a drag, for comparison with the present one."""

from __future__ import annotations

from typing import ClassVar

from abi.planner.plan import Plan
from app.drawing.lines import NO_SEGMENTS, add_line, dashes, parameters
from app.layers.curves import SAMPLES
from app.state.frame import Frame, Layer, Switch
from app.ui import style
from app.ui.layout import Layout


class GhostLayer(Layer):
    """The last plan at rest, dashed and grey, once there is another."""

    switches: ClassVar[tuple[Switch, ...]] = (
        Switch(
            "ghost",
            "last plan's curve",
            style.FADED,
            on=False,
            hint="The curve before the last change, to compare.",
        ),
    )

    def __init__(self, layout: Layout) -> None:
        self._line = add_line(layout.client.scene, "/ghost", style.FADED, 3.0)
        self._ghost: Plan | None = None

    def draw(self, frame: Frame) -> None:
        """Draw the plan that was at rest before this one."""
        self._line.visible = "ghost" in frame.shown
        if frame.before is not self._ghost:
            self._show(frame.before)

    def _show(self, plan: Plan | None) -> None:
        """Draw the curve that a plan's arm follows."""
        self._ghost = plan
        fit = None if plan is None else plan.followed_curve
        if plan is None or fit is None:
            self._line.points = NO_SEGMENTS
            return
        points = fit.curve(parameters(fit.curve.interval, SAMPLES))
        self._line.points = dashes(points, 0.02 * max(plan.scene.workspace.size))
