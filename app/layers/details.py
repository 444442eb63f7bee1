"""Details that may lag behind a drag while many other tabs need the processor."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from abi import progress
from app.layers.mesh import MeshLayer
from app.state.frame import Draw, Frame

PAUSE = 0.1
"""Seconds between two drawings for each tab that waits."""
LONGEST = 3.0
"""Seconds between two drawings at the most."""


def lagging(
    parts: Sequence[Draw], waiting: Callable[[], int], overtaken: Callable[[], bool]
) -> Draw:
    """Draw parts with every frame unless a crowd waits, and always once the hand rests.

    In a crowd a drag begins without them: thirty hands wait for the first answer to each.

    Once something else has been chosen than what is drawn, they wait for the frame of that.

    Args:
        parts: in the order in which they are drawn.
        waiting: how many other tabs wait for their turn.
        overtaken: whether something else has been chosen.
    """
    drawn, rested = -LONGEST, False
    shown: tuple[object, ...] = ()

    def draw(frame: Frame) -> None:
        nonlocal drawn, rested, shown
        before, shown = shown, (frame.shown, frame.mesh_view, frame.refused)
        waits = frame.interactive and shown == before
        if waits and rested:
            drawn = time.monotonic()
        rested = not frame.interactive
        if waits and time.monotonic() - drawn < min(PAUSE * waiting(), LONGEST):
            return
        drawn = time.monotonic()
        try:
            for part in parts:
                if overtaken():
                    raise progress.CancelledError
                if isinstance(part, MeshLayer):  # a fine one takes so long that it is ended midway
                    with progress.watched_by(overtaken):
                        part(frame)
                else:
                    part(frame)
        except progress.CancelledError:
            drawn = -LONGEST

    return draw
