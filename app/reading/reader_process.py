"""The process that reads files from outside: it cannot open files, and its resources are limited.

:mod:`app.reading.running_reader` starts it, and it ends with its input. Requests and answers are
msgpack, each preceded by its length in eight bytes.
"""

from __future__ import annotations

import contextlib
import os
import sys
import time
from pathlib import Path
from typing import IO

LENGTH = 8
READY = b"ready"


def receive(stream: IO[bytes]) -> bytes | None:
    """Receive the next message; None at the end of the stream."""
    head = stream.read(LENGTH)
    if len(head) < LENGTH:
        return None
    size = int.from_bytes(head, "little")
    content = stream.read(size)
    return content if len(content) == size else None


def send(stream: IO[bytes], content: bytes) -> None:
    """Write a message."""
    stream.write(len(content).to_bytes(LENGTH, "little"))
    stream.write(content)
    stream.flush()


def main() -> None:
    """Read files until the input ends.

    The command line has the limits: memory in bytes, open files, and processor time for a file in
    seconds.
    """
    memory, files, seconds = map(int, sys.argv[1:])
    # what a library prints must not stand among the answers
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    from app.reading.messages import decode, encode
    from app.reading.reading import ReadingRequest, read, rehearse

    rehearse()
    restrict(memory, files)
    send(answers, READY)
    while (content := receive(sys.stdin.buffer)) is not None:
        allow(seconds)
        answer = read(decode(content, ReadingRequest))
        send(answers, encode(answer))


def restrict(memory: int, files: int) -> None:
    """Forbid writing files, and limit memory to ``memory`` bytes and open files to ``files``.

    What is open stays so. Where memory runs out in the whole machine or container, Linux ends this
    process before any other. Where the system has no such limits, as Windows, time is still limited
    by whoever waits.
    """
    with contextlib.suppress(ImportError):
        import resource

        with contextlib.suppress(OSError):
            Path("/proc/self/oom_score_adj").write_text("1000")
        for limit in (resource.RLIMIT_CORE, resource.RLIMIT_FSIZE):
            resource.setrlimit(limit, (0, 0))
        statm = Path("/proc/self/statm")
        if statm.exists():
            most = memory + int(statm.read_text().split()[0]) * resource.getpagesize()
            resource.setrlimit(resource.RLIMIT_AS, (most, most))
        resource.setrlimit(resource.RLIMIT_NOFILE, (files, files))


def allow(seconds: int) -> None:
    """Allow ``seconds`` more of processor time."""
    with contextlib.suppress(ImportError):
        import resource

        _, most = resource.getrlimit(resource.RLIMIT_CPU)
        resource.setrlimit(resource.RLIMIT_CPU, (int(time.process_time()) + seconds, most))


if __name__ == "__main__":
    main()
