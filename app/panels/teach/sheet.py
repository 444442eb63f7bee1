"""Sheets of text over the page: what it is, and all keys."""

from __future__ import annotations

from typing import Any

import viser

from app.panels.widgets import Wake, pressed
from app.state.frame import Draw, Frame

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


def sheet(
    gui: viser.GuiApi,
    wake: Wake,
    opening: viser.GuiButtonHandle,
    title: str,
    text: str,
    hotkey: Any = None,  # a key, of which viser lists all
) -> Draw:
    """A sheet, which the button ``opening``, or a command of its label, opens and closes."""
    asked = False
    shown: Any = None  # viser has no public name for a modal
    closing: viser.GuiButtonHandle | None = None

    def ask(event: Any) -> None:
        nonlocal asked
        asked = True
        wake(event)

    def draw(_: Frame) -> None:
        nonlocal asked, shown, closing
        pressed_now = [pressed(one) for one in (opening, closing) if one is not None]
        if not (asked or any(pressed_now)):
            return
        asked = False
        if shown is not None:
            shown.close()
            shown = closing = None
            return
        shown = gui.add_modal(title)
        with shown:
            gui.add_markdown(text)
            closing = gui.add_button("Close")
            closing.on_click(wake)

    gui.add_command(str(opening.label), hotkey=hotkey).on_trigger(ask)
    return draw
