"""The line over the scene that tells of a lesson; the lesson itself is in a tab of its own."""

from __future__ import annotations

import html

import viser

from app.panels.teach.lessons import LessonPanel
from app.ui.layout import LEARN
from app.ui.overlay import button


def lesson_mark(lessons: LessonPanel, opening: viser.GuiButtonHandle) -> str:
    """Lesson and page, and buttons that lead to it and out of it, as HTML; empty without one.

    Args:
        lessons: whose lesson it is.
        opening: the button that opens the tab with its text.
    """
    if not lessons.progress.place:
        return ""
    opens = button(opening, "Back to lesson", hint=f"Shows its text, in the {LEARN} tab.")
    ends = button(lessons.leave, "End lesson", hint="Brings your own scene back.")
    return (
        '<div class="abi-card abi-buttons" style="align-items:center">'
        f"<b>{html.escape(lessons.progress.place)}</b>{opens}{ends}</div>"
    )
