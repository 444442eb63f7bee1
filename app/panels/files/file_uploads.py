"""Files on their way into a tab: read beside the planning, one at a time.

The tab's worker asks what became of them. A thread of its own has each file read in a process for
files from outside, and prepares what came of it, so that the hand goes on meanwhile; it can be told
to let a file be.
"""

from __future__ import annotations

import functools
import html
import queue
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import viser

from abi.errors import AbiError, SceneError, SeveralChoicesError
from abi.progress import CancelledError
from app.panels.widgets import Wake
from app.reading.stored_upload import ROOM, StoredUpload
from app.ui import page

_T = TypeVar("_T")
_NAME_LENGTH = 40
"""Letters of a file's name that are shown."""


@dataclass(frozen=True)
class UploadEvent(Generic[_T]):
    """What became of an uploaded file: it was read, prepared or refused.

    Attributes:
        name: of the file.
        result: what was read, or why nothing was; None where it was stopped.
        done: whether it was dealt with; otherwise it is read, and still being prepared.
        file: one with several of what one is read of, to read it again; None for others.
    """

    name: str
    result: _T | AbiError | None
    done: bool = True
    file: StoredUpload | None = None


class UploadJob(Generic[_T]):
    """An uploaded file that waits for its turn, or is read and prepared.

    Attributes:
        name: of the file, as it is shown.
        file: what has arrived of it.
        deal: what comes of it.
        stopped: set when it is not wanted any more.
        tell: is called with what becomes of it.
    """

    def __init__(
        self,
        name: str,
        file: StoredUpload,
        deal: Deal[_T],
        stopped: threading.Event,
        show: Callable[[str, float], None],
        tell: Callable[[UploadEvent[_T]], None],
    ) -> None:
        self.name, self.file, self.deal = name, file, deal
        self.stopped, self.tell, self._show = stopped, tell, show

    @property
    def content(self) -> bytes:
        """The whole content."""
        return self.file.content()

    def step(self, does: str, share: float) -> None:
        """Show what is done now, and the part of the work at which the bar is to stand, 0 to 1.

        Raises:
            CancelledError: the file is not wanted any more.
        """
        if self.stopped.is_set():
            raise CancelledError
        self._show(f"{self.name}: {does}", share)

    def wait(self) -> None:
        """Show that the files of other tabs are read first."""
        self._show(f"{self.name}: waiting until the files of others are read", 0.0)

    def is_read(self, result: _T) -> None:
        """Tell what was read, though it is still to be prepared."""
        self.tell(UploadEvent(self.name, result, done=False))


Deal = Callable[[UploadJob[_T]], _T]
"""What comes of a file; may raise AbiError and CancelledError."""


def shown_name(name: str) -> str:
    """Name of a file as the page shows it."""
    return "".join(c for c in name if c.isprintable())[-_NAME_LENGTH:].strip() or "a file"


class FileUploads(Generic[_T]):
    """Line under a button for files with what becomes of them, a bar, and a button to stop it."""

    def __init__(
        self,
        gui: viser.GuiApi,
        button: viser.GuiUploadButtonHandle,
        deal: Deal[_T],
        wake: Wake,
        named: Callable[[str], str] = shown_name,
        several: bool = False,
    ) -> None:
        """Begin without a file.

        Args:
            gui: of the tab.
            button: with which files are chosen.
            deal: what comes of one.
            wake: is called whenever there is news.
            named: name of a file on the page, of the one that it was sent with.
            several: whether the page lets several be chosen at once.
        """
        self._line = gui.add_html("", visible=False)
        self._bar = gui.add_progress_bar(0.0, visible=False)
        self._stop = gui.add_button("Stop reading", visible=False)
        self._deal, self._wake, self._named, self._several = deal, wake, named, several
        self._waiting: queue.SimpleQueue[UploadJob[_T]] = queue.SimpleQueue()
        self._news: queue.SimpleQueue[UploadEvent[_T]] = queue.SimpleQueue()
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

    def news(self) -> list[UploadEvent[_T]]:
        """News of the files since the last call: each is read, then prepared, or refused."""
        found = []
        while not self._news.empty():
            found.append(self._news.get())
        return found

    def close(self) -> None:
        """Stop reading files, because the tab is closed."""
        self._stopped.set()

    def drop(self) -> None:
        """Stop reading all files, because something else was chosen meanwhile."""
        self._stopped.set()
        while not self._news.empty():
            self._news.get()
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
        if event.client is not None and self._several:
            page.call(event.client, "next")
        self._last = event
        # an empty file has no part that arrives
        self.again(name, _new_upload() if file is None else file, self._deal)

    def again(self, name: str, file: StoredUpload, deal: Deal[_T]) -> None:
        """Read a file that has arrived, once more where it has been read by another function.

        Args:
            name: of the file, as it is shown.
            file: what has arrived of it.
            deal: what comes of it.
        """
        tell = functools.partial(self._tell, self._last)
        job = UploadJob(name, file, deal, self._stopped, self._tell_step, tell)
        with self._lock:
            self._waiting.put(job)
            self._pending += 1
            if self._pending == 1:
                self._stopped.clear()
                threading.Thread(target=self._work, name="files", daemon=True).start()

    def _cancel(self, event: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
        self._stopped.set()
        self._show(None, 0.0)
        self._wake(event)

    def _work(self) -> None:
        """Read the waiting files one after the other, in a thread of its own."""
        while True:
            job = self._waiting.get()
            name, tell = job.name, job.tell
            result = _result(job)
            file = job.file if isinstance(result, SeveralChoicesError) else None
            del job  # its room is for the next
            with self._lock:
                self._pending -= 1
                last = self._pending == 0
            if last:
                self._show(None, 0.0)
            tell(UploadEvent(name, None if self._stopped.is_set() else result, file=file))
            if last:
                return

    def _tell(self, event: object, news: UploadEvent[_T]) -> None:
        self._news.put(news)
        self._wake(event)

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
    return StoredUpload(ROOM)


def _result(job: UploadJob[_T]) -> _T | AbiError | None:
    """Read one file; None if that was stopped."""
    if job.stopped.is_set():
        return None
    if job.file.lost:
        return SceneError("file", job.name, job.file.lost)
    try:
        return job.deal(job)
    except AbiError as error:
        return error
    except CancelledError:
        return None
