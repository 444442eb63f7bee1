"""A long run that ends early, with what it has."""

from __future__ import annotations

import signal
import sys
from types import FrameType

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Interrupt:
    """Whether Ctrl+C or SIGTERM has come, while the block lasts; a second one ends it at once.

    Attributes:
        asked: whether to end.
    """

    def __init__(self) -> None:
        self.asked = False

    def __enter__(self) -> Interrupt:
        """Listen."""
        self._before = [signal.signal(number, self._hear) for number in _SIGNALS]
        return self

    def __exit__(self, *_: object) -> None:
        """Listen no more."""
        for number, before in zip(_SIGNALS, self._before, strict=True):
            signal.signal(number, before)

    def _hear(self, number: int, frame: FrameType | None) -> None:
        if self.asked:
            raise KeyboardInterrupt
        self.asked = True
        print("ending, with what there is; once more to end at once", file=sys.stderr, flush=True)
