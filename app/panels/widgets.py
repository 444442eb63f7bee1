"""Parts that several panels share: number boxes, and lists of choices with their labels."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import viser

from abi.errors import SceneError

Wake = Callable[[Any], None]
"""The callback of every widget: it wakes the tab's worker."""
Triple = tuple[float, float, float]
_Value = TypeVar("_Value")

DIGITS = 6
"""Decimals that a box takes; left to itself it takes no more than its first value has."""
_SHOWN_DIGITS = 3


class NumberBox:
    """Three numbers beside a gizmo."""

    def __init__(self, gui: viser.GuiApi, label: str, step: float, hint: str, wake: Wake) -> None:
        self.handle = gui.add_vector3(label, (0.0, 0.0, 0.0), step=step, hint=hint)
        self.handle.precision = DIGITS
        self.handle.on_update(wake)
        self._shown: Triple = (0.0, 0.0, 0.0)

    def typed(self, field: str) -> Triple | None:
        """What was typed since it was last shown; None for nothing.

        Raises:
            SceneError: not finite; ``field`` is named.
        """
        value = self.handle.value
        if value == self._shown:
            return None
        if not all(math.isfinite(number) and abs(number) <= 1e6 for number in value):
            raise SceneError(field, value, "finite numbers")
        self._shown = value
        return value

    def show(self, value: Any) -> None:
        """Show ``value``, unless it is what stands there, rounded."""
        shown = zip(map(float, value), self._shown, strict=True)
        if any(abs(a - b) > 1.5 * 10**-_SHOWN_DIGITS for a, b in shown):
            self.write(value)

    def write(self, value: Any) -> None:
        """Show ``value``, whatever was typed."""
        x, y, z = (round(float(number), _SHOWN_DIGITS) for number in value)
        self._shown = (x, y, z)
        self.handle.value = self._shown


def label_of(options: Mapping[str, _Value], value: _Value) -> str:
    """Label under which ``value`` stands in a list of choices."""
    return next(label for label, option in options.items() if option == value)


def within(value: float, low: float, high: float) -> float:
    """The number from ``low`` to ``high`` that is nearest to ``value``."""
    return min(max(value, low), high)
