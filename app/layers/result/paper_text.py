"""The paper's method and misprints as text in the Learn tab, hidden while a lesson runs."""

from __future__ import annotations

import functools

from abi import assets
from app.state.frame import Frame, Layer
from app.ui.formulas import with_formulas
from app.ui.layout import Layout


class PaperTextLayer(Layer):
    """Text in the Learn tab, sent after the first picture, which it would delay."""

    def __init__(self, layout: Layout) -> None:
        with layout.learn:
            self._text = layout.client.gui.add_markdown("")

    def draw(self, frame: Frame) -> None:
        """Write the text; show it but while a lesson is gone through."""
        if not self._text.content:
            self._text.content = paper_text()
        self._text.visible = not frame.lesson


@functools.cache
def paper_text() -> str:
    """The paper's method as Markdown, its formulas as MathML."""
    return with_formulas(assets.path("lessons", "paper.md").read_text(encoding="utf-8"))
