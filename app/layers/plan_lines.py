"""Lines of a plan: searched paths, the taut one, and the curves with their control points."""

from __future__ import annotations

import itertools

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.planner.plan import Plan
from app.drawing.lines import NO_SEGMENTS, Segments, add_line, dashes, parameters, segments
from app.layers.points import add_points, set_points
from app.shared.computed_once import once_a_plan
from app.state.frame import Frame
from app.ui import style
from app.ui.layout import Layout

SAMPLES = 160
# Not along any edge of the lattices, so that coinciding paths lie beside each other everywhere.
_OFFSET = np.array([0.53, -0.80, 0.27])
_OFFSET_FACTORS = (0.0, 1.0, -1.0, 2.0, -2.0)


class PlanLinesLayer:
    """A line for each path and curve, in grey while their plan is outdated.

    Paths are side by side where they coincide; Dijkstra's is dashed, as in the paper's Fig. 3, and
    so is the taut one, in long dashes. What the arm follows is the wider, and red where it comes
    too near an obstacle. The curve that it followed in the last plan at rest is a ghost, dashed and
    grey.
    """

    def __init__(self, layout: Layout) -> None:
        scene = self._scene = layout.client.scene
        self._colours: dict[str, style.Colour] = {}
        self._lines: dict[str, viser.LineSegmentsHandle] = {}
        for name, (_, colour) in style.ALGORITHMS.items():
            self._add(name, f"/path/{name}", colour, 3.5)
        self._add("taut", "/path/taut", style.TAUT, 3.5)
        for name, (_, colour) in style.CURVES.items():
            self._add(name, f"/curve/{name}", colour, 5.0)
        self._add("control", "/curve/control_polygon", style.BSPLINE, 1.0)
        self._add("violations", "/curve/entering", style.VIOLATION, 9.0)
        self._ghost = add_line(scene, "/ghost", style.FADED, 3.0)
        self._control = add_points(scene, "/curve/control_points")
        self._faded = False
        self._drawn: dict[str, object] = {}

    def _add(self, name: str, node: str, colour: style.Colour, thickness: float) -> None:
        self._colours[name] = colour
        self._lines[name] = add_line(self._scene, node, colour, thickness)

    def __call__(self, frame: Frame) -> None:
        """Draw the plan's paths and curves, and that of the plan before; none where none are."""
        plan = frame.plan
        if self._is_new("searches", plan.searches):
            self._draw_searches(plan)
        if self._is_new("taut", plan.taut):
            longest = max(plan.scene.workspace.size)
            points = np.zeros((0, 3)) if plan.taut is None else plan.taut.points
            self._lines["taut"].points = _dashed("taut", points, longest)
        self._draw_curves(plan)
        if self._is_new("ghost", frame.before):
            self._ghost.points = _ghost(frame.before)
        self._fade(not frame.current)
        for name, line in (*self._lines.items(), ("ghost", self._ghost)):
            line.visible = ("quadratic" if name == "violations" else name) in frame.shown
        self._control.visible = "control" in frame.shown

    def _is_new(self, name: str, drawn: object) -> bool:
        """Note what is drawn now by a name; whether it is another object than before."""
        is_new = self._drawn.get(name, self) is not drawn
        self._drawn[name] = drawn
        return is_new

    def _fade(self, faded: bool) -> None:
        """Draw the plan's lines in grey, or in their colours."""
        if faded != self._faded:
            self._faded = faded
            for name, line in self._lines.items():
                line.colors = np.array(style.FADED if faded else self._colours[name], np.uint8)

    def _draw_searches(self, plan: Plan) -> None:
        longest = max(plan.scene.workspace.size)
        results = {result.algorithm: result for result in plan.searches}
        factors = itertools.cycle(_OFFSET_FACTORS)
        for name, factor in zip(style.ALGORITHMS, factors, strict=False):
            line = self._lines[name]
            line.thickness = 3.2 if plan.path and name == plan.path.algorithm else 1.8
            if name not in results:
                line.points = NO_SEGMENTS
                continue
            points = results[name].points + factor * 0.006 * longest * _OFFSET
            line.points = _dashed(name, points, longest)

    def _draw_curves(self, plan: Plan) -> None:
        for name, fit in plan.curves.items():
            line, curve = self._lines[name], None if fit is None else fit.curve
            line.thickness = 7.0 if name == plan.followed else 4.0
            if not self._is_new(name, curve):
                continue
            line.points = NO_SEGMENTS if curve is None else _curve(plan, name)
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
        self._lines["violations"].points = np.concatenate(stretches)

    def _draw_control(self, plan: Plan) -> None:
        points = np.zeros((0, 3)) if plan.bspline is None else plan.bspline.curve.control_points
        self._lines["control"].points = segments(points)
        set_points(self._control, points, style.BSPLINE, 0.025 * max(plan.scene.workspace.size))


@once_a_plan
def _curve(plan: Plan, name: str) -> Segments:
    """The curve of that name as segments."""
    fit = plan.curves[name]
    assert fit is not None
    return segments(fit.curve(parameters(fit.curve.interval, SAMPLES)))


def _dashed(name: str, points: FloatArray, longest: float) -> Segments:
    """Segments of a path, dashed where the one so named is; ``longest`` is the workspace's side."""
    if name not in style.DASHES:
        return segments(points)
    return dashes(points, style.DASHES[name][0] * longest) if len(points) else NO_SEGMENTS


def _ghost(plan: Plan | None) -> Segments:
    """The curve that a plan's arm follows, as dashes; nothing where there is none."""
    fit = None if plan is None else plan.followed_curve
    if plan is None or fit is None:
        return NO_SEGMENTS
    points = fit.curve(parameters(fit.curve.interval, SAMPLES))
    return dashes(points, 0.02 * max(plan.scene.workspace.size))
