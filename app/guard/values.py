"""Validation of a widget's new value, since viser stores whatever it receives."""

from __future__ import annotations

import math
from typing import Any, TypeGuard

MAX_TEXT = 3_500_000
"""Most characters of a text; the longest is a tab's state, see
:meth:`app.state.tab_state.TabState.encode`."""
_MAX_INTEGER = 1e15


def fits(widget: Any, value: object) -> bool:
    """Check whether ``value`` has the type that the widget holds.

    A number may be out of the widget's range, or no finite one: typing passes through such numbers,
    and the panel that reads them says what is wrong with the last.

    Args:
        widget: a viser handle with a value.
        value: plain data as it came.
    """
    held = widget.value
    options = getattr(widget, "options", None)
    if options is not None:
        return isinstance(value, str) and value in options
    if isinstance(held, tuple):
        return (
            isinstance(value, list)
            and len(value) == len(held)
            and all(_like(old, new) for old, new in zip(held, value, strict=True))
        )
    return _like(held, value)


def _like(held: object, value: object) -> bool:
    if isinstance(held, bool):
        return isinstance(value, bool)
    if isinstance(held, int):
        # viser casts it to int, which takes no nan and no infinity
        return _is_number(value) and math.isfinite(value) and abs(value) < _MAX_INTEGER
    if isinstance(held, float):
        return _is_number(value)
    return isinstance(held, str) and isinstance(value, str) and len(value) <= MAX_TEXT


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool)
