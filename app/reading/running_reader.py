"""A running process that reads files from outside: start, question and end."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from pathlib import Path
from typing import IO

from app.reading.messages import decode, encode
from app.reading.reader_process import READY, receive, send
from app.reading.reading import ReadingRequest, ReadingResult

AT_ONCE = 2
"""Most files that are read at once; others wait."""
RunningReader = subprocess.Popen[bytes]
"""A process that takes requests and answers them."""
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


def started(memory: int, open_files: int, seconds: int) -> RunningReader:
    """A new process, with limits as :class:`app.reading.reader.Reader` has them."""
    paths = [str(_ROOT), os.environ.get("PYTHONPATH", "")]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
    environment |= dict.fromkeys(_SINGLE, "1")
    numbers = map(str, (memory, open_files, seconds))
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "app.reading.reader_process", *numbers],
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )


def answer_of(process: RunningReader, request: ReadingRequest) -> ReadingResult | None:
    """The answer of a process to a request; None if it ended."""
    requests, answers = _pipes(process)
    try:
        send(requests, encode(request))
        content = receive(answers)
        if content == READY:  # before the first
            content = receive(answers)
    except OSError:
        return None
    return None if content is None else decode(content, ReadingResult)


def closed(process: RunningReader) -> int:
    """Exit code of a process that is to end, and whose pipes are closed."""
    requests, answers = _pipes(process)
    with contextlib.suppress(OSError):  # what was still to be written
        requests.close()
    try:
        process.wait(_GRACE)
    except subprocess.TimeoutExpired:
        process.kill()
    answers.close()
    return process.wait()


def _pipes(process: RunningReader) -> tuple[IO[bytes], IO[bytes]]:
    """Where the process takes requests, and where it answers."""
    assert process.stdin is not None
    assert process.stdout is not None
    return process.stdin, process.stdout
