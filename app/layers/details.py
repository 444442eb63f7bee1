"""Details that may lag behind a drag while many other tabs need the processor."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from abi import progress
from app.layers.mesh import MeshLayer
from app.state.frame import Drawable, Frame

PAUSE = 0.1
"""Seconds between two drawings for each tab that waits."""
LONGEST = 3.0
"""Seconds between two drawings at the most."""


class Details:
    """Layers that are drawn with every frame unless a crowd waits, and always once the hand rests.

    In a crowd a drag begins without them: thirty hands wait for the first answer to each.

    Once something else has been chosen than what is drawn, they wait for the frame of that.

    Attributes:
        parts: the layers, in the order in which they are drawn.
    """

    def __init__(
        self,
        parts: Iterable[Drawable],
        waiting: Callable[[], int],
        overtaken: Callable[[], bool],
    ) -> None:
        """Begin with nothing drawn.

        Args:
            parts: the layers.
            waiting: how many other tabs wait for their turn.
            overtaken: whether something else has been chosen.
        """
        self.parts = tuple(parts)
        self._waiting, self._overtaken = waiting, overtaken
        self._drawn = -LONGEST
        self._rested = False
        self._shown: tuple[object, ...] = ()

    def draw(self, frame: Frame) -> None:
        """Draw all parts, or none while their last picture will do for another moment."""
        shown = frame.shown, frame.mesh_view, frame.refused
        pause = min(PAUSE * self._waiting(), LONGEST)
        waits = frame.interactive and shown == self._shown
        if waits and self._rested:
            self._drawn = time.monotonic()
        self._rested = not frame.interactive
        if waits and time.monotonic() - self._drawn < pause:
            return
        self._drawn, self._shown = time.monotonic(), shown
        try:
            for part in self.parts:
                if self._overtaken():
                    raise progress.CancelledError
                self._draw(part, frame)
        except progress.CancelledError:
            self._drawn = -LONGEST

    def _draw(self, part: Drawable, frame: Frame) -> None:
        """Draw a part; that of a fine mesh takes so long that it is ended in the midst of it."""
        if not isinstance(part, MeshLayer):
            part.draw(frame)
            return
        with progress.watched_by(self._overtaken):
            part.draw(frame)
