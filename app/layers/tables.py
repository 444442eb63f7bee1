"""Tables of the result tab: searches as in the paper's Table I, and lengths stage by stage."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import ClassVar

from abi.planner.plan import Plan
from app import style
from app.frame import Frame, Switch
from app.layout import Layout
from app.numbers import (
    distance_to_show,
    format_count,
    format_excess,
    format_length,
    format_lower_bound,
    format_setting,
    format_time,
    unbroken,
)
from app.once_a_plan import once_a_plan

_STYLE = (
    "<style>.abi-table{width:100%;border-collapse:collapse;font-size:12.5px;"
    "font-variant-numeric:tabular-nums}"
    ".abi-table th,.abi-table td{padding:3px 4px;text-align:right;white-space:nowrap;"
    "border-bottom:1px solid rgba(128,128,128,.22)}"
    ".abi-table th{font-weight:600;white-space:normal;vertical-align:bottom;"
    "border-bottom-color:rgba(128,128,128,.5)}"
    ".abi-table :first-child{text-align:left}"
    ".mantine-Tabs-tab{padding-left:9px;padding-right:9px}"
    ".abi-name{display:inline-block;max-width:7.6em;white-space:normal;vertical-align:middle}"
    "@media(max-height:760px){.abi-table th,.abi-table td{padding:2px 4px}}"
    "@media(max-width:600px){.abi-table{font-size:12px}"
    ".abi-table th,.abi-table td{padding:2px}}</style>"
)
"""Numbers stay on one line; names and headings wrap where the font is wide or the page narrow."""
_COARSE = (
    f"{style.BOX}<b>≈ While you drag</b>: coarser grid ({{}} {{}}), only one search. "
    "Let go for the full plan.</div>"
)
_PARTIAL = f"{style.BOX}While you drag: only one search. Let go for the others.</div>"
_LEGEND = (
    f"{style.BOX}✓ keeps the distance you asked for. ✗ comes closer: thick red in the scene. "
    "▸ the arm follows this one.</div>"
)
_UNPROVEN = f"{style.BOX}? keeps it wherever it was measured, but this is not proven.</div>"
FASTEST_SHOWN = 1.0
"""Shorter times say more about the machine than about the search, [ms]."""


class TablesLayer:
    """The two tables, and a note while they are not those of the final plan."""

    switches: ClassVar[tuple[Switch, ...]] = ()

    def __init__(self, layout: Layout) -> None:
        with layout.result:
            self._tables = layout.client.gui.add_html("")
        self._drawn: tuple[object, ...] = ()

    def draw(self, frame: Frame) -> None:
        """Write the plan's numbers."""
        plan = frame.plan
        state = plan, frame.coarse, frame.partial
        if state == self._drawn:
            return
        self._drawn = state
        note = _PARTIAL if frame.partial else ""
        if frame.coarse:
            note = _COARSE.format(format_setting(plan.scene.mesh.pitch), plan.scene.unit)
        self._tables.content = unbroken(_searches(plan, frame.partial) + _stages(plan) + note)


@once_a_plan
def _searches(plan: Plan, partial: bool) -> str:
    """Table I, with the work of each search; ``partial``: some searches still follow."""
    missing = "…" if partial else "–"
    results = {result.algorithm: result for result in plan.searches}
    rows = []
    for name, (label, colour) in style.ALGORITHMS.items():
        mark = style.swatch(colour, dashed=name == "dijkstra")
        chosen = name == plan.scene.search.algorithm
        title = f'{mark}<span class="abi-name">{f"<b>{label}</b>" if chosen else label}</span>'
        if name not in results:
            rows.append((title, *[missing] * 4))
            continue
        result = results[name]
        rows.append(
            (
                title,
                f"{len(result.vertices)}",
                format_length(result.length),
                format_count(result.expanded),
                format_count(result.relaxed),
            )
        )
    head = ("search", "path nodes", f"length [{plan.scene.unit}]", "nodes visited", "edges tried")
    return table(head, rows) + _times(plan, missing)


def _times(plan: Plan, missing: str) -> str:
    """Times of the searches in the order of the table: one line, however long they took."""
    if not plan.searches:
        return ""
    times = [plan.ms.get(name) for name in style.ALGORITHMS]
    told = (missing if ms is None else _time(ms) for ms in times)
    return f"{style.BOX}Time, in this order: {', '.join(told)}.</div>"


def _time(ms: float) -> str:
    return format_time(ms) if ms >= FASTEST_SHOWN else f"&lt;{format_time(FASTEST_SHOWN)}"


@once_a_plan
def _stages(plan: Plan) -> str:
    """Length, gap to the optimum and clearance of each stage's result."""
    required = plan.scene.spline.clearance
    shortest = plan.straight_length if plan.optimum is None else plan.optimum.length
    exact = plan.optimum is not None and plan.optimum.exact
    best, rows = (shortest, exact), []
    if plan.path is not None:
        label, colour = style.ALGORITHMS[plan.path.algorithm]
        swatch = style.swatch(colour, dashed=plan.path.algorithm == "dijkstra")
        clearance = _clearance(plan.path_clearance, required, proven=True)
        rows.append(_stage_row(f"{swatch}{label}", plan.path.length, best, clearance))
    if plan.taut is not None:
        clearance = _clearance(plan.taut.clearance, required, proven=True)
        rows.append(
            _stage_row(f"{style.swatch(style.TAUT)}straightened", plan.taut.length, best, clearance)
        )
    for name, fit, arc in (
        ("bspline", plan.bspline, plan.bspline_arc),
        ("quadratic", plan.quadratic, plan.quadratic_arc),
    ):
        if fit is None or arc is None:
            continue
        label, colour = style.CURVES[name]
        executed = "<b> ▸</b>" if name == plan.followed else ""
        certified = fit.clearance.certified
        clearance = _clearance(distance_to_show(fit.clearance), required, proven=certified)
        row = _stage_row(f"{style.swatch(colour)}{label}{executed}", arc.length, best, clearance)
        # the bound is on clear curves: one that is not has no gap to it
        rows.append(row if fit.holds else (*row[:2], "–", row[3]))
    if not rows:
        return ""
    unit = plan.scene.unit
    note = f"best possible: {format_lower_bound(shortest)} {unit}"
    if not exact and plan.best_known is None:
        note = f"best possible: at least {format_lower_bound(shortest)} {unit}"
    elif not exact:
        assert plan.best_known is not None
        low, high = format_lower_bound(shortest), format_length(plan.best_known)
        note = f"best possible: between {low} and {high} {unit}"
    longer = "longer than best" if exact else "longer by at most"
    head = ("stage", f"length [{unit}]", longer, f"distance kept [{unit}]")
    legend = _LEGEND if plan.bspline is not None and plan.scene.obstacles else ""
    if legend and any("?" in cell for row in rows for cell in row):
        legend += _UNPROVEN
    return table(head, rows, note) + legend


def _stage_row(
    title: str, length: float, best: tuple[float, bool], clearance: str
) -> tuple[str, ...]:
    longer = format_excess(length, *best)
    return title, format_length(length), longer, clearance


def _clearance(distance: float, required: float, proven: bool) -> str:
    """The distance, with ✓ where the required one is proven, ? where only measured, else ✗."""
    if math.isinf(distance):
        return "–"
    kept = distance >= required - 1e-9
    colour, sign = (style.GOOD, "✓" if proven else "?") if kept else (style.BAD, "✗")
    shown = max(distance, 0.0) if kept else distance
    return f'<span style="color:{style.readable(colour)}">{format_lower_bound(shown)} {sign}</span>'


def table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]], last: str = "") -> str:
    """An HTML table of rows under a head; ``last`` is one cell over the whole width."""
    lines = [_row("th", head)] + [_row("td", row) for row in rows]
    if last:
        cell = f'<td colspan="{len(head)}" style="white-space:normal">{last}</td>'
        lines.append(f"<tr>{cell}</tr>")
    return (
        f'{_STYLE}<div style="margin:4px 8px 6px"><table class="abi-table">{"".join(lines)}'
        "</table></div>"
    )


def _row(tag: str, cells: tuple[str, ...]) -> str:
    return f"<tr>{''.join(f'<{tag}>{cell}</{tag}>' for cell in cells)}</tr>"
