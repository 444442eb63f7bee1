"""Button that downloads the text of a bug report."""

from __future__ import annotations

import viser

from app.panels.widgets import Wake


class BugReportButton:
    """The button; the worker asks whether it was pressed."""

    def __init__(self, client: viser.ClientHandle, wake: Wake) -> None:
        self._client = client
        self.button = client.gui.add_button(
            "Text for a bug report",
            color="gray",
            hint="Downloads versions, scene and times as a text; nothing is sent anywhere.",
        )
        self.button.on_click(wake)

    @property
    def requested(self) -> bool:
        """Whether the button was pressed since the last :meth:`send`."""
        return self.button.value

    def send(self, text: str) -> None:
        """Send the text as a file."""
        self.button.value = False
        self._client.send_file_download("abi-bug-report.md", text.encode(), save_immediately=True)
