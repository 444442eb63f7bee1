"""Folding of a panel in lecture mode and on narrow pages."""

from __future__ import annotations

from collections.abc import Callable

import viser

from app.ui.page_area import PageArea

PHONE = 600
"""Page width, [px], below which viser turns the panels into one sheet, which the page folds."""
NARROW = 1000
"""Page width, [px], below which both panels would leave the scene little room."""
_RAIL = 60
"""Width, [px], below which a panel counts as folded."""


def folding(
    panel: viser.MainPanelHandle | viser.PanelHandle, is_left: bool
) -> Callable[[PageArea | None, bool], None]:
    """Fold a panel that would be in the way, and re-expand it unless the user has toggled it.

    Args:
        panel: which is open.
        is_left: whether it is on the left.

    Returns:
        Folds or unfolds it when lecture mode begins or ends or the page's width passes a limit:
        told of the page's area, None where that is not known, and whether the mode is on.
    """
    lecture = narrow = phone = False
    is_open, ours = True, False  # whether it is open, and whether we have folded it
    begun = seen = False  # whether the page has shown it, and then folded

    def update(area: PageArea | None, lectures: bool) -> None:
        nonlocal lecture, narrow, phone, is_open, ours, begun, seen
        was_lecture, was_narrow, was_phone = lecture, narrow, phone
        lecture = lectures
        if area is not None:
            phone = area.width < PHONE
            narrow = area.width < NARROW and not phone
        if area is not None and not phone and not was_phone:
            folded = (area.left if is_left else area.right) < _RAIL
            begun |= not folded
            if begun:  # a new page has no panels yet
                is_open = not folded
                seen |= folded
                # one that we folded and that is open was opened by the user
                ours = ours and not (seen and is_open)
        if (lecture and not was_lecture) or (narrow and not was_narrow):
            if is_open:
                panel.minimize()
                # the page shows it open until it has done so
                is_open, ours, seen, begun = False, True, False, True
        elif ours and not (lecture or narrow or phone):
            panel.expand()
            is_open, ours = True, False

    return update
