"""Buttons over the scene."""

from __future__ import annotations

from app.frame import Frame
from app.layout import Layout
from app.overlay import button
from app.panels.history import History


class Toolbar:
    """Undo and redo."""

    def __init__(self, layout: Layout, history: History) -> None:
        self._overlay = layout.overlay
        self._history = history

    def draw(self, frame: Frame) -> None:
        """Show the buttons, those that do something now in full."""
        history = self._history
        changed = frame.plan.scene != history.noted
        undo = button(history.undo, "Undo", history.can_undo or changed, hint="Ctrl+Z")
        redo = button(history.redo, "Redo", history.can_redo, hint="Ctrl+Shift+Z or Ctrl+Y")
        self._overlay.show("tools", f'<div class="abi-buttons">{undo}{redo}</div>')
