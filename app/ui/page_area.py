"""Size of a page, and how much of it panels and text cover."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, TypeAlias

import msgspec
import viser

from app.ui import page
from app.ui.layout import PLOTS, TITLE

_Pixels: TypeAlias = Annotated[float, msgspec.Meta(ge=0, le=100_000)]
_Part: TypeAlias = Annotated[float, msgspec.Meta(ge=0, le=1)]
_USUAL = 12.0
"""Height of the letters of a label of scale 1, [px], in viser."""
_LETTERS = (0.036, 0.03)
"""Height of labels in lecture mode, over the scene's width and height."""
_SMALLEST, _LARGEST = 14.0, 26.0
"""Limits of the height of labels in lecture mode, [px]."""


@dataclass(frozen=True)
class PageArea:
    """Size of a page, and how much of it panels and text cover.

    Attributes:
        width: of the page, [px].
        height: of the scene, [px].
        left: width of what panels take on the left, [px].
        right: the same on the right.
        above: part of the scene's height that text covers from above, 0 to 1.
        below: the same from below.
        hidden: whether nobody sees the page, as behind another tab of the browser.
        plots: whether the tab with the plots has been opened.
    """

    width: _Pixels = 1280.0
    height: _Pixels = 720.0
    left: _Pixels = 0.0
    right: _Pixels = 0.0
    above: _Part = 0.0
    below: _Part = 0.0
    hidden: bool = False
    plots: bool = False

    @property
    def aspect(self) -> float:
        """Aspect ratio of the scene."""
        return (self.width - self.left - self.right) / max(self.height, 1.0)

    @classmethod
    def of(cls, text: object) -> PageArea | None:
        """Parse an area from untrusted text; None if it is invalid."""
        try:
            return msgspec.json.decode(str(text), type=cls, strict=False)
        except (msgspec.MsgspecError, ValueError, RecursionError):
            return None


def label_scale(area: PageArea | None, lecture: bool) -> float:
    """Scale of the labels in the scene; in lecture mode as large as there is room for."""
    if not lecture:
        return 1.0
    area = area or PageArea()
    width = area.width - area.left - area.right
    letters = min(_LETTERS[0] * width, _LETTERS[1] * area.height)
    return round(min(max(letters, _SMALLEST), _LARGEST) / _USUAL, 1)


Area = Callable[[], PageArea | None]
"""The page's area now; None before its first report."""


def watch_area(client: viser.ClientHandle, nudge: Callable[[], None]) -> Area:
    """Add a hidden text box in which the page reports its area whenever that changes.

    A new area is no input: who needs it asks for it. Only plots that come into sight are waited
    for: then ``nudge`` is called.
    """
    box = client.gui.add_text("area", "", visible=False)
    read: object = ""
    known: PageArea | None = None

    def area() -> PageArea | None:
        nonlocal read, known
        if box.value != read:
            read = box.value
            known = PageArea.of(read) or known
        return known

    def hear(_: object) -> None:
        had_plots = shows_plots(known)
        if shows_plots(area()) and not had_plots:
            nudge()

    box.on_update(hear)
    page.call(client, "watch", [page.uuid(box), TITLE, PLOTS])
    return area


def shows_plots(area: PageArea | None) -> bool:
    """Whether the tab with the plots has been opened."""
    return area is not None and area.plots
