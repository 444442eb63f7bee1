"""Sheet of all keys, over the page."""

from __future__ import annotations

from typing import Any

import viser

from app.frame import Frame
from app.panels.widgets import Wake

_SHEET = """
| Key | does |
|---|---|
| Space | plays or pauses the arm |
| P | plays or pauses the search |
| N, B | one step of the search forward, back |
| Ctrl+Z, Ctrl+Y | undoes, redoes |
| W A S D, Q E, arrows | move the camera |
| Ctrl+K | lists all commands |
| L | lecture mode: large letters, folded panels |
| H or ? | shows this sheet; Esc closes it |

The mouse turns the scene, its wheel zooms, its right button shifts. Obstacles, start and goal are
dragged by their arrows or their bodies.
"""


class KeysPanel:
    """A command, and the sheet that it opens."""

    def __init__(self, gui: viser.GuiApi, wake: Wake) -> None:
        self._gui, self._wake = gui, wake
        self._asked = False
        self._close: Any = None  # viser declares a button's value read-only
        self.sheet: Any = None  # viser has no public name for a modal
        self.command = gui.add_command("Show the keys", hotkey="H")
        self.command.on_trigger(self._ask)

    def draw(self, frame: Frame) -> None:
        """Open the sheet where it was asked for, or close it; no frame changes it."""
        closed = self._close is not None and self._close.value
        if not (self._asked or closed):
            return
        self._asked = False
        if self.sheet is not None:
            self.sheet.close()
            self.sheet = self._close = None
            return
        self.sheet = self._gui.add_modal("Keys")
        with self.sheet:
            self._gui.add_markdown(_SHEET)
            self._close = self._gui.add_button("Close")
            self._close.on_click(self._wake)

    def _ask(self, event: Any) -> None:
        self._asked = True
        self._wake(event)
