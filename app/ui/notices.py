"""Notices on the page: refusals, warnings, and the server's end."""

from __future__ import annotations

from collections.abc import Iterable

import viser


def notify_refusal(client: viser.ClientHandle, title: str, reason: str) -> viser.NotificationHandle:
    """Notify the user of what was refused, and why."""
    return client.add_notification(title, reason, color="red", auto_close_seconds=12)


def notify_refused_file(client: viser.ClientHandle, title: str, reason: str) -> None:
    """Notify the user of a refused file, and why, until the notice is closed."""
    client.add_notification(title, reason, color="red", auto_close_seconds=None)


def notify_warning(client: viser.ClientHandle, title: str, reason: str) -> None:
    """Warn the user of a fault in what was done."""
    client.add_notification(title, reason, color="orange", auto_close_seconds=12)


def notify_missing(client: viser.ClientHandle, files: Iterable[str]) -> None:
    """Notify the user of a link's mesh files that this server does not have."""
    names = ", ".join(files)
    reason = (
        f"{names} was uploaded to another server, or too long ago. Everything else is here. "
        "A scene that is saved as a file has its meshes in it."
    )
    client.add_notification("Without its mesh", reason, color="red", auto_close_seconds=20)


def notify_end(client: viser.ClientHandle) -> None:
    """Notify the user that the server is about to stop."""
    client.add_notification(
        "The server has stopped",
        "This tab keeps its scene. Once the server runs again, the page connects by itself.",
        color="yellow",
        auto_close_seconds=None,
    )
    client.flush()
