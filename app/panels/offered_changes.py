"""Changes of the scene that a diagnosis offers, and the words of their buttons."""

from __future__ import annotations

import math
from typing import Any

from abi.explain.reason import Reason
from app.ui.labels import LABELS
from app.ui.numbers import format_setting

Offers = dict[str, dict[str, Any]]
"""Changes of the scene by the labels of the buttons that make them."""


def offered_changes(reason: Reason | None) -> Offers:
    """Changes of the scene that give a plan; none that only leads to the next error."""
    if reason is None or reason.change is None or not reason.is_whole:
        return {}
    offers: Offers = {}
    for change in (reason.change, *reason.others):
        offers.setdefault(change_label(change, reason), change)
    return offers


def change_label(change: dict[str, Any], reason: Reason | None) -> str:
    """Text of the button that makes one of a diagnosis' changes of the scene."""
    if reason is not None and reason.obstacle is not None:
        return f"Remove obstacle {reason.obstacle + 1}"
    parts = []
    for section, value in change.items():
        if section == "obstacles" and reason is not None and reason.moved is not None:
            parts.append(f"move obstacle {reason.moved + 1} there")
        elif section in ("start", "goal"):
            parts.append(f"move the {section}")
        elif isinstance(value, dict):
            for name, number in value.items():
                label = LABELS.get(f"{section}.{name}", name)
                kept = isinstance(number, dict)
                parts.append(_kept(number) if kept else f"set {label} to {_setting(number)}")
        else:
            parts.append(f"change {section}")
    text = " and ".join(parts)
    return text[:1].upper() + text[1:]


def _kept(axis: dict[str, Any]) -> str:
    """Advice on how to hold the tool's direction for a part of the motion only."""
    begin, end = 100 * axis["from"], 100 * axis["to"]
    within = math.degrees(axis["tolerance"])
    return f"keep the direction within {within:.3g}° from {begin:.3g} to {end:.3g} % of the time"


def _setting(value: object) -> str:
    """A setting as it is written on the page; coordinates in parentheses."""
    if isinstance(value, list | tuple):
        return f"({', '.join(map(_setting, value))})"
    return format_setting(value) if isinstance(value, float) else str(value)
