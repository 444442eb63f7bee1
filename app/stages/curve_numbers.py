"""Large numbers over the scene, and those of a curve: length, gap and distance kept."""

from __future__ import annotations

import math
from collections.abc import Sequence

from abi.planner.plan import Plan
from app.ui import style
from app.ui.numbers import distance_to_show, format_excess, format_length, format_lower_bound

Number = tuple[str, str, str]
"""HTML of a number, its name, and what it means."""
_ALONE = "tool tip only, arm ignored"


def blocks(numbers: Sequence[Number]) -> str:
    """The numbers side by side as HTML; empty for none."""
    if not numbers:
        return ""
    content = "".join(
        f'<div title="{hint}"><b>{value}</b><span>{name}</span></div>'
        for value, name, hint in numbers
    )
    return f'<div class="abi-card abi-numbers">{content}</div>'


def judged(text: str, good: bool) -> str:
    """HTML of a number in the colour and with the sign of good or bad."""
    colour, sign = (style.GOOD, "✓") if good else (style.BAD, "✗")
    return f'<span style="font-size:inherit;color:{style.readable(colour)}">{text} {sign}</span>'


def excess(plan: Plan, length: float) -> Number:
    """Excess of a length over the optimum, or an upper bound of it."""
    exact = plan.optimum is not None and plan.optimum.exact
    shortest = plan.straight_length if plan.optimum is None else plan.optimum.length
    share = format_excess(length, shortest, exact)
    hint = "Than the shortest clear path. ≤ where only a length is proven that no path goes below."
    return (share if exact else f"≤ {share}", "longer than the best", hint)


def curve_numbers(plan: Plan, curve: str) -> list[Number]:
    """Length, gap and kept distance of a curve, ``bspline`` or ``quadratic``; none without it."""
    fit = plan.curves[curve]
    if fit is None:
        return []
    unit, followed = plan.scene.unit, curve == plan.followed
    hint = "Length of the curve that the arm follows." if followed else "Length of the curve."
    length = f"{format_length(fit.arc.length)} {unit}"
    numbers = [(length, f"{style.CURVES[curve][0]} length", hint)]
    if fit.holds:
        numbers.append(excess(plan, fit.arc.length))
    distance = distance_to_show(fit.clearance)
    if math.isinf(distance):
        return numbers
    shown = f"{format_lower_bound(max(distance, 0.0) if fit.holds else distance)} {unit}"
    if not followed:
        hint = "Least distance of the curve from the obstacles; proven if there is a ✓."
        numbers.append((judged(shown, fit.holds), "closest to an obstacle (curve)", hint))
    elif fit.holds and not plan.is_arm_clear:
        # no sign that all is well, while a link may go through something or cannot get there
        hint = "The tool tip's curve keeps it, but the whole arm is not proven clear."
        name = "tool tip only, arm not clear" if plan.scene.arm.avoid else _ALONE
        numbers.append((shown, name, hint))
    else:
        hint = (
            "Least distance of the tool tip's curve from the obstacles; proven if there is a ✓. "
            "Stage 6 tells that of the links."
        )
        numbers.append((judged(shown, fit.holds), "closest to an obstacle (tool tip)", hint))
    return numbers
