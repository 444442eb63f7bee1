"""The paper: buttons for its figures, its numbers beside ours, and its method as text."""

from __future__ import annotations

import functools
import html
import re
from typing import Any

import viser

from abi import assets
from abi.scene.scene import Scene
from app.panels.widgets import Wake, pressed
from app.state.frame import Frame
from app.teach.figures import figures
from app.teach.lesson import Setting, scene_of
from app.ui import style
from app.ui.formulas import with_formulas
from app.ui.table import table

_SIGNS = {"holds": "✓", "depends on the mesh": "≈", "does not hold": "✗"}
_MINUS = re.compile(r"(?<!\w)-(?=\d)")
"""Sign of a number, not the dash in a range or a word, nor an exponent's."""


class FiguresPanel:
    """Nine buttons, a caption, a button for the table, and the text, which a lesson hides.

    Attributes:
        number: of the figure shown, from 1; 0 for none.
        method: the text.
    """

    def __init__(self, gui: viser.GuiApi, wake: Wake) -> None:
        self._wake = wake
        self._pressed: int | None = None
        self.number = 0
        self._folder = gui.add_folder("The paper's figures", expand_by_default=False)
        with self._folder:
            numbers = [str(number) for number in range(1, len(figures()) + 1)]
            self.buttons = (
                gui.add_button_group("figure", numbers[:5]),
                gui.add_button_group(" ", numbers[5:]),
            )
            self._caption = gui.add_html("", visible=False)
            self.back = gui.add_button(
                "Back to my scene",
                visible=False,
                color="gray",
                hint="As it was before the figures.",
            )
            self.reproduce = gui.add_button(
                "The paper's numbers beside ours",
                hint="Computes all of them again; takes some seconds.",
            )
            self._text = gui.add_html("", visible=False)
        self.method = gui.add_markdown("")
        self._drawn = False
        for group in self.buttons:
            group.on_click(self._press)
        self.back.on_click(wake)
        self.reproduce.on_click(wake)

    def cue(self, scene: Scene) -> tuple[Setting, Scene] | None:
        """Setting and scene of the figure asked for since the last call; None for none."""
        if self._pressed is None:
            return None
        number, self._pressed = self._pressed, None
        figure = figures()[number]
        self.restore(number + 1)
        return figure.set, scene_of(figure.set, scene, assets.path("scenes"))

    def left(self) -> bool:
        """Check whether the figures were left since the last call."""
        return pressed(self.back)

    def restore(self, number: int) -> None:
        """Show the caption of a figure, and the way back; ignore a number that there is not."""
        if not 1 <= number <= len(figures()):
            return
        self.number = number
        caption = html.escape(figures()[number - 1].text)
        self._caption.content = style.paragraph(f"<b>Fig. {number}.</b> {caption}")
        self._caption.visible = self.back.visible = True
        self._folder.expand_by_default = True  # in a new page, or the way back is not seen

    def close(self) -> None:
        """Show no caption, since no figure is shown."""
        self.number = 0
        self._caption.visible = self.back.visible = False

    def draw(self, frame: Frame) -> None:
        """Compute the table if its button was pressed; hide while a lesson is gone through."""
        self._folder.visible = self.method.visible = not frame.lesson
        # it would delay the first picture, and the first that answers a hand
        waits = not self._drawn or (frame.interactive and not frame.demonstrates)
        self._drawn = True
        if not (waits or self.method.content):
            self.method.content = paper_text()
        if pressed(self.reproduce):
            self._text.content = _table()
            self._text.visible = True

    def _press(self, event: Any) -> None:
        if event.target.value.isdigit():
            self._pressed = int(event.target.value) - 1
        self._wake(event)


@functools.cache
def _table() -> str:
    """The paper's statements beside what we find, as HTML."""
    from abi.explain.paper.reproduction import compare

    rows = [
        (*map(_wrapped, (row.subject, row.printed, row.ours)), _SIGNS[row.verdict])
        for row in compare()
    ]
    signs = ", ".join(f"{sign} {verdict}" for verdict, sign in _SIGNS.items())
    return f'<div style="zoom:.82">{table(("what", "printed", "ours", ""), rows, signs)}</div>'


@functools.cache
def paper_text() -> str:
    """The paper's method and misprints as Markdown, its formulas as MathML."""
    return with_formulas(assets.path("lessons", "paper.md").read_text(encoding="utf-8"))


def _wrapped(text: str) -> str:
    text = _MINUS.sub("−", text)
    return f'<span style="white-space:normal">{html.escape(text)}</span>'
