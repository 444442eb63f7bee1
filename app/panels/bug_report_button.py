"""Button that downloads the text of a bug report."""

from __future__ import annotations

import viser

from app.bug_report import bug_report
from app.frame import Frame
from app.panels.widgets import Wake, pressed


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

    def send_if_requested(self, frame: Frame, fault: str | None) -> None:
        """Send the report of :func:`app.bug_report.bug_report` if the button was pressed."""
        if pressed(self.button):
            report = bug_report(frame, fault).encode()
            self._client.send_file_download("abi-bug-report.md", report, save_immediately=True)
