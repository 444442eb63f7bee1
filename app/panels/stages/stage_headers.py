"""The stages' headings with their results."""

from __future__ import annotations

import math

import viser

from abi.errors import AbiError, SceneError
from abi.planner.arm_words import arm_result
from abi.planner.plan import Plan
from app.shared.once_a_plan import once_a_plan
from app.state.frame import Frame
from app.ui import style
from app.ui.numbers import format_length

TITLES = {
    "mesh": "1 · Mesh",
    "graph": "2 · Graph",
    "search": "3 · Search",
    "bspline": "4 · B-spline",
    "quadratic": "5 · Quadratic",
    "arm": "6 · Arm",
}
STAGES = tuple(TITLES)
_MAX_LENGTH = 30
"""Letters of a heading that fit beside its arrow in a wide font."""
_FAILURES = {"graph": "blocked ✗", "search": "no path ✗", "bspline": "too close ✗"}
"""Heading of a stage that has no result."""
_DRAWN = ("bspline", "quadratic", "arm")
"""Stages of which a lesson that does not show their layer of that name has no use."""
_STAGE_OF_FIELD = {
    "mesh": "mesh",
    "search": "search",
    "spline": "bspline",
    "quadratic": "quadratic",
    "motion": "quadratic",
    "arm": "arm",
}
SENTENCES = {
    "mesh": "The box becomes nodes; those in an obstacle, or too near one, are removed.",
    "graph": "What is left of the mesh is a graph, and every edge of it is clear.",
    "search": "Of all paths along the edges, find the shortest.",
    "bspline": "A smooth curve near the path, proven to stay clear.",
    "quadratic": "A simple formula instead of the spline, where one stays clear.",
    "arm": "Joint angles for each moment of the motion.",
}
"""What each stage does, to be read from afar."""


class StageHeaders:
    """The six folders, to be filled by the panels."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._drawn: tuple[object, ...] = ()
        self.folders: dict[str, viser.GuiFolderHandle] = {}
        for stage in STAGES:
            # viser sets a folder that follows another right away further apart
            gui.add_html("", visible=False)
            self.folders[stage] = gui.add_folder(
                TITLES[stage], expand_by_default=stage not in ("graph", "arm")
            )

    def draw(self, frame: Frame) -> None:
        """Write the plan's results into the headings, and where an error belongs."""
        plan = frame.plan
        state = plan, frame.refused, frame.asks, frame.lesson and frame.shown
        if state == self._drawn:
            return
        self._drawn = state
        results = dict(_results(plan))
        if frame.lesson:
            unused = {stage for stage in _DRAWN if stage not in frame.shown}
            results |= dict.fromkeys(results if frame.asks else unused, "")
        if frame.refused is not None:
            # what is true of the plan is not of what was asked for
            results = {name: result.removesuffix(" ✓") for name, result in results.items()}
        if (stage := _stage(frame.refused)) is not None:
            results[stage] = "not changed ✗"
        for stage, result in results.items():
            label = f"{TITLES[stage]} — {result}" if result else TITLES[stage]
            if self.folders[stage].label != label:
                self.folders[stage].label = label


def _stage(error: AbiError | None) -> str | None:
    """Stage whose inputs are wrong; None where they are not those of a stage."""
    if not isinstance(error, SceneError):
        return None
    return _STAGE_OF_FIELD.get(error.field.split(".")[0].split("[")[0])


@once_a_plan
def _results(plan: Plan) -> dict[str, str]:
    """Each stage's result, short enough for a heading on one line."""
    results = dict.fromkeys(STAGES, "")
    if plan.mesh is not None and plan.free is not None:
        results["mesh"] = f"{plan.free.nodes:,} free nodes"
    if plan.graph is not None:
        results["graph"] = f"{plan.graph.edge_count:,} edges"
    if plan.path is not None:
        results["search"] = _search_result(plan)
    for stage, (fit, arc) in plan.curves.items():
        if fit is None or arc is None:
            continue
        if fit.holds or math.isinf(fit.clearance.distance):
            results[stage] = f"{format_length(arc.length)} {plan.scene.unit} ✓"
        else:
            results[stage] = "too close ✗" if fit.clearance.nearest > 0 else "collides ✗"
    results["arm"] = arm_result(plan)
    if plan.error is not None:
        results[plan.error.stage] = _FAILURES.get(plan.error.stage, results[plan.error.stage])
    return results


def _search_result(plan: Plan) -> str:
    """Length of the path, and of the straightened one or the algorithm where there is room."""
    assert plan.path is not None
    length, unit = format_length(plan.path.length), plan.scene.unit
    if plan.taut is not None:
        return f"{length} → {format_length(plan.taut.length)} {unit}"
    name = style.ALGORITHMS[plan.path.algorithm][0]
    named = f"{name} {length} {unit}"
    return named if len(TITLES["search"] + named) < _MAX_LENGTH - 3 else f"{length} {unit}"
