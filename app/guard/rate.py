"""Token bucket: a rate with room for bursts."""

from __future__ import annotations

import time


class Rate:
    """Token bucket: an amount a second that may pass, and an amount that may pass at once."""

    def __init__(self, per_second: float, burst: float) -> None:
        self._per_second, self._burst = per_second, burst
        self._left, self._last = burst, time.monotonic()

    def delay(self, amount: float) -> float:
        """Take ``amount``; the delay before the next, [s]."""
        now = time.monotonic()
        self._left = min(self._burst, self._left + (now - self._last) * self._per_second) - amount
        self._last = now
        return max(-self._left / self._per_second, 0.0)
