"""Sheets of text over the page: what it is, and all keys."""

from __future__ import annotations

from typing import Any

import viser

from app.panels.widgets import Wake, hidden_button, pressed
from app.state.frame import Frame

ABOUT = """
A robot arm is to bring its tool tip from start to goal and touch nothing on the way. The **ABI
method** (A\\* and B-spline Interpolation) plans that in six stages:

1. **Mesh**: the workspace, the box of thin lines, is cut into tetrahedra.
2. **Graph**: the nodes and edges outside every obstacle.
3. **Search**: A\\*, Dijkstra and Bellman-Ford look for the shortest path in it.
4. **B-spline**: a smooth curve along that path, proven to keep its distance.
5. **Quadratic**: a simpler curve, and how fast the tool tip moves along it.
6. **Arm**: how each joint has to turn.

Drag anything, and all six are computed anew. The method is that of the paper *A Hybrid Method for
Constructing Optimal Motion Path for Robot Manipulators While Avoiding Obstacles*; the tab *Learn*
goes through it stage by stage, with what does not hold in it, and has lessons.

*Tour* shows the page in five steps; the key H, all keys.
"""
KEYS = """
| Key | Action |
|---|---|
| Space | play or pause the arm |
| P | play or pause a search that is stepped through |
| N, B | one step of that search forward, one back |
| Ctrl+Z, Ctrl+Y | undo, redo (on a Mac: Cmd instead of Ctrl) |
| W A S D, Q E, arrows | move the camera |
| Ctrl+K | list all commands |
| L | lecture mode: large letters, folded panels |
| Page Down, Page Up | in a lecture: next stage, stage before |
| H or ? | show this sheet; Esc closes it |

Drag with the left mouse button to turn the scene, with the right one to shift it; the wheel zooms.
On a touch screen one finger turns the scene, two shift it and zoom.
Obstacles, start and goal can be dragged directly or by their arrows.

Type plain numbers such as −2.5. Values outside the range shown under the pointer are ignored.
"""


class Sheet:
    """A sheet, and the command and the button that open it.

    Attributes:
        open: button of the toolbar that opens it; hidden itself.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        wake: Wake,
        title: str,
        text: str,
        label: str,
        hotkey: Any = None,  # a key, of which viser lists all
    ) -> None:
        self._gui, self._wake = gui, wake
        self._title, self._text = title, text
        self._asked = False
        self._close: viser.GuiButtonHandle | None = None
        self.sheet: Any = None  # viser has no public name for a modal
        self.open = hidden_button(gui, label, self._ask)
        self.command = gui.add_command(label, hotkey=hotkey)
        self.command.on_trigger(self._ask)

    def draw(self, frame: Frame) -> None:
        """Open the sheet where it was asked for, or close it; no frame changes it."""
        closed = self._close is not None and pressed(self._close)
        if not (self._asked or closed):
            return
        self._asked = False
        if self.sheet is not None:
            self.sheet.close()
            self.sheet = self._close = None
            return
        self.sheet = self._gui.add_modal(self._title)
        with self.sheet:
            self._gui.add_markdown(self._text)
            self._close = self._gui.add_button("Close")
            self._close.on_click(self._wake)

    def _ask(self, event: Any) -> None:
        self._asked = True
        self._wake(event)
