"""Watch over a tab's plans: another choice cancels one, and a slow one reports its progress."""

from __future__ import annotations

import time
from collections.abc import Callable

_QUICK = 0.4
"""Seconds of planning without a progress report."""


class PlanWatch:
    """Watch for :func:`abi.progress.watched_by`, of one plan after the other.

    Attributes:
        overtaken: whether something else has been chosen than what is planned; set from any thread.
        ended: moment at which a plan was told so last, [s], by the monotonic clock.
    """

    def __init__(self, tell: Callable[[str], None]) -> None:
        """Watch nothing yet; ``tell`` is called with the progress of a slow plan."""
        self.overtaken = False
        self.ended = 0.0
        self._tell = tell
        self._begun = 0.0
        self._does = self._said = ""

    def begin(self) -> None:
        """Start to watch a plan."""
        self._begun = time.monotonic()
        self._does = self._said = ""

    def cancelled(self) -> bool:
        """Check whether the plan is not wanted any more."""
        self._look()
        if self.overtaken:
            self.ended = time.monotonic()
        return self.overtaken

    def told(self, doing: str) -> None:
        """Receive what the plan is doing now."""
        self._does = doing
        self._look()

    def _look(self) -> None:
        if self._does != self._said and time.monotonic() - self._begun > _QUICK:
            self._said = self._does
            self._tell(self._does)
