"""Text and controls over the scene; elsewhere the mouse reaches the scene."""

from __future__ import annotations

import html
from typing import Literal

import viser

from app.ui import page
from app.ui.numbers import unbroken

Part = Literal[
    "message",
    "tools",
    "contact",
    "tour",
    "challenge",
    "class",
    "lecture",
    "numbers",
    "player",
    "marks",
]


class Overlay:
    """The parts of the layer over the scene, of which only changes are sent.

    Attributes:
        shown: HTML of each part.
    """

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self.shown: dict[str, str] = {}
        self._clock = (-1.0, 0.0, False, 0.0)

    def show(self, part: Part, content: str) -> None:
        """Show HTML in a part; user input in it must be escaped."""
        if self.shown.get(part, "") != content:
            self.shown[part] = content
            page.call(self._client, "show", part, unbroken(content))

    def set_clock(self, time: float, end: float, playing: bool, before: float = 0.0) -> None:
        """Show a time and the end of all, [s], in the player; ``before`` it the motion begins."""
        clock = round(time, 2), round(end, 2), playing, round(before, 3)
        # while it plays the page counts by itself
        if clock != self._clock and not (playing and clock[1:] == self._clock[1:]):
            self._clock = clock
            page.call(self._client, "clock", *clock)


def button(
    widget: viser.GuiButtonHandle,
    label: str,
    enabled: bool = True,
    kind: str = "",
    hint: str = "",
) -> str:
    """HTML of a button that presses a hidden ``widget``; the hint of an icon is its accessible
    name."""
    title = f' title="{html.escape(hint)}"' if hint else ""
    spoken = f' aria-label="{html.escape(hint)}"' if len(label) == 1 else ""
    return (
        f'<button class="{kind}" data-press="{page.uuid(widget)}"{title}{spoken}'
        f"{'' if enabled else ' disabled'}>{html.escape(label)}</button>"
    )


def slider(widget: viser.GuiSliderHandle[float], label: str) -> str:
    """HTML of a slider from 0 that sets a hidden ``widget``."""
    return (
        '<span class="abi-track"><input type="range" min="0" max="1" step="0.01" value="0" '
        f'aria-label="{html.escape(label)}" data-set="{page.uuid(widget)}"></span>'
    )
