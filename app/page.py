"""Access to the few parts of the page that viser 1.1.1 has no public name for."""

from __future__ import annotations

from collections.abc import Iterable

import viser
from viser import _messages

from app.style import Colour, css

assert viser.__version__ == "1.1.1", "app/page.py uses private names of viser 1.1.1"


def set_title(client: viser.ClientHandle, title: str) -> None:
    """Name the browser tab. ``title`` must be our own text: it is part of a script."""
    assert title.isprintable()
    assert not set(title) & set("'\\<>")
    client._websock_connection.queue_message(
        _messages.RunJavascriptMessage(source=f"document.title = '{title}'")
    )


def notify_refusal(client: viser.ClientHandle, title: str, reason: str) -> None:
    """Notify the user of what was not done, and why."""
    client.add_notification(title, reason, color="red", auto_close_seconds=12)


def swatch_style(colours: Iterable[tuple[viser.GuiCheckboxHandle, Colour]]) -> str:
    """Style sheet that puts a line of its colour before each checkbox's label."""
    rules = [
        f'label[for="{handle._impl.uuid}"]::before{{content:"";display:inline-block;width:14px;'
        f"height:4px;margin-right:7px;vertical-align:middle;background:{css(colour)}}}"
        for handle, colour in colours
    ]
    return f"<style>{''.join(rules)}</style>"


def disable_sharing(server: viser.ViserServer) -> None:
    """Remove the public tunnel that any visitor of a stock viser page may open."""
    handlers = server._websock_server._incoming_handlers
    for message in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        handlers.pop(message, None)
