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


def open_in_background(link: str) -> threading.Thread:
    """Open ``link`` in the browser in a thread, as some return only when they are closed.

    No other is tried where it fails: the next one may be a text browser, which takes the terminal.
    """
    chosen = webbrowser.get()
    thread = threading.Thread(target=chosen.open, args=(link,), name="browser", daemon=True)
    thread.start()
    return thread
