"""One uploaded file, from its arrival to what was read of it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

from abi.errors import AbiError, SceneError
from abi.progress import CancelledError
from app.reading.stored_upload import StoredUpload

_T = TypeVar("_T")


class UploadJob(Generic[_T]):
    """An uploaded file that waits for its turn, is read and prepared, and then has a result.

    Attributes:
        name: of the file, as it is shown.
        file: what has arrived of it.
        stopped: set when it is not wanted any more.
        chosen: name of what to read of a file with several; empty until that is chosen.
        preview: what was read, once it is only to be prepared; None before.
        wake: to be called once there is something new to look at.
        result: what came of it, or why nothing did; None before, and where it was stopped.
    """

    def __init__(
        self,
        name: str,
        file: StoredUpload,
        stopped: threading.Event,
        show: Callable[[str, float], None],
        wake: Callable[[], object],
        chosen: str = "",
    ) -> None:
        self.name, self.file, self.stopped, self.chosen = name, file, stopped, chosen
        self._show, self.wake = show, wake
        self.preview: _T | None = None
        self.result: _T | AbiError | None = None

    @property
    def choices(self) -> tuple[str, ...]:
        """Names of what the file holds, of which one is to be chosen; empty where that is clear."""
        return self.result.choices if isinstance(self.result, AbiError) else ()

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
        """Let what was read be looked at, though it is still to be prepared."""
        self.preview = result
        self.wake()

    def run(self, deal: Deal[_T]) -> None:
        """Read and prepare the file; what it took is free afterwards, unless one has to choose."""
        result = None if self.stopped.is_set() else self._dealt(deal)
        self.result = None if self.stopped.is_set() else result
        if not (self.chosen or self.choices):
            self.file.close()

    def _dealt(self, deal: Deal[_T]) -> _T | AbiError | None:
        if self.file.lost:
            return SceneError("file", self.name, self.file.lost)
        try:
            return deal(self)
        except AbiError as error:
            return error
        except CancelledError:
            return None


Deal = Callable[[UploadJob[_T]], _T]
"""What comes of a file; may raise AbiError and CancelledError."""
