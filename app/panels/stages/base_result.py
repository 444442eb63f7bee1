"""Findings of the search for a base, as text under its button."""

from __future__ import annotations

import html

from abi.explain.base_map import BaseMap
from app.ui import style
from app.ui.numbers import format_length, format_lower_bound, format_setting

_REASONS = 4
"""Reasons told why places have no plan, the most frequent first."""


def base_result(found: BaseMap, whose: str) -> str:
    """Findings as HTML.

    Args:
        found: so far.
        whose: of which legs the search is, as a part of a sentence; empty where there is one.
    """
    if found.fault:
        return f"No base helps{whose}: {html.escape(found.fault)}"
    unit, best, lengths = found.scene.unit, found.best, found.lengths
    reasons = list(found.faults.items())[:_REASONS]
    counted = ", ".join(f"{count} × {html.escape(reason)}" for reason, count in reasons)
    without = f" Grey places have none: {counted}." if counted else ""
    tried = len(found.trials)
    if best is None or best.length is None or lengths is None:
        so_far = "" if found.is_done else " so far"
        return f"None of {tried} places{so_far} has a certified plan{whose}.{without}"
    place = ", ".join(format_setting(round(number, 4)) for number in best.base)
    clear = ""
    if best.clearance < float("inf"):
        clear = f", its links {format_lower_bound(best.clearance)} {unit} clear"
    count = tried - sum(found.faults.values())
    return (
        f"<b>Shortest{whose}: {format_length(best.length)} {unit}</b> with the base at "
        f"({place}){clear}. {count} of {tried} places have a certified plan."
        f"{without}{_scale(*lengths, unit)}"
    )


def _scale(least: float, most: float, unit: str) -> str:
    """The colours and their lengths, as HTML."""
    if most - least < 1e-9 * most:
        return ""
    stops = ",".join(style.css(colour) for colour in style.HEAT)
    return (
        '<div style="display:flex;gap:6px;align-items:center;margin-top:4px">'
        f"{format_length(least)}"
        f'<span style="flex:1;height:8px;background:linear-gradient(90deg,{stops})"></span>'
        f"{format_length(most)} {unit}</div>"
    )
