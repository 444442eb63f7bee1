"""More processes behind the same address: one interpreter uses no more than one core.

Each is an ``abi serve`` of its own that listens on the same port; the system gives every new
connection to one of them. A tab needs no more than one connection and keeps its scene itself, so
that any process can serve it, also after another has ended.
"""

from __future__ import annotations

import logging
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path

from app.guard.seats import Seats
from app.scratch import ScratchFolder

_log = logging.getLogger("abi.web")
_PATIENCE = 10.0
"""Seconds in which a process ends that was told to."""
_START = 60.0
"""Seconds in which processes begin to listen that are not hindered."""
_PERIOD = 0.05
_METRICS = "PROMETHEUS_MULTIPROC_DIR"
"""Variable of prometheus-client: where processes keep figures that are counted together."""


def are_possible() -> bool:
    """Whether the system shares a port's connections out, as Linux does."""
    return sys.platform == "linux" and hasattr(socket, "SO_REUSEPORT")


class Workers:
    """Processes besides this one, each started again when it ends by itself.

    Attributes:
        seats: tabs of all processes; None where there are no others.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._processes: list[subprocess.Popen[bytes]] = []
        self._lock = threading.Lock()
        self._ending = False
        self.seats: Seats | None = None
        self._folder: ScratchFolder | None = None
        if count:
            self._folder = ScratchFolder()
            os.environ[_METRICS] = str(self._folder.path)
            self.seats = Seats(self._folder.path, 0, count + 1)

    def start(self, arguments: Sequence[str], token: str | None) -> None:
        """Start them with these arguments of ``abi serve``; the token is none for others to see."""
        environment = dict(os.environ)
        if token is not None:
            environment["ABI_TOKEN"] = token
        for place in range(1, self._count + 1):
            thread = threading.Thread(
                target=self._keep, args=(place, arguments, environment), name="worker", daemon=True
            )
            thread.start()

    def wait(self, ended: threading.Event) -> None:
        """Wait until all of them listen, unless ``ended`` is set before.

        Until then the first gets every tab, and keeps it.
        """
        end = time.monotonic() + _START
        while self.seats is not None and not self.seats.are_all_there:
            if ended.wait(_PERIOD):
                return
            if time.monotonic() > end:
                _log.warning("not all workers listen")
                return

    def stop(self) -> None:
        """End them, and tell their tabs."""
        with self._lock:
            self._ending = True
            processes = tuple(self._processes)
        for process in processes:
            # one that has just begun may not hear the signal, and finds its input at the end
            assert process.stdin is not None
            process.stdin.close()
            process.terminate()
        for process in processes:
            try:
                process.wait(_PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        if self._folder is not None:
            self._folder.close()

    def _keep(self, place: int, arguments: Sequence[str], environment: dict[str, str]) -> None:
        """Keep the process at a place running until the end: a thread."""
        command = [sys.executable, "-P", "-m", "app", "serve", "--joins", str(place), *arguments]
        assert self.seats is not None
        while True:
            with self._lock:
                if self._ending:
                    return
                # it reads its input to the end, which comes when this process is gone
                process = subprocess.Popen(
                    command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL
                )
                self._processes.append(process)
            code = process.wait()
            with self._lock:
                if self._ending:
                    return
                self._processes.remove(process)
            self.seats.vacate(place)
            from prometheus_client import multiprocess

            multiprocess.mark_process_dead(process.pid)  # type: ignore[no-untyped-call]
            _log.warning("worker ended", extra={"code": code})
            if code == 0:
                return


def seat(place: int) -> Seats:
    """The seats of the process that started this one, at its own place."""
    return Seats(Path(os.environ[_METRICS]), place)


def end_with_starter(ended: threading.Event) -> None:
    """Set ``ended`` in a worker once the process that started it is gone."""
    thread = threading.Thread(target=_read_to_end, args=(ended,), name="starter", daemon=True)
    thread.start()


def _read_to_end(ended: threading.Event) -> None:
    sys.stdin.buffer.read()
    ended.set()
