"""Cards with pictures to choose lessons and scenes from."""

from __future__ import annotations

import base64
import functools
import html
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import viser

from app.ui import page


@dataclass(frozen=True)
class Card:
    """One entry of a list.

    Attributes:
        title: its name, to which choosing it sets the widget.
        note: what else is said of it.
        picture: file of its picture, which may be missing.
        chosen: whether it is the one to look at.
    """

    title: str
    note: str
    picture: Path
    chosen: bool = False


def cards(widget: viser.GuiDropdownHandle[str], entries: Iterable[Card], few: bool = False) -> str:
    """HTML of cards that set ``widget``; with ``few`` only some are in view at once."""
    content = "".join(_card(page.uuid(widget), entry) for entry in entries)
    return f'<div class="abi-cards{" abi-few" if few else ""}">{content}</div>'


def _card(uuid: str, card: Card) -> str:
    title = html.escape(card.title)
    return (
        f'<button data-choose="{uuid}" data-value="{title}" aria-label="{title}"'
        f' aria-pressed="{str(card.chosen).lower()}">{_picture(card.picture)}'
        f"<span><b>{title}</b><br>{html.escape(card.note)}</span></button>"
    )


@functools.cache
def _picture(file: Path) -> str:
    """The picture as HTML; empty without one, as for a teacher's own lesson."""
    if not file.is_file():
        return ""
    data = base64.b64encode(file.read_bytes()).decode()
    return f'<img alt="" src="data:image/webp;base64,{data}">'
