"""Tables of the result tab: searches as in the paper's Table I, and lengths stage by stage."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import ClassVar

from abi.planner.plan import Plan
from app import style
from app.frame import Frame, Switch
from app.labels import format_lower_bound
from app.layout import Layout

_TABLE = (
    '<table style="width:100%;border-collapse:collapse;font-size:12.5px;'
    'font-variant-numeric:tabular-nums">'
)
_HEAD = "padding:3px 4px;font-weight:600;border-bottom:1px solid rgba(128,128,128,.5);"
_CELL = "padding:3px 4px;border-bottom:1px solid rgba(128,128,128,.22);"
GOOD, BAD = "#12a67c", "#e03131"
_COARSE = (
    f"{style.BOX}<b>≈ coarse while you move</b>: pitch {{:.3g}} {{}}, one search. "
    "The mesh you asked for follows when your hand rests.</div>"
)
_PARTIAL = f"{style.BOX}One search while you move; the others follow when your hand rests.</div>"
_LEGEND = f"{style.BOX}✓ clear (curves: proven), ✗ too near: red in the scene.</div>"


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
            note = _COARSE.format(plan.scene.mesh.pitch, plan.scene.unit)
        self._tables.content = _searches(plan, frame.partial) + _stages(plan) + note


def _searches(plan: Plan, partial: bool) -> str:
    """Table I, with expansions and times; ``partial``: searches without a result still follow."""
    missing = "…" if partial else "–"
    results = {result.algorithm: result for result in plan.searches}
    rows = []
    for name, (label, colour) in style.ALGORITHMS.items():
        mark = style.swatch(colour, dashed=name == "dijkstra")
        chosen = name == plan.scene.search.algorithm
        title = f"{mark}<b>{label}</b>" if chosen else mark + label
        if name not in results:
            rows.append((title, *[missing] * 4))
            continue
        result = results[name]
        ms = plan.ms[name]
        rows.append(
            (
                title,
                f"{len(result.vertices)}",
                f"{result.length:.3f}",
                f"{result.expanded:,}",
                f"{ms:.2g}" if ms < 10 else f"{ms:.0f}",
            )
        )
    return _table(("search", "vertices", "length", "expanded", "ms"), rows)


def _stages(plan: Plan) -> str:
    """Length, gap to the optimum and clearance of each stage's result."""
    required = plan.scene.spline.clearance
    shortest = plan.lower_bound if plan.optimum is None else plan.optimum.length
    rows = []
    if plan.path is not None:
        label, colour = style.ALGORITHMS[plan.path.algorithm]
        swatch = style.swatch(colour, dashed=plan.path.algorithm == "dijkstra")
        clearance = _clearance(plan.path_clearance, required, proven=True)
        rows.append(_stage_row(f"{swatch}{label} path", plan.path.length, shortest, clearance))
    if plan.taut is not None:
        clearance = _clearance(plan.taut.clearance, required, proven=True)
        rows.append(
            _stage_row(f"{style.swatch(style.TAUT)}taut", plan.taut.length, shortest, clearance)
        )
    for name, fit, arc in (
        ("bspline", plan.bspline, plan.bspline_arc),
        ("quadratic", plan.quadratic, plan.quadratic_arc),
    ):
        if fit is None or arc is None:
            continue
        label, colour = style.CURVES[name]
        executed = "<b> ▸ arm</b>" if name == plan.followed else ""
        certified = fit.clearance.certified
        distance = fit.clearance.distance if certified else fit.clearance.nearest
        clearance = _clearance(distance, required, proven=certified)
        row = _stage_row(
            f"{style.swatch(colour)}{label}{executed}", arc.length, shortest, clearance
        )
        # the bound is on clear curves: one that is not has no gap to it
        rows.append(row if fit.holds else (*row[:2], "–", row[3]))
    if not rows:
        return ""
    exact = plan.optimum is not None and plan.optimum.exact
    if exact:
        rows.append(("optimum", f"{shortest:.3f}", "", ""))
    elif plan.best_known is None:
        rows.append(("optimum, at least", f"{shortest:.3f}", "", ""))
    else:
        rows.append(("optimum, in", f"{shortest:.3f}–{plan.best_known:.3f}", "", ""))
    head = ("stage", f"length [{plan.scene.unit}]", "gap" if exact else "gap ≤", "clearance")
    legend = _LEGEND if plan.bspline is not None and plan.scene.obstacles else ""
    return _table(head, rows) + legend


def _stage_row(title: str, length: float, shortest: float, clearance: str) -> tuple[str, ...]:
    return title, f"{length:.3f}", f"{100 * max(length / shortest - 1, 0):.1f} %", clearance


def _clearance(distance: float, required: float, proven: bool) -> str:
    """The distance, with ✓ where the required one is proven, ? where only measured, else ✗."""
    if math.isinf(distance):
        return "–"
    kept = distance >= required - 1e-9
    colour, sign = (GOOD, "✓" if proven else "?") if kept else (BAD, "✗")
    shown = max(distance, 0.0) if kept else distance
    return f'<span style="color:{colour}">{format_lower_bound(shown)} {sign}</span>'


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [_row("th", _HEAD, head)] + [_row("td", _CELL, row) for row in rows]
    return f'<div style="margin:4px 8px 12px">{_TABLE}{"".join(lines)}</table></div>'


def _row(tag: str, css: str, cells: tuple[str, ...]) -> str:
    aligned = ("left", *("right" for _ in cells[1:]))
    return (
        "<tr>"
        + "".join(
            f'<{tag} style="{css}text-align:{side};white-space:nowrap">{cell}</{tag}>'
            for side, cell in zip(aligned, cells, strict=True)
        )
        + "</tr>"
    )
