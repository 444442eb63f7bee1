"""Watch over a student's file: its functions are checked whenever it is saved."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from abi.errors import AbiError
from abi.teach.exercise_file import exercises_in
from abi.teach.verdict import ExerciseVerdict, check

_LOOK = 0.3
"""Seconds between two looks at the file."""


@dataclass(frozen=True, eq=False)
class Checked:
    """Findings of the last check.

    Attributes:
        file: its name.
        verdicts: of each exercise whose function the file has.
        checking: name of the exercise that is checked now; empty for none.
        refused: why the file was not checked; empty where it was.
    """

    file: str
    verdicts: tuple[ExerciseVerdict, ...] = ()
    checking: str = ""
    refused: str = ""


class ExerciseWatch:
    """The file, and the tabs to notify; thread-safe.

    Attributes:
        checked: what the last check found.
    """

    def __init__(self, file: Path) -> None:
        """Begin to watch a file, which need not exist yet."""
        self._file = file
        self.checked = Checked(file.name)
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
        try:
            asked = exercises_in(self._file)
        except AbiError as error:
            self._tell(Checked(self._file.name, refused=error.message))
            return
        verdicts: list[ExerciseVerdict] = []
        for one in asked:
            self._tell(Checked(self._file.name, tuple(verdicts), one.name))
            try:
                verdicts.append(check(one.name, self._file))
            except AbiError as error:  # it was deleted meanwhile
                self._tell(Checked(self._file.name, refused=error.message))
                return
            if self._ended.is_set():
                return
        self._tell(Checked(self._file.name, tuple(verdicts)))

    def _tell(self, checked: Checked) -> None:
        self.checked = checked
        with self._lock:
            wakes = list(self._wakes.values())
        for wake in wakes:
            wake()
