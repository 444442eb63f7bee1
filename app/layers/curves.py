"""B-spline with its control points, and the quadratic; red where a curve enters an obstacle."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.curves.curve import Curve
from abi.planner.plan import Plan
from app import style
from app.frame import Frame, Switch
from app.layers.lines import segments
from app.layout import Layout

SAMPLES = 160


class CurvesLayer:
    """Draws the curves of stages 4 and 5; the one the arm executes is the wider."""

    switches: ClassVar[tuple[Switch, ...]] = (
        Switch("bspline", "B-spline", style.BSPLINE),
        Switch("control", "control points", style.BSPLINE),
        Switch("quadratic", "quadratic", style.QUADRATIC),
    )

    def __init__(self, layout: Layout) -> None:
        self._scene = layout.client.scene
        self._lines = {
            name: self._scene.add_line_segments(
                f"/curve/{name}",
                np.zeros((1, 2, 3)),
                colour,
                thickness=5.0,
                thickness_units="screen",
            )
            for name, (_, colour) in style.CURVES.items()
        }
        self._polygon = self._scene.add_line_segments(
            "/curve/control_polygon",
            np.zeros((1, 2, 3)),
            style.BSPLINE,
            thickness=1.0,
            thickness_units="screen",
        )
        self._control: viser.PointCloudHandle | None = None
        self._entering = self._scene.add_line_segments(
            "/curve/entering",
            np.zeros((1, 2, 3)),
            style.ENTERS,
            thickness=9.0,
            thickness_units="screen",
        )
        self._drawn: dict[str, object] = {}
        self._faded = False

    def draw(self, frame: Frame) -> None:
        """Draw the plan's curves; none where there are none."""
        self._draw_curves(frame.plan)
        if frame.faded != self._faded:
            self._fade(frame.faded)
        self._lines["bspline"].visible = "bspline" in frame.shown
        self._lines["quadratic"].visible = self._entering.visible = "quadratic" in frame.shown
        self._polygon.visible = "control" in frame.shown
        if self._control is not None:
            self._control.visible = "control" in frame.shown

    def _draw_curves(self, plan: Plan) -> None:
        curves: dict[str, Curve | None] = {
            "bspline": None if plan.bspline is None else plan.bspline.curve,
            "quadratic": None if plan.quadratic is None else plan.quadratic.curve,
        }
        for name, curve in curves.items():
            line = self._lines[name]
            line.thickness = 7.0 if name == plan.followed else 4.0
            if self._drawn.get(name, self) is curve:
                continue
            self._drawn[name] = curve
            line.points = segments(np.zeros((0, 3)) if curve is None else _sample(curve))
            if name == "bspline":
                self._draw_control(plan)
            else:
                self._draw_entering(plan)

    def _fade(self, faded: bool) -> None:
        self._faded = faded
        for name, line in self._lines.items():
            line.colors = np.array(style.FADED if faded else style.CURVES[name][1], np.uint8)
        self._polygon.colors = np.array(style.FADED if faded else style.BSPLINE, np.uint8)
        self._entering.colors = np.array(style.FADED if faded else style.ENTERS, np.uint8)

    def _draw_entering(self, plan: Plan) -> None:
        """The stretches of the quadratic that come nearer than the clearance, in red."""
        parts = [segments(np.zeros((0, 3)))]
        if plan.quadratic is not None:
            for first, last in plan.quadratic.clearance.violations:
                parts.append(segments(plan.quadratic.curve(np.linspace(first, last, 24))))
        self._entering.points = np.concatenate(parts)

    def _draw_control(self, plan: Plan) -> None:
        points = np.zeros((0, 3)) if plan.bspline is None else plan.bspline.curve.control_points
        self._polygon.points = segments(points)
        self._control = self._scene.add_point_cloud(
            "/curve/control_points",
            points.astype(np.float32),
            style.BSPLINE,
            point_size=0.012 * max(plan.scene.workspace.size),
            point_shape="circle",
            precision="float32",
            visible=False,
        )


def _sample(curve: Curve) -> FloatArray:
    return curve(np.linspace(*curve.interval, SAMPLES))
