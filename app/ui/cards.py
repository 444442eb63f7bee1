"""Cards with pictures to choose lessons and scenes from."""

from __future__ import annotations

import base64
import functools
import html
from collections.abc import Iterable
from pathlib import Path

import viser

from app.ui import page


def cards(entries: Iterable[str], few: bool = False) -> str:
    """HTML of a list of cards; with ``few`` only some are in view at once."""
    return f'<div class="abi-cards{" abi-few" if few else ""}">{"".join(entries)}</div>'


def card(
    widget: viser.GuiDropdownHandle[str],
    title: str,
    note: str,
    picture: Path,
    chosen: bool = False,
) -> str:
    """HTML of a card that sets ``widget``.

    Args:
        widget: which is set to the title of the card that is chosen.
        title: its name.
        note: what else is said of it.
        picture: file of its picture, which may be missing.
        chosen: whether it is the one to look at.
    """
    title = html.escape(title)
    return (
        f'<button data-choose="{page.uuid(widget)}" data-value="{title}" aria-label="{title}"'
        f' aria-pressed="{str(chosen).lower()}">{_picture(picture)}'
        f"<span><b>{title}</b><br>{html.escape(note)}</span></button>"
    )


@functools.cache
def _picture(file: Path) -> str:
    """The picture as HTML; empty without one, as for a teacher's own lesson."""
    if not file.is_file():
        return ""
    data = base64.b64encode(file.read_bytes()).decode()
    return f'<img alt="" src="data:image/webp;base64,{data}">'
