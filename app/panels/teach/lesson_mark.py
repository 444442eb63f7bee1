"""The line over the scene that tells of a lesson; the lesson itself is in a tab of its own."""

from __future__ import annotations

import html

from app.panels.teach.lessons import LessonPanel
from app.panels.widgets import hidden_button
from app.ui.layout import LEARN, Layout
from app.ui.overlay import button


class LessonMark:
    """Lesson, page, and the buttons that lead to it and out of it."""

    def __init__(self, layout: Layout, lessons: LessonPanel) -> None:
        self._lessons = lessons
        self._open = hidden_button(layout.client.gui, "Open the lesson", layout.open_learn)

    @property
    def html(self) -> str:
        """The line as HTML; empty while no lesson is chosen."""
        place = self._lessons.place
        if not place:
            return ""
        opens = button(self._open, "Open lesson", hint=f"Shows its text, in the {LEARN} tab.")
        ends = button(self._lessons.leave, "End lesson", hint="Brings your own scene back.")
        return (
            '<div class="abi-card abi-buttons" style="align-items:center">'
            f"<b>{html.escape(place)}</b>{opens}{ends}</div>"
        )
