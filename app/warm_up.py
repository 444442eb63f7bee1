"""What is loaded behind the first plan: the kernels, with a notice where that takes long, and the
process that reads files.
"""

from __future__ import annotations

import contextlib
import importlib
import threading

import viser

from abi import compiling

PLAN_TIMEOUT = 10.0
"""Seconds after which compilation no longer waits for a first plan."""
NOTICE_DELAY = 2.0
"""Seconds of compilation without a notice."""


class WarmUp:
    """Thread that compiles the kernels, or loads them from the cache.

    Attributes:
        planned: to be set once a plan is drawn: until then the plan has the processor.
    """

    def __init__(self) -> None:
        self.planned = threading.Event()
        self._lock = threading.Lock()
        self._clients: list[viser.ClientHandle] = []
        self._notices: list[viser.NotificationHandle] = []
        self._announced, self._done = False, False
        threading.Thread(target=self._work, name="warm-up", daemon=True).start()

    def add(self, client: viser.ClientHandle) -> None:
        """Notify a new client of compilation, now or once it takes long."""
        with self._lock:
            if self._done:
                return
            self._clients.append(client)
            if self._announced:
                self._notify(client)

    def _work(self) -> None:
        # slow to import, and needed to draw the arm
        importlib.import_module("yourdfpy")
        self.planned.wait(PLAN_TIMEOUT)
        timer = threading.Timer(NOTICE_DELAY, self._notify_all)
        timer.daemon = True
        timer.start()
        try:
            compiling.compile()
            self._call_kernels()
            if self.planned.is_set():
                self._warm_reader()
        finally:
            timer.cancel()
            with self._lock:
                self._done = True
                self._clients.clear()
                for notice in self._notices:
                    notice.remove()
                self._notices.clear()

    @staticmethod
    def _call_kernels() -> None:
        """Plan once: the first calls take milliseconds, which a tab would tell as a search's."""
        from abi.planner.planner import plan
        from abi.scene.scene import load_scene

        plan(load_scene("paper"))

    @staticmethod
    def _warm_reader() -> None:
        """Start the process that reads files from outside, which takes two seconds."""
        from app.guard.reader import READER

        with contextlib.suppress(OSError):  # the first file tries again
            READER.warm()

    def _notify_all(self) -> None:
        with self._lock:
            self._announced = True
            for client in self._clients:
                self._notify(client)

    def _notify(self, client: viser.ClientHandle) -> None:
        self._notices.append(
            client.add_notification(
                "First start: getting faster",
                "The inner loops are being compiled, once on this machine. Everything works "
                "meanwhile; fine meshes are slower.",
                loading=True,
                auto_close_seconds=None,
            )
        )
