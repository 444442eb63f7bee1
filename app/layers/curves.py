"""B-spline with its control points, and quadratic, red where they come too near an obstacle.

Beside them, to compare, the curve of the plan before.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from abi.planner.plan import Plan
from app.drawing.lines import (
    NO_SEGMENTS,
    FadingLines,
    Segments,
    add_line,
    dashes,
    parameters,
    segments,
)
from app.layers.points import add_points, set_points
from app.shared.computed_once import once_a_plan
from app.state.frame import Frame, Layer, Switch
from app.ui import style
from app.ui.layout import Layout

SAMPLES = 160


@once_a_plan
def _line(plan: Plan, name: str) -> Segments:
    """The curve of that name as segments."""
    fit = plan.curves[name]
    assert fit is not None
    return segments(fit.curve(parameters(fit.curve.interval, SAMPLES)))


class CurvesLayer(Layer):
    """Curves of stages 4 and 5; the one the arm follows is the wider.

    The one that it followed in the last plan at rest is a ghost, dashed and grey.
    """

    switches: ClassVar[tuple[Switch, ...]] = (
        Switch("bspline", "B-spline", style.BSPLINE),
        Switch(
            "control",
            "control points",
            style.BSPLINE,
            hint="Of the B-spline, which bends towards them.",
        ),
        Switch("quadratic", "quadratic", style.QUADRATIC),
        Switch(
            "ghost",
            "last plan's curve",
            style.FADED,
            on=False,
            hint="The curve before the last change, to compare.",
        ),
    )

    def __init__(self, layout: Layout) -> None:
        scene = layout.client.scene
        self._all = FadingLines(scene)
        self._lines = {
            name: self._all.add(f"/curve/{name}", colour, 5.0)
            for name, (_, colour) in style.CURVES.items()
        }
        self._polygon = self._all.add("/curve/control_polygon", style.BSPLINE, 1.0)
        self._control = add_points(scene, "/curve/control_points")
        self._violations = self._all.add("/curve/entering", style.VIOLATION, 9.0)
        self._ghost = add_line(scene, "/ghost", style.FADED, 3.0)
        self._drawn: dict[str, object] = {}
        self._before: Plan | None = None

    def draw(self, frame: Frame) -> None:
        """Draw the plan's curves, and that of the plan before; none where there are none."""
        self._draw_curves(frame.plan)
        self._ghost.visible = "ghost" in frame.shown
        if frame.before is not self._before:
            self._before = frame.before
            self._ghost.points = _dashed(frame.before)
        self._all.fade(not frame.current)
        self._lines["bspline"].visible = "bspline" in frame.shown
        self._lines["quadratic"].visible = self._violations.visible = "quadratic" in frame.shown
        self._polygon.visible = "control" in frame.shown
        self._control.visible = "control" in frame.shown

    def _draw_curves(self, plan: Plan) -> None:
        for name, fit in plan.curves.items():
            line, curve = self._lines[name], None if fit is None else fit.curve
            line.thickness = 7.0 if name == plan.followed else 4.0
            if self._drawn.get(name, self) is curve:
                continue
            self._drawn[name] = curve
            line.points = NO_SEGMENTS if curve is None else _line(plan, name)
            if name == "bspline":
                self._draw_control(plan)
            else:
                self._draw_violations(plan)

    def _draw_violations(self, plan: Plan) -> None:
        """Draw the stretches of the quadratic that come nearer than the clearance."""
        stretches = [NO_SEGMENTS]
        if plan.quadratic is not None:
            for first, last in plan.quadratic.clearance.violations:
                stretches.append(segments(plan.quadratic.curve(np.linspace(first, last, 24))))
        self._violations.points = np.concatenate(stretches)

    def _draw_control(self, plan: Plan) -> None:
        points = np.zeros((0, 3)) if plan.bspline is None else plan.bspline.curve.control_points
        self._polygon.points = segments(points)
        size = 0.025 * max(plan.scene.workspace.size)
        set_points(self._control, points, style.BSPLINE, size)


def _dashed(plan: Plan | None) -> Segments:
    """The curve that a plan's arm follows, as dashes; nothing where there is none."""
    fit = None if plan is None else plan.followed_curve
    if plan is None or fit is None:
        return NO_SEGMENTS
    points = fit.curve(parameters(fit.curve.interval, SAMPLES))
    return dashes(points, 0.02 * max(plan.scene.workspace.size))
