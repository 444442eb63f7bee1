"""Opening of pages in this machine's browser."""

from __future__ import annotations

import threading
import webbrowser
from pathlib import PurePath

_TEXT = frozenset({"elinks", "links", "links2", "lynx", "w3m", "www-browser"})
"""Text browsers, which take over the terminal and cannot draw our pages."""


def missing_browser() -> str:
    """Sentence on why no page can be shown here; empty if there is a browser that can."""
    try:
        name = PurePath(webbrowser.get().name).name
    except webbrowser.Error:
        return "There is no browser here."
    return f"The browser here, {name}, shows only text." if name in _TEXT else ""


def open_in_background(link: str) -> None:
    """Open ``link`` in the browser without waiting, as some return only when they are closed."""
    threading.Thread(target=webbrowser.open, args=(link,), name="browser", daemon=True).start()
