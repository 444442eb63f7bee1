"""Files that the page itself refuses: unreadable ones, and those that the server would refuse."""

from __future__ import annotations

import json
from functools import partial

import viser

from app.guard.messages import MAX_UPLOAD
from app.panels.files.file_uploads import shown_name
from app.ui import notices, page

_REASONS = {
    "kind": "This button takes {kinds}.",
    "size": f"It is larger than {MAX_UPLOAD // 1_000_000} MB.",
    "unreadable": "The browser could not read it. Choose it again.",
}
_KINDS = 100
"""Most characters of a list of accepted kinds that are shown."""


def hear_of_refused_files(client: viser.ClientHandle) -> None:
    """Add a hidden text box in which the page reports which file it does not send, and why.

    No input: what is typed is told at once.
    """
    box = client.gui.add_text("refused", "", visible=False)
    box.on_update(partial(_tell, client))
    page.call(client, "hearFiles", page.uuid(box), MAX_UPLOAD)


def _tell(client: viser.ClientHandle, event: viser.GuiEvent[viser.GuiTextHandle]) -> None:
    refused = refusal(event.target.value)
    if refused is not None:
        notices.notify_refusal(client, *refused, stays=True)


def refusal(text: object) -> tuple[str, str] | None:
    """Title and reason parsed from untrusted text; None if it is invalid."""
    try:
        data = json.loads(str(text))
        name, reason = shown_name(str(data["name"])), _REASONS[data["why"]]
        kinds = ", ".join(str(data["kinds"])[:_KINDS].split(","))
    except (ValueError, TypeError, KeyError, RecursionError):
        return None
    return f"{name} is not sent", reason.format(kinds=kinds)
