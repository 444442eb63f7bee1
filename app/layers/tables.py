"""The tables: searches as in the paper's Table I, lengths stage by stage, motion, formulas."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable
from typing import ClassVar

from abi.arm.trajectory import Violation
from abi.planner.plan import Plan
from app import style
from app.frame import Frame, Switch
from app.labels import at_least
from app.layout import Layout

_TABLE = (
    '<table style="width:100%;border-collapse:collapse;font-size:12.5px;'
    'font-variant-numeric:tabular-nums">'
)
_HEAD = "padding:3px 4px;font-weight:600;border-bottom:1px solid rgba(128,128,128,.5);"
_CELL = "padding:3px 4px;border-bottom:1px solid rgba(128,128,128,.22);"
GOOD, BAD = "#12a67c", "#e03131"
_PIECES_SHOWN = 2
_COARSE = (
    f"{style.BOX}<b>≈ coarse while you move</b>: pitch {{:.3g}} {{}}, one search. "
    "The mesh you asked for follows when your hand rests.</div>"
)
_PARTIAL = f"{style.BOX}One search while you move; the others follow when your hand rests.</div>"
_LEGEND = f"{style.BOX}✓ clear (curves: proven), ✗ too near: red in the scene.</div>"


class TablesLayer:
    """Two tables in the result tab, and the numbers of curves and arm in their folders."""

    switches: ClassVar[tuple[Switch, ...]] = ()

    def __init__(self, layout: Layout) -> None:
        gui = layout.client.gui
        with layout.result:
            self._tables = gui.add_html("")
        with layout.folders["bspline"]:
            self._bspline = gui.add_html("")
        with layout.folders["quadratic"]:
            self._quadratic = gui.add_html("")
        with layout.folders["arm"]:
            self._arm = gui.add_html("")
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
        self._bspline.content = _control_points(plan)
        self._quadratic.content = _coefficients(plan) + _motion(plan)
        self._arm.content = _arm(plan)


def _searches(plan: Plan, partial: bool) -> str:
    """Table I: the same columns, and what it cost; the others follow when the hand rests."""
    missing = "…" if partial else "–"
    found = {result.algorithm: result for result in plan.searches}
    rows = []
    for name, (label, colour) in style.ALGORITHMS.items():
        mark = style.swatch(colour, dashed=name == "dijkstra")
        chosen = name == plan.scene.search.algorithm
        title = f"{mark}<b>{label}</b>" if chosen else mark + label
        if name not in found:
            rows.append((title, *[missing] * 4))
            continue
        result = found[name]
        rows.append(
            (
                title,
                f"{len(result.vertices)}",
                f"{result.length:.3f}",
                f"{result.expanded:,}",
                f"{plan.ms[name]:.2g}" if plan.ms[name] < 10 else f"{plan.ms[name]:.0f}",
            )
        )
    return _table(("search", "vertices", "length", "expanded", "ms"), rows)


def _stages(plan: Plan) -> str:
    """What each stage does to the length, and how near it comes to the obstacles."""
    asked = plan.scene.spline.clearance
    shortest = plan.lower_bound if plan.optimum is None else plan.optimum.length
    rows = []
    if plan.path is not None:
        label, colour = style.ALGORITHMS[plan.path.algorithm]
        swatch = style.swatch(colour, dashed=plan.path.algorithm == "dijkstra")
        kept = _distance(plan.path_clearance, asked, proven=True)
        rows.append(_stage(f"{swatch}{label} path", plan.path.length, shortest, kept))
    if plan.taut is not None:
        kept = _distance(plan.taut.clearance, asked, proven=True)
        rows.append(_stage(f"{style.swatch(style.TAUT)}taut", plan.taut.length, shortest, kept))
    for name, curve, arc in (
        ("bspline", plan.bspline, plan.bspline_arc),
        ("quadratic", plan.quadratic, plan.quadratic_arc),
    ):
        if curve is None or arc is None:
            continue
        label, colour = style.CURVES[name]
        executed = "<b> ▸ arm</b>" if name == plan.followed else ""
        clearance = curve.clearance
        found = clearance.distance if clearance.certified else clearance.nearest
        kept = _distance(found, asked, proven=clearance.certified)
        row = _stage(f"{style.swatch(colour)}{label}{executed}", arc.length, shortest, kept)
        # A curve that cuts through has no gap to a bound for curves that do not.
        rows.append(row if curve.holds else (*row[:2], "–", row[3]))
    if not rows:
        return ""
    exact = plan.optimum is not None and plan.optimum.exact
    if exact:
        rows.append(("optimum", f"{shortest:.3f}", "", ""))
    elif plan.best_known is None:
        rows.append(("optimum, at least", f"{shortest:.3f}", "", ""))
    else:
        # from a proven bound to the best length known
        rows.append(("optimum, in", f"{shortest:.3f}–{plan.best_known:.3f}", "", ""))
    head = ("stage", f"length [{plan.scene.unit}]", "gap" if exact else "gap ≤", "clearance")
    told = plan.bspline is not None and plan.scene.obstacles
    return _table(head, rows) + (_LEGEND if told else "")


def _stage(title: str, length: float, shortest: float, kept: str) -> tuple[str, ...]:
    return title, f"{length:.3f}", f"{100 * max(length / shortest - 1, 0):.1f} %", kept


def _control_points(plan: Plan) -> str:
    """What it took to keep the spline clear; nothing to say when it took nothing."""
    spline = None if plan.bspline is None else plan.bspline.curve
    if spline is None or not (spline.inserted or spline.moved):
        return ""
    return (
        f"{style.BOX}{len(spline.control_points)} control points: {spline.inserted} added, "
        f"{spline.moved} pushed outward.</div>"
    )


def _coefficients(plan: Plan) -> str:
    """The curve as the paper prints it."""
    if plan.quadratic is None:
        return ""
    lines = []
    pieces = plan.quadratic.curve.pieces
    for first, last, (c0, c1, c2) in pieces[:_PIECES_SHOWN]:
        if len(pieces) > 1:
            lines.append(f"t from {first:.3f} to {last:.3f}:")
        lines += [
            f"P{axis}(t) = {_polynomial(c0[i], c1[i], c2[i])}" for i, axis in enumerate("xyz")
        ]
    if len(pieces) > _PIECES_SHOWN:
        lines.append(f"… {len(pieces)} pieces in all")
    if plan.quadratic.note:
        lines.append(f"✗ {html.escape(plan.quadratic.note)}")
    return (
        '<div style="margin:0 12px 3px;font:12px/1.4 ui-monospace,monospace">'
        + "<br>".join(lines)
        + "</div>"
    )


def _motion(plan: Plan) -> str:
    if plan.profile is None:
        return ""
    profile = plan.profile
    peak = f"{profile.peak_speed:.3g} {plan.scene.unit}/s"
    shape = f", V not reached: {peak}" if profile.triangular else ""
    return (
        f"{style.BOX}t1 {profile.t1:.3f} + t2 {profile.t2:.3f} + t3 {profile.t3:.3f} = "
        f"{profile.duration:.2f} s{shape}.<br>"
        f"Theorem 1: t1 = t3·|a3/a1| {'✓' if abs(profile.theorem_residual) < 1e-9 else '✗'} "
        f"({profile.t1:.3f} = {profile.t1 - profile.theorem_residual:.3f})</div>"
    )


def _arm(plan: Plan) -> str:
    if plan.motion is None:
        return ""
    motion, unit, curve = plan.motion, plan.scene.unit, plan.followed_curve
    lines = []
    if curve is not None and not curve.holds and plan.followed is not None:
        label = style.CURVES[plan.followed][0]
        lines.append(f"<b>✗ The {label}, which the arm follows, is too near an obstacle.</b>")
    if motion.clearance < math.inf:
        where = f"obstacle {motion.clearance_obstacle + 1}, at {motion.clearance_time:.2f} s"
        lines.append(
            f"The links' centre lines come nearest to {where}: {motion.clearance:.3f} {unit}."
            if motion.clearance > 0
            else f"<b>✗ A link passes through {where}.</b> Only the tool's path is planned clear."
        )
    lines += [_passed(violation, unit) for violation in motion.limit_violations]
    return style.BOX + "<br>".join(lines) + "</div>" if lines else ""


def _passed(violation: Violation, unit: str) -> str:
    """When a joint passes its limit, and by how much in the end."""
    slides = violation.joint == "q5"
    value, limit = (
        f"{number:.2f} {unit}" if slides else f"{math.degrees(number):.0f}°"
        for number in (violation.value, violation.limit)
    )
    return (
        f"✗ {violation.joint} passes its limit of {limit} at {violation.since:.2f} s: "
        f"{value} at {violation.time:.2f} s."
    )


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


def _distance(distance: float, asked: float, proven: bool) -> str:
    """The distance, with ✓ when what was asked for is proven, ✗ when it is not kept."""
    if math.isinf(distance):
        return "–"
    kept = distance >= asked - 1e-9
    colour, sign = (GOOD, "✓" if proven else "?") if kept else (BAD, "✗")
    shown = max(distance, 0.0) if kept else distance
    return f'<span style="color:{colour}">{at_least(shown)} {sign}</span>'


def _polynomial(*coefficients: float) -> str:
    """c0 + c1 t + c2 t² as the paper prints it: three decimals, terms that vanish left out."""
    text = ""
    for number, power in zip(coefficients, ("", "t", "t²"), strict=True):
        if abs(number) >= 5e-4:
            sign = ("−" if number < 0 else "") if not text else (" − " if number < 0 else " + ")
            text += f"{sign}{abs(number):.3f}{power}"
    return text or "0"
