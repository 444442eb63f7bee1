"""Lines of a plan: searched paths, the taut one, and the curves with their control points."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np
import viser

from abi.arrays import FloatArray
from abi.planner.plan import Plan
from abi.planner.stage_results import AnyFit
from app.drawing.lines import NO_SEGMENTS, Segments, add_line, dashes, parameters, segments
from app.layers.points import add_points, set_points
from app.shared.computed_once import once_a_plan
from app.state.frame import Draw, Frame
from app.ui import style
from app.ui.layout import Layout

SAMPLES = 160
# Not along any edge of the lattices, so that coinciding paths lie beside each other everywhere.
_OFFSET = np.array([0.53, -0.80, 0.27])
_OFFSET_FACTORS = (0.0, 1.0, -1.0, 2.0, -2.0)

_LINES: dict[str, tuple[str, style.Colour, float]] = {
    **{name: (f"/path/{name}", colour, 3.5) for name, (_, colour) in style.ALGORITHMS.items()},
    "taut": ("/path/taut", style.TAUT, 3.5),
    **{name: (f"/curve/{name}", colour, 5.0) for name, (_, colour) in style.CURVES.items()},
    "control": ("/curve/control_polygon", style.BSPLINE, 1.0),
    "violations": ("/curve/entering", style.VIOLATION, 9.0),
}
"""Node, colour and thickness, [px], of each line of a plan."""


def plan_lines_layer(layout: Layout) -> Draw:
    """A line for each path and curve, in grey while their plan is outdated.

    Paths are side by side where they coincide; Dijkstra's is dashed, as in the paper's Fig. 3, and
    so is the taut one, in long dashes. What the arm follows is the wider, and red where it comes
    too near an obstacle. The curve that it followed in the last plan at rest is a ghost, dashed and
    grey.
    """
    scene = layout.client.scene
    lines = {name: add_line(scene, *drawing) for name, drawing in _LINES.items()}
    ghost = add_line(scene, "/ghost", style.FADED, 3.0)
    control = add_points(scene, "/curve/control_points")
    was_faded = False
    last: Plan | None = None
    before: Plan | None = None

    def draw(frame: Frame) -> None:
        nonlocal was_faded, last, before
        plan, longest = frame.plan, max(frame.plan.scene.workspace.size)
        if last is None or plan.searches is not last.searches:
            _draw_searches(lines, plan)
        if last is None or plan.taut is not last.taut:
            points = np.zeros((0, 3)) if plan.taut is None else plan.taut.points
            lines["taut"].points = _dashed("taut", points, longest)
        for name, fit in plan.curves.items():
            lines[name].thickness = 7.0 if name == plan.followed else 4.0
            known = None if last is None else last.curves[name]
            if last is None or _curve_of(fit) is not _curve_of(known):
                lines[name].points = NO_SEGMENTS if fit is None else _curve(plan, name)
                if name == "bspline":
                    points = _control_points(plan)
                    lines["control"].points = segments(points)
                    set_points(control, points, style.BSPLINE, 0.025 * longest)
                else:
                    lines["violations"].points = _violations(plan)
        last = plan
        if frame.before is not before:
            before = frame.before
            ghost.points = _ghost(before)
        if (faded := not frame.current) != was_faded:
            was_faded = faded
            for name, (_, colour, _) in _LINES.items():
                lines[name].colors = np.array(style.FADED if faded else colour, np.uint8)
        for name, line in (*lines.items(), ("ghost", ghost)):
            line.visible = ("quadratic" if name == "violations" else name) in frame.shown
        control.visible = "control" in frame.shown

    return draw


def _draw_searches(lines: Mapping[str, viser.LineSegmentsHandle], plan: Plan) -> None:
    longest = max(plan.scene.workspace.size)
    results = {result.algorithm: result for result in plan.searches}
    factors = itertools.cycle(_OFFSET_FACTORS)
    for name, factor in zip(style.ALGORITHMS, factors, strict=False):
        line = lines[name]
        line.thickness = 3.2 if plan.path and name == plan.path.algorithm else 1.8
        if name not in results:
            line.points = NO_SEGMENTS
            continue
        points = results[name].points + factor * 0.006 * longest * _OFFSET
        line.points = _dashed(name, points, longest)


def _curve_of(fit: AnyFit | None) -> object:
    """The curve of a fit, which two plans may share; None without one."""
    return None if fit is None else fit.curve


def _control_points(plan: Plan) -> FloatArray:
    """Control points (n, 3) of the B-spline; none without one."""
    return np.zeros((0, 3)) if plan.bspline is None else plan.bspline.curve.control_points


def _violations(plan: Plan) -> Segments:
    """Stretches of the quadratic that come nearer than the clearance."""
    stretches = [NO_SEGMENTS]
    if plan.quadratic is not None:
        for first, last in plan.quadratic.clearance.violations:
            stretches.append(segments(plan.quadratic.curve(np.linspace(first, last, 24))))
    return np.concatenate(stretches)


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
