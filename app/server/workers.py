"""Worker processes behind one address, since one interpreter uses no more than one core.

Each is a separate ``abi serve``, but only the first one listens; it gives every new tab to the
process that has the fewest (:mod:`app.guard.porter`). A tab needs only one connection and keeps its
scene itself, so any process can serve it, also after another has ended.
"""

from __future__ import annotations

import contextlib
import logging
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from tempfile import TemporaryDirectory

from app.guard.porter import Porter
from app.process.scratch import scratch_folder

Meet = Callable[[socket.socket], None]
"""Callback that introduces a process, by its socket, to the porter."""

_log = logging.getLogger("abi.web")
_PATIENCE = 10.0
"""Seconds for a process to end after it was told to."""
_START = 60.0
"""Seconds within which processes begin to listen."""
_LONGEST = 60.0
"""Longest delay before a process is restarted, [s]."""
_PERIOD = 0.05
_METRICS = "PROMETHEUS_MULTIPROC_DIR"
"""Environment variable of prometheus-client: folder of the figures of several processes."""


def are_possible() -> bool:
    """Check whether processes can pass connections to each other in one message, as on Linux."""
    return sys.platform == "linux"


class Workers:
    """Additional processes, each restarted if it ends unexpectedly.

    Attributes:
        porter: who gives tabs to the processes; None where there are no others.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._processes: dict[subprocess.Popen[bytes], socket.socket] = {}
        self._lock = threading.Lock()
        self._ending = threading.Event()
        self.porter: Porter | None = None
        self._folder: TemporaryDirectory[str] | None = None
        if count:
            self._folder = scratch_folder()
            os.environ[_METRICS] = self._folder.name
            self.porter = Porter(count + 1)

    def start(self, arguments: Sequence[str], token: str | None, meet: Meet) -> None:
        """Start them with these arguments of ``abi serve``, which do not show the token.

        The porter is to ``meet`` each of them.
        """
        environment = dict(os.environ)
        if token is not None:
            environment["ABI_TOKEN"] = token
        for _ in range(self._count):
            thread = threading.Thread(
                target=self._keep,
                args=(arguments, environment, meet),
                name="worker",
                daemon=True,
            )
            thread.start()

    def wait(self, ended: threading.Event) -> None:
        """Wait until all of them listen, unless ``ended`` is set before.

        Until then the first gets every tab, and keeps it.
        """
        end = time.monotonic() + _START
        while self.porter is not None and not self.porter.are_all_there:
            if ended.wait(_PERIOD):
                return
            if time.monotonic() > end:
                _log.warning("not all workers listen")
                return

    def stop(self) -> None:
        """End them and notify their tabs."""
        with self._lock:
            self._ending.set()
            processes = dict(self._processes)
        for process, channel in processes.items():
            # one that has just begun may not hear the signal, and finds its input at the end
            with contextlib.suppress(OSError):
                channel.shutdown(socket.SHUT_RDWR)
            process.terminate()
        for process in processes:
            try:
                process.wait(_PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        if self._folder is not None:
            # who is started from now on has no folder to keep its figures in
            os.environ.pop(_METRICS, None)
            self._folder.cleanup()

    def _keep(self, arguments: Sequence[str], environment: dict[str, str], meet: Meet) -> None:
        """Thread that restarts one process until the server stops.

        One that soon ends is started again after longer and longer: it would take a core for good.
        """
        joins = str(self._count + 1)
        command = [sys.executable, "-P", "-m", "app", "serve", "--joins", joins, *arguments]
        pause = 0.0
        while not self._ending.wait(pause):
            begin = time.monotonic()
            with self._lock:
                if self._ending.is_set():
                    return
                # its input brings it tabs, and ends when this process is gone
                channel, other = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
                with other:
                    process = subprocess.Popen(
                        command, env=environment, stdin=other.fileno(), stdout=subprocess.DEVNULL
                    )
                self._processes[process] = channel
            meet(channel)
            code = process.wait()
            with self._lock:
                if self._ending.is_set():
                    return
                del self._processes[process]
            from prometheus_client import multiprocess

            assert self._folder is not None
            folder = self._folder.name
            multiprocess.mark_process_dead(process.pid, folder)  # type: ignore[no-untyped-call]
            lived = time.monotonic() - begin
            pause = 0.0 if lived > _START else min(2 * pause + 1, _LONGEST)
            _log.warning("worker ended", extra={"code": code, "again_in": pause})
            if code == 0:
                return
