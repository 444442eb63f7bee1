"""Reasons why an arm cannot take its pose at a place."""

from __future__ import annotations

import math
from typing import NamedTuple

from abi.errors import format_length


class Unreached(NamedTuple):
    """A place that is out of an arm's reach, or takes a joint past its limit.

    Attributes:
        shortfall: distance by which the place is out of reach, [unit]: > 0 too far, < 0 too near to
            the shoulder, 0 where a limit alone is in the way.
        joint: name of a joint that is at its limit, or would be past it; empty for none.
        value: position of that joint, [rad] or [unit].
        limit: its limit, [rad] or [unit].
        slides: whether it slides.
    """

    shortfall: float
    joint: str = ""
    value: float = 0.0
    limit: float = 0.0
    slides: bool = False

    @property
    def words(self) -> str:
        """Predicate of a sentence on the arm; behind lengths is the placeholder of the unit."""
        value, limit = map(self._position, (self.value, self.limit))
        if self.shortfall == 0.0:
            side = "past" if abs(self.value) > abs(self.limit) else "at"
            return f"would need {self.joint} at {value}, {side} its limit of {limit},"
        near = ", too near to its shoulder," if self.shortfall < 0 else ""
        at_limit = f", with {self.joint} at its limit of {limit}," if self.joint else ""
        return f"is out of reach by {format_length(abs(self.shortfall))}{near}{at_limit}"

    def _position(self, value: float) -> str:
        return format_length(value) if self.slides else f"{math.degrees(value):.1f}°"
