"""Files on their way into a tab: read beside the planning, one at a time.

The tab's worker asks what became of them. A thread of its own has each file read in a process for
files from outside, and prepares what came of it, so that the hand goes on meanwhile; it can be told
to let a file be. Where a file has several robots or trajectories, one is chosen on the page.
"""

from __future__ import annotations

import functools
import html
import queue
import threading
from collections.abc import Callable
from typing import Generic, TypeVar

import viser

from app.panels.files.upload_job import Deal, UploadJob
from app.panels.widgets import Wake
from app.reading.stored_upload import BUDGET, StoredUpload
from app.ui import page

_T = TypeVar("_T")
_NAME_LENGTH = 40
"""Letters of a file's name that are shown."""
_NONE = "choose one…"


def shown_name(name: str) -> str:
    """Name of a file as the page shows it."""
    return "".join(c for c in name if c.isprintable())[-_NAME_LENGTH:].strip() or "a file"


class FileUploads(Generic[_T]):
    """Line under a button for files with what becomes of them, a bar, and a button to stop it.

    Attributes:
        choice: of what to read of a file with several; hidden without one. None where no file has.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        button: viser.GuiUploadButtonHandle,
        deal: Deal[_T],
        wake: Wake,
        named: Callable[[str], str] = shown_name,
        several: bool = False,
        choice: str = "",
        choice_hint: str = "",
    ) -> None:
        """Begin without a file.

        Args:
            gui: of the tab.
            button: with which files are chosen.
            deal: what comes of one.
            wake: is called whenever there is news.
            named: name of a file on the page, of the one that it was sent with.
            several: whether the page lets several files be chosen at once.
            choice: label of the choice of what to read of a file with several; empty for none.
            choice_hint: what its entries are.
        """
        self._line = gui.add_html("", visible=False)
        self._bar = gui.add_progress_bar(0.0, visible=False)
        self._stop = gui.add_button("Stop reading", visible=False)
        self.choice: viser.GuiDropdownHandle[str] | None = None
        if choice:
            self.choice = gui.add_dropdown(choice, (_NONE,), hint=choice_hint, visible=False)
            self.choice.on_update(wake)
        self._several: UploadJob[_T] | None = None
        self._names: tuple[str, ...] = ()
        self._chosen = ""
        self._deal, self._wake, self._named, self._next = deal, wake, named, several
        self._waiting: queue.SimpleQueue[UploadJob[_T]] = queue.SimpleQueue()
        self._ended: queue.SimpleQueue[UploadJob[_T]] = queue.SimpleQueue()
        self._job: UploadJob[_T] | None = None
        self._stopped = threading.Event()
        self._lock = threading.Lock()
        self._pending = 0
        self._last: object = None
        """Event that the last file came with: it wakes the tab once more when one is read again."""
        self._arrived = page.on_arrival(gui, button, self._announce, _new_upload)
        button.on_upload(self._receive)
        self._stop.on_click(self._cancel)

    @property
    def stopped(self) -> bool:
        """Whether what is being read or prepared is not wanted any more."""
        return self._stopped.is_set()

    @property
    def preview(self) -> _T | None:
        """What was read of the file that is prepared, until :meth:`ended` tells of it, or None."""
        job = self._job
        return None if job is None or self.stopped else job.preview

    def ended(self) -> list[UploadJob[_T]]:
        """Files that were read and prepared, refused or stopped since the last call."""
        found = []
        while not self._ended.empty():
            job = self._ended.get()
            if job is self._job:
                self._job = None
            if self.choice is not None and job.choices:
                self._offer(job, job.choices)
                continue
            if self._several is not None and job.result is not None and not job.chosen:
                self._offer(None)
            found.append(job)
        self._read_chosen()
        return found

    def close(self) -> None:
        """Stop reading files, because the tab is closed."""
        self._stopped.set()

    def drop(self) -> None:
        """Stop reading all files, because something else was chosen meanwhile."""
        self._stopped.set()
        while not self._ended.empty():
            self._ended.get()
        self._job = None
        self._show(None, 0.0)

    def _announce(self, name: str, part: float | None) -> None:
        """Show how much of a file has arrived, unless another one is being read."""
        with self._lock:
            if self._pending:
                return
            name = self._named(name)
            if part is None:
                self._say(f"{name}: nothing more of it comes. Reload the page.")
            else:
                self._say(f"{name}: on its way…")
            self._bar.value = 100 * (part or 0.0)
            self._bar.visible = part is not None

    def _receive(self, event: viser.GuiEvent[viser.GuiUploadButtonHandle]) -> None:
        name, file = self._named(event.target.value.name), self._arrived()
        page.forget_file(event.target)
        if event.client is not None and self._next:
            page.call(event.client, "next")
        self._last = event
        # an empty file has no part that arrives
        self._queue(name, _new_upload() if file is None else file)

    def _queue(self, name: str, file: StoredUpload, chosen: str = "") -> None:
        """Have a file read that has arrived, or another of several things in it."""
        wake = functools.partial(self._wake, self._last)
        job = UploadJob[_T](name, file, self._stopped, self._tell_step, wake, chosen)
        with self._lock:
            self._waiting.put(job)
            self._pending += 1
            if self._pending == 1:
                self._stopped.clear()
                threading.Thread(target=self._work, name="files", daemon=True).start()

    def _offer(self, job: UploadJob[_T] | None, names: tuple[str, ...] = ()) -> None:
        """Offer the names in a file with several; with None, none any more."""
        if self.choice is not None:
            self._several, self._names, self._chosen = job, names, ""
            self.choice.visible = job is not None
            self.choice.options = (_NONE, *names)
            self.choice.value = _NONE

    def _read_chosen(self) -> None:
        """Read what was chosen of a file with several since the last call."""
        if self.choice is None or self._several is None:
            return
        name = self.choice.value
        if name in self._names and name != self._chosen:
            self._chosen = name
            self._queue(self._several.name, self._several.file, name)

    def _cancel(self, event: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
        self._stopped.set()
        self._show(None, 0.0)
        self._wake(event)

    def _work(self) -> None:
        """Read the waiting files one after the other, in a thread of its own."""
        while True:
            self._job = job = self._waiting.get()
            job.run(self._deal)
            with self._lock:
                self._pending -= 1
                last = self._pending == 0
            if last:
                self._show(None, 0.0)
            self._ended.put(job)
            job.wake()
            if last:
                return

    def _tell_step(self, line: str, share: float) -> None:
        more = f", {self._pending - 1} more to come" if self._pending > 1 else ""
        self._show(f"{line}{more}…", share)

    def _show(self, line: str | None, share: float) -> None:
        self._say(line)
        self._bar.value = 100 * share
        self._bar.visible = self._stop.visible = line is not None

    def _say(self, line: str | None) -> None:
        self._line.content = f'<div style="margin:0 10px">{html.escape(line or "")}</div>'
        self._line.visible = line is not None


def _new_upload() -> StoredUpload:
    """Place for the parts of a file."""
    return StoredUpload(BUDGET)
