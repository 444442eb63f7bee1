"""A running process that reads files from outside."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from pathlib import Path
from typing import BinaryIO

from app.reading.messages import decode, encode
from app.reading.reader_process import READY, receive, send
from app.reading.reading import ReadingRequest, ReadingResult

AT_ONCE = 2
"""Most files that are read at once; others wait."""
_ROOT = Path(__file__).resolve().parents[2]
_MOST_MEMORY = 2_000_000_000
_GRACE = 0.5
"""Seconds for a process to end by itself."""
_SINGLE = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS")


def reading_memory(memory: int | None) -> int:
    """Bytes for one file, so that all files read at once leave half of the memory to the server.

    Args:
        memory: [bytes] of the machine or the container; None where nobody tells.
    """
    return _MOST_MEMORY if memory is None else min(_MOST_MEMORY, memory // (2 * AT_ONCE))


class RunningReader:
    """A running reader process."""

    def __init__(self, memory: int, open_files: int, seconds: int) -> None:
        """Start it with limits as :class:`app.reading.reader.Reader` has them."""
        paths = [str(_ROOT), os.environ.get("PYTHONPATH", "")]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
        environment |= dict.fromkeys(_SINGLE, "1")
        numbers = map(str, (memory, open_files, seconds))
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "app.reading.reader_process", *numbers],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._requests: BinaryIO = self._process.stdin  # type: ignore[assignment]
        self._answers: BinaryIO = self._process.stdout  # type: ignore[assignment]
        self._ready = False

    def read(self, request: ReadingRequest) -> ReadingResult | None:
        """The answer to a request; None if the process ended."""
        try:
            if not self._ready:
                self._ready = receive(self._answers) == READY
            send(self._requests, encode(request))
            content = receive(self._answers)
        except OSError:
            return None
        return None if content is None else decode(content, ReadingResult)

    def kill(self) -> None:
        """Kill the process."""
        self._process.kill()

    def close(self) -> int:
        """Close the process and its pipes; its exit code."""
        with contextlib.suppress(OSError):  # what was still to be written
            self._requests.close()
        if not self._ready:  # it would go on loading first
            self._process.kill()
        try:
            self._process.wait(_GRACE)
        except subprocess.TimeoutExpired:
            self._process.kill()
        self._answers.close()
        return self._process.wait()
