"""Widgets that several panels share: buttons, vectors of numbers, and labels of choices."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import viser

from abi.errors import SceneError
from abi.obstacles.pose import Vec3
from app.ui.numbers import format_setting

Wake = Callable[[Any], None]
"""Callback of every widget: it wakes the tab's worker."""
_Value = TypeVar("_Value")

DIGITS = 6
"""Decimals that a box takes; by default those of its first value."""
_SHOWN_DIGITS = 3


def range_hint(hint: str, low: float, high: float, unit: str = "") -> str:
    """A hint, and the range of the box that it belongs to.

    A box leaves out what is typed beyond its range, and does not say so.
    """
    end = f"{format_setting(high)} {unit}".rstrip()
    return f"{hint} From {format_setting(low)} to {end}."


def pressed(button: viser.GuiButtonHandle) -> bool:
    """Check whether a button was pressed since the last call."""
    was_pressed = button.value
    if was_pressed:  # one that comes right after the look is for the next call
        button.value = False
    return was_pressed


def hidden_button(
    gui: viser.GuiApi, label: str, call: Callable[[Any], None]
) -> viser.GuiButtonHandle:
    """Add a button that others press, as those over the scene do."""
    button = gui.add_button(label, visible=False)
    button.on_click(call)
    return button


def phase_holds(phase: str, held: bool) -> bool:
    """Check if a hand holds what it drags after a drag's ``phase``, if it was ``held`` before."""
    return phase != "end" and (held or phase == "start")


class VectorBox:
    """Three numbers that show, and set, what a gizmo shows."""

    def __init__(self, gui: viser.GuiApi, label: str, step: float, hint: str, wake: Wake) -> None:
        self.handle = gui.add_vector3(label, (0.0, 0.0, 0.0), step=step, hint=hint)
        self.handle.precision = DIGITS
        self.handle.on_update(wake)
        self._shown: Vec3 = (0.0, 0.0, 0.0)

    def typed(self, field: str) -> Vec3 | None:
        """Value typed since the last call of a method here; None for no new one.

        Raises:
            SceneError: not finite; names ``field``.
        """
        value = self.handle.value
        if value == self._shown:
            return None
        if not all(math.isfinite(number) and abs(number) <= 1e6 for number in value):
            raise SceneError(field, value, "finite numbers")
        self._shown = value
        return value

    def show(self, value: Any) -> None:
        """Show ``value``, unless it is that of the box up to rounding."""
        shown = zip(map(float, value), self._shown, strict=True)
        if any(abs(a - b) > 0.51 * 10**-_SHOWN_DIGITS for a, b in shown):
            self.write(value)

    def write(self, value: Any) -> None:
        """Show ``value`` in place of anything typed."""
        x, y, z = (round(float(number), _SHOWN_DIGITS) for number in value)
        self._shown = (x, y, z)
        self.handle.value = self._shown


def label_of(options: Mapping[str, _Value], value: _Value) -> str:
    """Label of ``value`` in a list of choices."""
    return next(label for label, option in options.items() if option == value)


def clamp(value: float, low: float, high: float) -> float:
    """The number from ``low`` to ``high`` nearest to ``value``."""
    return min(max(value, low), high)
