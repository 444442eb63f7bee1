"""Tables of the Result tab: searches as in the paper's Table I, and lengths stage by stage."""

from __future__ import annotations

import html
import math
from collections.abc import Mapping

from abi.planner.arm_words import contact_sentence, lacks_motion
from abi.planner.plan import Plan
from app.shared.computed_once import once_a_plan
from app.ui import style
from app.ui.numbers import (
    distance_to_show,
    format_count,
    format_excess,
    format_length,
    format_lower_bound,
    format_setting,
    format_time,
    unbroken,
)
from app.ui.table import table

Rows = Mapping[str, tuple[str, ...]]
"""Cells of a table's rows, by their names."""

_LEGEND = style.paragraph(
    "✓ keeps the distance you asked for (? unproven). ✗\N{NO-BREAK SPACE}closer: thick red in the "
    "scene. ▸ the arm follows it."
)
_NOTHING = ("–",) * 5
_UNTIMED = (
    '<span title="Told from the next plan on: this one was made while code was loaded.">–</span>'
)
_NO_STAGE = ("–",) * 3
_JOINTS_ALONE = "–: no path on the mesh; the joints were searched."
_OLD = '<span style="opacity:.55">{}</span>'
"""Of the last full plan, while the next has not got so far."""


def tables(plan: Plan, current: bool, old: Rows) -> str:
    """Both tables as HTML, as high for any plan.

    Args:
        plan: what is told.
        current: whether it belongs to the present input.
        old: results of an earlier plan for the searches that still follow.
    """
    stages = _stages(plan)
    if not current:  # what is proven of the plan is not of what was asked for
        stages = stages.replace(" ✓", "")
    return unbroken(_searches(plan, old) + stages)


@once_a_plan
def search_rows(plan: Plan) -> Rows:
    """Cells of each search's row, and its time."""
    return {
        result.algorithm: (
            f"{len(result.vertices)}",
            format_length(result.length),
            format_count(result.expanded),
            format_count(result.relaxed),
            _time(plan.ms.get(result.algorithm, 0.0)),
        )
        for result in plan.searches
    }


def _searches(plan: Plan, old: Rows) -> str:
    """Table I, with the work of each search and its time.

    Args:
        plan: what they found.
        old: results of an earlier plan for the searches that still follow.
    """
    results = search_rows(plan)
    rows = []
    for name, (label, colour) in style.ALGORITHMS.items():
        mark = style.swatch(colour, name)
        chosen = name == plan.scene.search.algorithm
        title = f'{mark}<span class="abi-name">{f"<b>{label}</b>" if chosen else label}</span>'
        if name not in results and name in old and plan.error is None:
            cells = tuple(_OLD.format(cell) for cell in old[name])
        else:
            cells = results.get(name, _NOTHING)
        rows.append((title, *cells))
    unit = plan.scene.unit
    head = ("search", "path nodes", f"length [{unit}]", "nodes visited", "edges tried", "time")
    return table(head, rows, _JOINTS_ALONE if _by_joints_alone(plan) else "")


def _by_joints_alone(plan: Plan) -> bool:
    """Whether there is a motion of the joints, and no path of the tool."""
    return plan.joint_search is not None and plan.path is None


def _time(ms: float) -> str:
    if ms == 0:  # it is not known
        return _UNTIMED
    return format_time(ms)


@once_a_plan
def _stages(plan: Plan) -> str:
    """Length, gap to the optimum and clearance of each stage's result."""
    unit, exact = plan.scene.unit, plan.optimum is not None and plan.optimum.exact
    shortest = plan.straight_length if plan.optimum is None else plan.optimum.length
    best = shortest, exact
    note = f"best possible: {format_lower_bound(shortest)} {unit}"
    if plan.path is None:  # so the tables are as high with the sentence on the searches
        note = "" if _by_joints_alone(plan) else "best possible: –"
    elif not exact and plan.best_known is None:
        note = f"best possible: at least {format_lower_bound(shortest)} {unit}"
    elif not exact:
        assert plan.best_known is not None
        low, high = format_lower_bound(shortest), format_length(plan.best_known)
        note = f"best possible: between {low} and {high} {unit}"
    longer = "longer than best" if exact else "longer by at most"
    head = ("stage", f"length [{unit}]", longer, f"distance kept [{unit}]")
    rows = [*_path_rows(plan, best), *_curve_rows(plan, best), _arm_row(plan)]
    return table(head, rows, note) + (_LEGEND if plan.scene.obstacles else "")


def _path_rows(plan: Plan, best: tuple[float, bool]) -> list[tuple[str, ...]]:
    """Rows of the path and, where it is asked for, of the straightened one."""
    required = plan.scene.spline.clearance
    algorithm = plan.scene.search.algorithm if plan.path is None else plan.path.algorithm
    label, colour = style.ALGORITHMS[algorithm]
    title = f"{style.swatch(colour, algorithm)}{label}"
    rows: list[tuple[str, ...]] = [(title, *_NO_STAGE)]
    if plan.path is not None:
        clearance = _clearance(plan.path_clearance, required, proven=True)
        rows = [_stage_row(title, plan.path.length, best, clearance)]
    title = f"{style.swatch(style.TAUT, 'taut')}shortcut"
    if plan.taut is not None:
        clearance = _clearance(plan.taut.clearance, required, proven=True)
        rows.append(_stage_row(title, plan.taut.length, best, clearance))
    elif plan.scene.search.taut:
        rows.append((title, *_NO_STAGE))
    return rows


def _curve_rows(plan: Plan, best: tuple[float, bool]) -> list[tuple[str, ...]]:
    """Rows of B-spline and quadratic."""
    rows: list[tuple[str, ...]] = []
    for name, fit in plan.curves.items():
        label, colour = style.CURVES[name]
        title = f"{style.swatch(colour)}{label}"
        if fit is None:
            rows.append((title, *_NO_STAGE))
            continue
        follows = name == plan.followed and not lacks_motion(plan)
        executed = "<b> ▸</b>" if follows else ""
        shown, certified = distance_to_show(fit.clearance), fit.clearance.certified
        clearance = _clearance(
            shown, plan.scene.spline.clearance, certified, alarming=name == plan.followed
        )
        row = _stage_row(title + executed, fit.arc.length, best, clearance)
        # the bound is on clear curves: one that is not has no gap to it
        rows.append(row if fit.holds else (*row[:2], "–", row[3]))
    return rows


def _arm_row(plan: Plan) -> tuple[str, ...]:
    """Row of the distance that the links keep; never red, as links that touch are in the scene."""
    kept = plan.arm_clearance
    if kept is None:
        return "whole arm", *_NO_STAGE
    unit, required = plan.scene.unit, format_setting(kept.required)
    hint = f"Of the links, {required} {unit} are asked for: stage 6."
    title = f'<span title="{hint}">whole arm (≥ {required})</span>'
    if lacks_motion(plan):  # what the arm touches that is drawn instead is another matter
        return title, "–", "–", '<span title="It has no motion: stage 6.">none ✗</span>'
    clearance = _clearance(kept.distance, kept.required, kept.certified, alarming=False)
    if kept.contacts:  # those with the floor and itself, too
        worst = kept.contacts[0]
        if worst.certain and not worst.apart:
            clearance = f"{'−' if worst.depth > 0 else ''}{format_length(worst.depth)} ✗"
        hint = html.escape(f"{contact_sentence(worst, unit)}.")
        clearance = f'<span title="{hint}">{clearance}</span>'
    return title, "–", "–", clearance


def _stage_row(
    title: str, length: float, best: tuple[float, bool], clearance: str
) -> tuple[str, ...]:
    longer = format_excess(length, *best)
    return title, format_length(length), longer, clearance


def _clearance(distance: float, required: float, proven: bool, alarming: bool = True) -> str:
    """The distance, with ✓ where the required one is proven, ? where only measured, else ✗.

    Unless it is ``alarming``, ✗ is not red: of a curve that the arm does not follow.
    """
    if math.isinf(distance):
        return "–"
    kept = distance >= required - 1e-9
    colour, sign = (style.GOOD, "✓" if proven else "?") if kept else (style.BAD, "✗")
    shown = max(distance, 0.0) if kept else distance
    if not kept and not alarming:
        return f"{format_lower_bound(shown)} {sign}"
    return f'<span style="color:{style.readable(colour)}">{format_lower_bound(shown)} {sign}</span>'
