"""Watch over a student's file: its functions are checked whenever it is saved."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Mapping
from pathlib import Path

from abi.errors import AbiError
from abi.teach.exercise_file import exercises_in
from abi.teach.verdict import ExerciseVerdict, check

_LOOK = 0.3
"""Seconds between two looks at the file."""


Findings = Mapping[str, ExerciseVerdict | None] | str
"""Verdicts by exercise, None for the one that is checked now; or why the file was not checked."""


class ExerciseWatch:
    """The file, and the tabs to notify; thread-safe.

    Attributes:
        name: of the file.
        found: in the last check.
    """

    def __init__(self, file: Path) -> None:
        """Begin to watch a file, which need not exist yet."""
        self._file, self.name = file, file.name
        self.found: Findings = {}
        self._wakes: dict[int, Callable[[], None]] = {}
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="exercise", daemon=True)
        self._thread.start()

    def join(self, tab: int, wake: Callable[[], None]) -> None:
        """Have ``wake`` called on every new finding."""
        with self._lock:
            self._wakes[tab] = wake

    def leave(self, tab: int) -> None:
        """Stop notifying a tab."""
        with self._lock:
            self._wakes.pop(tab, None)

    def close(self) -> None:
        """Stop watching, after a check that is running."""
        self._ended.set()
        self._thread.join()

    def _watch(self) -> None:
        """Check the file whenever its time or size changes."""
        seen: tuple[int, int] | None = (-1, -1)
        while not self._ended.is_set():
            now = None
            with contextlib.suppress(OSError):
                status = self._file.stat()
                now = status.st_mtime_ns, status.st_size
            if now != seen:
                seen = now
                self._check()
            self._ended.wait(_LOOK)

    def _check(self) -> None:
        """Check every function of the file, and tell after each."""
        found: dict[str, ExerciseVerdict | None] = {}
        try:
            for one in exercises_in(self._file):
                self._tell({**found, one.name: None})
                found[one.name] = check(one.name, self._file)
                if self._ended.is_set():
                    return
        except AbiError as error:  # it cannot be read, or was deleted meanwhile
            self._tell(error.message)
        else:
            self._tell(found)

    def _tell(self, found: Findings) -> None:
        self.found = found
        with self._lock:
            wakes = list(self._wakes.values())
        for wake in wakes:
            wake()
