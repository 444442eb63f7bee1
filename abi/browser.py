"""The browser of this machine, asked to show a page."""

from __future__ import annotations

import threading
import webbrowser
from pathlib import PurePath

_TEXT = frozenset({"elinks", "links", "links2", "lynx", "w3m", "www-browser"})
"""Browsers that run in the terminal, which they take over; none of them can draw a page of ours."""


def missing_browser() -> str:
    """Sentence on why no page can be shown here; empty where there is a browser that can."""
    try:
        name = PurePath(webbrowser.get().name).name
    except webbrowser.Error:
        return "There is no browser here."
    return f"The browser here, {name}, shows only text." if name in _TEXT else ""


def open_in_background(link: str) -> None:
    """Have the browser open ``link``, and go on: some are not done before they are closed."""
    threading.Thread(target=webbrowser.open, args=(link,), name="browser", daemon=True).start()
