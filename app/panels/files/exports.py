"""Export of the plan as a file for another program: a choice of format, and a button."""

from __future__ import annotations

import viser

from abi.errors import ExportError
from abi.export.formats import FORMATS
from abi.planner.plan import Plan
from app.panels.widgets import Wake, pressed
from app.ui import notices

_LABELS = {row.label: row for row in FORMATS.values()}


class ExportPanel:
    """Widgets to download the plan; the worker asks whether they were used."""

    def __init__(self, client: viser.ClientHandle, wake: Wake) -> None:
        self._client = client
        gui = client.gui
        self.format = gui.add_dropdown(
            "export", tuple(_LABELS), hint="What the file holds, and which program reads it."
        )
        self.button = gui.add_button(
            "Export", color="gray", hint="Downloads the plan in this format."
        )
        self.button.on_click(wake)

    def requested(self) -> bool:
        """Check whether the button was pressed since the last call."""
        return pressed(self.button)

    def send(self, plan: Plan) -> None:
        """Send ``plan`` as a file, or a notice of why there is none."""
        # a page may send anything: only listed formats are written
        row = _LABELS.get(self.format.value)
        if row is None:
            return
        try:
            content = row.write(plan, row.file)
        except ExportError as error:
            notices.notify_refusal(self._client, "Not exported", error.message)
        else:
            self._client.send_file_download(row.file, content, save_immediately=True)
            if warning := row.warning(plan):
                notices.notify_warning(self._client, "Exported, but not proven clear", warning)
            if past := row.limits_warning(plan):
                notices.notify_warning(self._client, "Exported, but past the joints' limits", past)
