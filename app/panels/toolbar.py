"""Buttons over the scene: undo and redo, what this is, the tour, and lecture mode."""

from __future__ import annotations

from app.panels.files.history import History
from app.panels.teach.lecture import Lecture
from app.panels.teach.sheet import Sheet
from app.panels.teach.tour import Tour
from app.panels.widgets import hidden_button
from app.state.frame import Frame
from app.ui.layout import LEARN, Layout
from app.ui.overlay import button


class Toolbar:
    """One row of buttons, which press hidden ones."""

    def __init__(
        self, layout: Layout, history: History, about: Sheet, tour: Tour, lecture: Lecture
    ) -> None:
        self._about, self._tour, self._lecture = about, tour, lecture
        self._overlay = layout.overlay
        self._history = history
        self._learn = hidden_button(layout.client.gui, "Open the lessons", layout.open_learn)

    def draw(self, frame: Frame) -> None:
        """Show the buttons, those that do something now in full."""
        history = self._history
        # what still moves, be it by the demonstration, is no change yet
        changed = not frame.interactive and frame.plan.scene != history.noted
        undo = button(history.undo, "Undo", history.can_undo or changed, hint="Ctrl+Z")
        redo = button(history.redo, "Redo", history.can_redo, hint="Ctrl+Shift+Z or Ctrl+Y")
        about = button(self._about.open, "?", hint="What is this?")
        tour = button(self._tour.begin, "Tour", hint="Five steps through the page")
        hint = "Large letters, folded panels (L)"
        lecture = "" if self._lecture.on else button(self._lecture.toggle, "Lecture", hint=hint)
        # of a phone's sheet the tab is far down; elsewhere the row has to fit beside the message
        learn = button(self._learn, "Lessons", kind="abi-phone", hint=f"In the {LEARN} tab")
        content = f'<div class="abi-buttons">{undo}{redo}{about}{tour}{lecture}{learn}</div>'
        self._overlay.show("tools", content)
