"""Bug report: versions, the scene, the plan's times, and what went wrong, as a text to download."""

from __future__ import annotations

import traceback
from pathlib import Path

import viser

from abi.errors import AbiError
from abi.scene.scene_file import dump
from app.panels.widgets import Wake
from app.process.versions import version_text
from app.state.frame import Frame
from app.ui import notices

_ROOT = Path(__file__).parents[3]


def add_bug_report_button(gui: viser.GuiApi, wake: Wake) -> viser.GuiButtonHandle:
    """Add the button; the worker asks whether it was pressed."""
    button = gui.add_button(
        "Text for a bug report",
        color="gray",
        hint="Downloads versions, scene and times as a text; nothing is sent anywhere.",
    )
    button.on_click(wake)
    return button


def send_bug_report(client: viser.ClientHandle, frame: Frame, fault: str | None) -> None:
    """Send the report of :func:`bug_report` to a tab, as a file."""
    report = bug_report(frame, fault).encode()
    client.send_file_download("abi-bug-report.md", report, save_immediately=True)


def bug_report(frame: Frame, fault: str | None) -> str:
    """The report, as Markdown.

    Args:
        frame: what the tab shows.
        fault: the last fault that the tab met, by :func:`describe_fault`; None for none.
    """
    plan = frame.plan
    times = [f"{name:<16}{ms:10.2f} ms" for name, ms in plan.ms.items() if ms > 0]
    failure = frame.refused or plan.error
    try:
        scene = dump(plan.scene.to_dict(), "scene.yaml")
    except AbiError as error:
        scene = str(error)
    parts = (
        ("What did you do, and what did you see?", ""),
        ("Versions", version_text()),
        ("Message", "none" if failure is None else str(failure)),
        ("Fault", fault or "none"),
        ("Times", "\n".join((*times, f"{'in all':<16}{plan.total_ms:10.2f} ms"))),
        ("Scene", scene.strip()),
    )
    return "\n".join(f"## {title}\n\n```\n{text}\n```\n" for title, text in parts)


def describe_fault(error: Exception) -> str:
    """Kind of a fault and where it arose; paths only below the project's folder."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if _is_own(Path(frame.filename))]
    places = [
        f"{Path(frame.filename).relative_to(_ROOT)}:{frame.lineno} in {frame.name}"
        for frame in own
        if "site-packages" not in frame.filename or len(own) == len(frames)
    ]
    return "\n".join((f"{type(error).__name__}: {error}"[:500], *places[-12:]))


def notify_fault(client: viser.ClientHandle, error: Exception) -> None:
    """Notify the user of a fault, after which the last picture stays."""
    words = (
        "There was not enough memory for this; a coarser mesh takes less."
        if isinstance(error, MemoryError)
        else "The visualiser met a fault of its own. The Scene tab has a text for a bug report."
    )
    notices.notify_refusal(client, "This did not work", f"{words} The last picture stays.")


def _is_own(file: Path) -> bool:
    """Check whether a file is the project's; its folder may hold the libraries, too."""
    return file.is_relative_to(_ROOT) and "site-packages" not in file.relative_to(_ROOT).parts
