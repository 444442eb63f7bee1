"""The plan's three headline numbers, over the scene."""

from __future__ import annotations

import math

from abi.planner.plan import Plan
from app import style
from app.frame import Frame, Layer
from app.layout import Layout
from app.numbers import distance_to_show, format_excess, format_length, format_lower_bound
from app.once_a_plan import once_a_plan

_HINTS = {
    "length": "Length of the curve that the arm follows.",
    "longer than the best": "Than the shortest clear path. ≤ where only a length is proven that "
    "no path goes below.",
    "kept by the tool": "Least distance of the tool's curve from the obstacles; proven if there "
    "is a ✓. Stage 6 tells that of the links.",
    "kept by the tool alone": "The tool's curve keeps it, but the whole arm is not proven clear.",
}
"""Meaning of each number, by the end of its name."""


class HeadlineLayer(Layer):
    """Length, gap and distance kept of the curve that the arm follows."""

    def __init__(self, layout: Layout) -> None:
        self._overlay = layout.overlay

    def draw(self, frame: Frame) -> None:
        """Write the plan's numbers; none without a curve, or while something else is shown."""
        plan = frame.plan
        told = frame.lecture and plan.followed not in frame.shown
        hidden = told or frame.theatre is not None
        self._overlay.show("numbers", "" if hidden else headline(plan))


@once_a_plan
def headline(plan: Plan) -> str:
    """The three numbers as HTML; empty where no curve is followed."""
    fit, arc, unit = plan.followed_curve, plan.followed_arc, plan.scene.unit
    if fit is None or arc is None or plan.followed is None:
        return ""
    shortest = plan.straight_length if plan.optimum is None else plan.optimum.length
    numbers = [(f"{format_length(arc.length)} {unit}", f"{style.CURVES[plan.followed][0]} length")]
    if fit.holds:
        exact = plan.optimum is not None and plan.optimum.exact
        share = format_excess(arc.length, shortest, exact)
        numbers.append((share if exact else f"≤ {share}", "longer than the best"))
    distance = distance_to_show(fit.clearance)
    if math.isfinite(distance):
        shown = format_lower_bound(max(distance, 0.0) if fit.holds else distance)
        if fit.holds and not plan.is_arm_clear:
            # no sign that all is well, while a link may go through something or cannot get there
            numbers.append((f"{shown} {unit}", "kept by the tool alone"))
        else:
            colour, sign = (style.GOOD, "✓") if fit.holds else (style.BAD, "✗")
            kept = f'<span style="font-size:inherit;color:{style.readable(colour)}">'
            numbers.append((f"{kept}{shown} {unit} {sign}</span>", "kept by the tool"))
    blocks = "".join(
        f'<div title="{_hint(name)}"><b>{value}</b><span>{name}</span></div>'
        for value, name in numbers
    )
    return f'<div class="abi-card abi-numbers">{blocks}</div>'


def _hint(name: str) -> str:
    return next(hint for end, hint in _HINTS.items() if name.endswith(end))
