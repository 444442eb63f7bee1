"""Folding of a panel in lecture mode and on narrow pages."""

from __future__ import annotations

import viser

from app.ui.page_area import PageArea

PHONE = 600
"""Page width, [px], below which viser turns the panels into one sheet, which the page folds."""
NARROW = 1000
"""Page width, [px], below which both panels would leave the scene little room."""
_RAIL = 60
"""Width, [px], below which a panel counts as folded."""


class PanelFolding:
    """Folds a panel that would be in the way, and re-expands it unless the user has toggled it."""

    def __init__(self, panel: viser.MainPanelHandle | viser.PanelHandle, is_left: bool) -> None:
        """Begin with an open panel, on the left or on the right."""
        self._panel, self._is_left = panel, is_left
        self._lecture = self._narrow = self._phone = False
        self._open = True
        self._begun = self._ours = self._seen = False

    def update(self, area: PageArea | None, lecture: bool) -> None:
        """Fold or unfold when lecture mode begins or ends or the page's width passes a limit."""
        phone = self._phone if area is None else area.width < PHONE
        narrow = self._narrow if area is None else area.width < NARROW and not phone
        if area is not None and not phone and not self._phone:
            self._look((area.left if self._is_left else area.right) < _RAIL)
        if (lecture and not self._lecture) or (narrow and not self._narrow):
            self._fold()
        elif not (lecture or narrow or phone):
            self._unfold()
        self._lecture, self._narrow, self._phone = lecture, narrow, phone

    def _look(self, folded: bool) -> None:
        """Update from the page; a panel that we folded and that is open was opened by the user."""
        self._begun |= not folded
        if not self._begun:
            return  # a new page has no panels yet
        self._open = not folded
        self._seen |= folded
        if self._ours and self._seen and self._open:
            self._ours = False

    def _fold(self) -> None:
        """Fold the panel unless it is folded."""
        if self._open:
            self._panel.minimize()
            # the page shows it open until it has done so
            self._open, self._ours, self._seen, self._begun = False, True, False, True

    def _unfold(self) -> None:
        """Unfold the panel if we folded it."""
        if self._ours:
            self._panel.expand()
            self._open, self._ours = True, False
