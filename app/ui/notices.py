"""Notices on the page: refusals, warnings, and the server's end."""

from __future__ import annotations

from collections.abc import Iterable

import viser

_SECONDS = 12.0
"""How long a notice is there that does not stay, [s]."""


def notify_refusal(
    client: viser.ClientHandle, title: str, reason: str, *, stays: bool = False
) -> viser.NotificationHandle:
    """Notify the user of what was refused, and why.

    Args:
        client: whose tab it is.
        title: what was refused.
        reason: why.
        stays: until the notice is closed, as what is told of files and of links: one who waits for
            these, or whose page is still being drawn, would miss it.
    """
    seconds = None if stays else _SECONDS
    return client.add_notification(title, reason, color="red", auto_close_seconds=seconds)


def notify_warning(
    client: viser.ClientHandle, title: str, reason: str, *, stays: bool = False
) -> None:
    """Warn the user of a fault in what was done; arguments as for :func:`notify_refusal`."""
    seconds = None if stays else _SECONDS
    client.add_notification(title, reason, color="orange", auto_close_seconds=seconds)


def notify_missing(client: viser.ClientHandle, files: Iterable[str]) -> None:
    """Notify the user of a link's mesh files that this server does not have."""
    names = ", ".join(files)
    reason = (
        f"{names} was uploaded to another server, or too long ago. Everything else is here. "
        "A scene that is saved as a file has its meshes in it."
    )
    client.add_notification("Without its mesh", reason, color="red", auto_close_seconds=None)


def notify_end(client: viser.ClientHandle) -> None:
    """Notify the user that the server is about to stop."""
    client.add_notification(
        "The server has stopped",
        "This tab keeps its scene. Once the server runs again, the page connects by itself.",
        color="yellow",
        auto_close_seconds=None,
    )
    client.flush()
