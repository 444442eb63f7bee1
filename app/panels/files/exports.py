"""Export of the plan as a file for another program: a choice of format, and a button."""

from __future__ import annotations

import viser

from abi.errors import AbiError
from abi.export.formats import FORMATS
from abi.planner.plan import Plan
from app.panels.widgets import Wake
from app.ui import notices

_LABELS = {row.label: row for row in FORMATS.values()}


def add_export(
    gui: viser.GuiApi, wake: Wake
) -> tuple[viser.GuiDropdownHandle[str], viser.GuiButtonHandle]:
    """Add the choice of a format, and the button to download the plan in it."""
    choice = gui.add_dropdown(
        "export", tuple(_LABELS), hint="What the file holds, and which program reads it."
    )
    button = gui.add_button("Export", color="gray", hint="Downloads the plan in this format.")
    button.on_click(wake)
    return choice, button


def send_plan(client: viser.ClientHandle, label: str, plan: Plan) -> None:
    """Send a plan in the format of a label as a file, or a notice of why there is none."""
    # a page may send anything: only listed formats are written
    row = _LABELS.get(label)
    if row is None:
        return
    try:
        content = row.write(plan, row.file)
    except AbiError as error:
        notices.notify_refusal(client, "Not exported", error.message)
    else:
        client.send_file_download(row.file, content, save_immediately=True)
        if warning := row.warning(plan):
            notices.notify_warning(client, "Exported, but not proven clear", warning)
        if past := row.limits_warning(plan):
            notices.notify_warning(client, "Exported, but past the joints' limits", past)
