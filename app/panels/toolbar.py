"""Buttons over the scene: undo and redo, what this is, the tour, and lecture mode."""

from __future__ import annotations

import viser

from app.panels.files.history import History
from app.panels.teach.lecture import Lecture
from app.panels.widgets import hidden_button
from app.state.frame import Draw, Frame
from app.ui.layout import LEARN, Layout
from app.ui.overlay import button


def toolbar(
    layout: Layout,
    history: History,
    about: viser.GuiButtonHandle,
    tour: viser.GuiButtonHandle,
    lecture: Lecture,
) -> Draw:
    """One row of buttons, which press hidden ones; those that do something now are in full."""
    learn = hidden_button(layout.client.gui, "Open the lessons", layout.open_learn)

    def draw(frame: Frame) -> None:
        # what still moves, be it by the demonstration, is no change yet
        changed = not frame.interactive and frame.plan.scene != history.noted
        hint = "Large letters, folded panels (L)"
        buttons = (
            button(history.undo, "Undo", history.can_undo or changed, hint="Ctrl+Z"),
            button(history.redo, "Redo", history.can_redo, hint="Ctrl+Shift+Z or Ctrl+Y"),
            button(about, "?", hint="What is this?"),
            button(tour, "Tour", hint="Five steps through the page"),
            "" if lecture.on else button(lecture.toggle, "Lecture", hint=hint),
            # for a phone, of whose sheet the tab is far down; elsewhere the row has no room for it
            button(learn, "Lessons", kind="abi-phone", hint=f"In the {LEARN} tab"),
        )
        layout.overlay.show("tools", f'<div class="abi-buttons">{"".join(buttons)}</div>')

    return draw
