"""Uploads of mesh files: read and prepared in the background, one at a time.

A thread has each file read and repaired by the process for files from outside, and then prepares
it, so that obstacles can be moved meanwhile; it can be told to drop a file. The tab's worker asks
for the results. A file that has been read can be drawn; planning waits until it is prepared.
"""

from __future__ import annotations

import html
import queue
import threading
from dataclasses import dataclass
from typing import Any

import viser

from abi.errors import SceneError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.triangle_mesh.mesh_reader import SUFFIXES
from abi.obstacles.triangle_mesh.surface import Surface
from app import page
from app.guard.reader import READER, StoppedError
from app.mesh_picture import drawn_triangles
from app.panels.widgets import Wake

_STEPS = ("reading and repairing", "preparing")


@dataclass(frozen=True)
class Read:
    """A file that was read, and is being prepared."""

    surface: Surface


@dataclass(frozen=True)
class Prepared:
    """A file that was dealt with.

    Attributes:
        name: of the file, as the scene names it.
        result: its surface, or why there is none; None where it was stopped.
    """

    name: str
    result: Surface | SceneError | None


class MeshUploads:
    """A button for files, and a line with what becomes of them and a button to stop it.

    Attributes:
        button: takes one file after the other; the page lets several be chosen at once.
    """

    def __init__(self, gui: viser.GuiApi, wake: Wake) -> None:
        kinds = ", ".join(suffix[1:].upper() for suffix in SUFFIXES)
        self.button = gui.add_upload_button(
            "Add a mesh (STL, OBJ, GLB …)",
            mime_type=",".join(SUFFIXES),
            hint=f"{kinds}, up to 50 MB.",
        )
        self._line = gui.add_html("", visible=False)
        self._bar = gui.add_progress_bar(0.0, visible=False)
        self._stop = gui.add_button("Stop reading", visible=False)
        self._wake = wake
        self._waiting: queue.SimpleQueue[tuple[viser.UploadedFile, Any]] = queue.SimpleQueue()
        self._news: queue.SimpleQueue[Read | Prepared] = queue.SimpleQueue()
        self._stopped = threading.Event()
        self._lock = threading.Lock()
        self._pending = 0
        page.on_arrival(gui, self.button, self._announce)
        self.button.on_upload(self._receive)
        self._stop.on_click(self._cancel)

    @property
    def stopped(self) -> bool:
        """Whether what is being read or prepared is not wanted any more."""
        return self._stopped.is_set()

    def news(self) -> list[Read | Prepared]:
        """What became of the files since the last call: each is read, then prepared, or refused."""
        found = []
        while not self._news.empty():
            found.append(self._news.get())
        return found

    def _announce(self, name: str, part: float | None) -> None:
        """Tell how much of a file is there, unless another one is being dealt with."""
        with self._lock:
            if self._pending:
                return
            if part is None:
                self._say(f"{safe_name(name)}: nothing more of it comes. Reload the page.")
            else:
                self._say(f"{safe_name(name)}: on its way…")
            self._bar.value = 100 * (part or 0.0)
            self._bar.visible = part is not None

    def _receive(self, event: viser.GuiEvent[viser.GuiUploadButtonHandle]) -> None:
        file = event.target.value
        if event.client is not None:
            page.next_file(event.client)
        with self._lock:
            self._waiting.put((file, event))
            self._pending += 1
            if self._pending == 1:
                self._stopped.clear()
                threading.Thread(target=self._work, name="meshes", daemon=True).start()

    def _cancel(self, event: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
        self._stopped.set()
        self._show(None, 0.0)
        self._wake(event)

    def _work(self) -> None:
        """Deal with files until none is left: the thread."""
        while True:
            file, event = self._waiting.get()
            name = safe_name(file.name)
            result = None if self._stopped.is_set() else self._prepare(file, name, event)
            with self._lock:
                self._pending -= 1
                last = self._pending == 0
            self._news.put(Prepared(name, None if self._stopped.is_set() else result))
            if last:
                self._show(None, 0.0)
            self._wake(event)
            if last:
                return

    def _prepare(
        self, file: viser.UploadedFile, name: str, event: object
    ) -> Surface | SceneError | None:
        """Read, repair and prepare one file; None where it was stopped."""
        try:
            self._step(name, 0)
            surface = READER.mesh(file.content, name, self._stopped)
            self._step(name, 1)
            drawn_triangles(surface)
            self._news.put(Read(surface))
            self._wake(event)
            MeshShape.of(surface, file=name).prepare()
        except SceneError as error:
            return error
        except StoppedError:
            return None
        return surface

    def _step(self, name: str, step: int) -> None:
        if self._stopped.is_set():
            raise StoppedError
        more = f", {self._pending - 1} more to come" if self._pending > 1 else ""
        self._show(f"{name}: {_STEPS[step]}{more}…", (step + 0.5) / len(_STEPS))

    def _show(self, line: str | None, share: float) -> None:
        self._say(line)
        self._bar.value = 100 * share
        self._bar.visible = self._stop.visible = line is not None

    def _say(self, line: str | None) -> None:
        self._line.content = f'<div style="margin:0 10px">{html.escape(line or "")}</div>'
        self._line.visible = line is not None


def safe_name(name: str) -> str:
    """File name for the scene from an uploaded one, which may have any characters."""
    stem, dot, ending = name.rpartition(".")
    kept = "".join(c if c.isalnum() or c in "-_" else "_" for c in stem)[:60] or "mesh"
    return f"{kept}{dot}{ending.lower()}"
