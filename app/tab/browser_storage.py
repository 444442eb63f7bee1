"""Browser storage of a tab: what the page reports when it opens, and what it stores."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, field, replace
from typing import Annotated

import msgspec
import viser

from app.panels.widgets import Wake
from app.shared import mesh_store
from app.state.tab_state import MAX_PROGRESS, TabState, encoder
from app.ui import page

TIMEOUT = 0.7
"""Seconds that the first plan waits for the report; a later report is still used."""
_PERIOD = 0.4
"""Seconds between two texts sent to the page."""


@dataclass(frozen=True)
class Report:
    """Startup report from the browser.

    Attributes:
        state: a :class:`TabState` as text; empty for none.
        oversize: letters of one that is too long to be sent; 0 for none.
        student: a name that the browser made up, the same in all of its tabs; empty for none.
        query: parameters of its address.
        lessons: progress in the lessons that the browser keeps, whatever the tab.
        dark: whether the system prefers dark pages.
        software: whether the browser draws without a graphics card.
    """

    state: str = ""
    oversize: int = 0
    student: Annotated[str, msgspec.Meta(max_length=64)] = ""
    query: dict[str, str] = field(default_factory=dict)
    lessons: str = ""
    dark: bool = False
    software: bool = False


class TabStorage:
    """Hidden text box through which the page reports."""

    def __init__(self, client: viser.ClientHandle, wake: Wake) -> None:
        self._client = client
        self._box = client.gui.add_text("report", "", visible=False)
        self._arrived = threading.Event()
        self._wake = wake
        self._read = ""
        self._kept: TabState | None = None
        self._encode = encoder()
        self._sent = -_PERIOD
        self._scene: object = None
        self._lessons = ""
        self._box.on_update(self._receive)
        page.call(client, "report", page.uuid(self._box))

    def wait(self) -> None:
        """Wait for the report, up to ``TIMEOUT``."""
        self._arrived.wait(TIMEOUT)

    def report(self) -> Report | None:
        """The report, once; None before and after."""
        text = self._box.value
        if text == self._read:
            return None
        self._read = text
        return _parse(text)

    @property
    def is_due(self) -> bool:
        """Whether the page has reported and may be sent another text."""
        return bool(self._read) and time.monotonic() - self._sent >= _PERIOD

    def keep(self, state: TabState, now: bool = False) -> None:
        """Store ``state`` in the page if it changed; not too often, unless ``now``.

        Not before the page's report has been read: until then it may remember more than is shown.
        """
        kept = replace(state, playing=True, missing=())
        if not self._read or kept == self._kept or not (now or self.is_due):
            return
        self._kept, self._sent = kept, time.monotonic()
        if state.scene is not self._scene:
            self._scene = state.scene
            mesh_store.keep(state.scene.meshes.files)
        page.call(self._client, "remember", self._encode(state))
        if state.lessons != self._lessons:
            self._lessons = state.lessons
            page.call(self._client, "rememberLessons", state.lessons)

    def _receive(self, event: object) -> None:
        self._arrived.set()
        self._wake(event)


def _parse(text: object) -> Report:
    """Parse a report from untrusted text."""
    try:
        report = msgspec.json.decode(str(text), type=Report)
    except (msgspec.MsgspecError, ValueError, RecursionError):
        return Report()
    return replace(report, lessons=report.lessons[:MAX_PROGRESS])
