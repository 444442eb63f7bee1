"""Watch of a tab's plans: one is ended by another choice, and a slow one says what it does."""

from __future__ import annotations

import time
from collections.abc import Callable

_QUICK = 0.4
"""Seconds in which nobody asks what a plan does."""


class PlanWatch:
    """Watch as :func:`abi.progress.watched_by` takes it, of one plan after the other.

    Attributes:
        overtaken: whether something else has been chosen than what is planned; set from any thread.
        ended: moment at which a plan was told so last, [s], by the monotonic clock.
    """

    def __init__(self, tell: Callable[[str], None]) -> None:
        """Watch nothing yet; ``tell`` is called with what a slow plan does."""
        self.overtaken = False
        self.ended = 0.0
        self._tell = tell
        self._begun = 0.0
        self._does = self._said = ""

    def begin(self) -> None:
        """Watch a plan that begins now."""
        self._begun = time.monotonic()
        self._does = self._said = ""

    def cancelled(self) -> bool:
        """Check whether the plan is not wanted any more."""
        self._look()
        if self.overtaken:
            self.ended = time.monotonic()
        return self.overtaken

    def told(self, doing: str) -> None:
        """Take note of what the plan does now."""
        self._does = doing
        self._look()

    def _look(self) -> None:
        if self._does != self._said and time.monotonic() - self._begun > _QUICK:
            self._said = self._does
            self._tell(self._does)
