"""More processes behind the same address: one interpreter uses no more than one core.

Each is an ``abi serve`` of its own that listens on the same port; the system gives every new
connection to one of them. A tab needs no more than one connection and keeps its scene itself, so
that any process can serve it, also after another has ended.
"""

from __future__ import annotations

import contextlib
import logging
import os
import socket
import subprocess
import sys
import tempfile
import threading
from collections.abc import Sequence

_log = logging.getLogger("abi.web")
_PATIENCE = 10.0
"""Seconds in which a process ends that was told to."""
_METRICS = "PROMETHEUS_MULTIPROC_DIR"
"""Variable of prometheus-client: where processes keep figures that are counted together."""


def are_possible() -> bool:
    """Whether the system shares a port's connections out, as Linux does."""
    return sys.platform == "linux" and hasattr(socket, "SO_REUSEPORT")


class Workers:
    """Processes besides this one, each started again when it ends by itself."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._folder = contextlib.ExitStack()
        self._processes: list[subprocess.Popen[bytes]] = []
        self._lock = threading.Lock()
        self._ending = False
        if count:
            folder = tempfile.TemporaryDirectory(prefix="abi-")
            os.environ[_METRICS] = self._folder.enter_context(folder)

    def start(self, arguments: Sequence[str], token: str | None) -> None:
        """Start them with these arguments of ``abi``; the token is none that others may see."""
        environment = dict(os.environ)
        if token is not None:
            environment["ABI_TOKEN"] = token
        for _ in range(self._count):
            thread = threading.Thread(
                target=self._keep, args=(arguments, environment), name="worker", daemon=True
            )
            thread.start()

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
        self._folder.close()

    def _keep(self, arguments: Sequence[str], environment: dict[str, str]) -> None:
        """Keep one process running until the end: a thread."""
        command = [sys.executable, "-P", "-m", "app", *arguments]
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
            from prometheus_client import multiprocess

            multiprocess.mark_process_dead(process.pid)  # type: ignore[no-untyped-call]
            _log.warning("worker ended", extra={"code": code})
            if code == 0:
                return


def end_with_starter(ended: threading.Event) -> None:
    """Set ``ended`` in a worker once the process that started it is gone."""
    thread = threading.Thread(target=_read_to_end, args=(ended,), name="starter", daemon=True)
    thread.start()


def _read_to_end(ended: threading.Event) -> None:
    sys.stdin.buffer.read()
    ended.set()
