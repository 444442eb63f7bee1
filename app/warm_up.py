"""The kernels are compiled behind the first plan, and the tabs hear of it when that takes long."""

from __future__ import annotations

import importlib
import threading

import viser

from abi import compiling

PATIENCE = 10.0
"""Seconds after which the compiler no longer waits for a first plan."""
LONG = 2.0
"""Seconds of compiling that need no word."""


class WarmUp:
    """One thread that compiles, or loads what was compiled before.

    Attributes:
        planned: set it once a plan is drawn: until then all time is the plan's.
    """

    def __init__(self) -> None:
        self.planned = threading.Event()
        self._lock = threading.Lock()
        self._tabs: list[viser.ClientHandle] = []
        self._notes: list[viser.NotificationHandle] = []
        self._long, self._done = False, False
        threading.Thread(target=self._work, name="warm-up", daemon=True).start()

    def greet(self, client: viser.ClientHandle) -> None:
        """A tab came; tell it what is going on, now or when it takes long."""
        with self._lock:
            if self._done:
                return
            self._tabs.append(client)
            if self._long:
                self._tell(client)

    def _work(self) -> None:
        # what draws the arm, while the page loads
        importlib.import_module("yourdfpy")
        self.planned.wait(PATIENCE)
        late = threading.Timer(LONG, self._tell_all)
        late.daemon = True
        late.start()
        try:
            compiling.compile()
        finally:
            late.cancel()
            with self._lock:
                self._long, self._done = False, True
                self._tabs.clear()
                for note in self._notes:
                    note.remove()
                self._notes.clear()

    def _tell_all(self) -> None:
        with self._lock:
            self._long = True
            for client in self._tabs:
                self._tell(client)

    def _tell(self, client: viser.ClientHandle) -> None:
        self._notes.append(
            client.add_notification(
                "First start: getting faster",
                "The inner loops are being compiled, once on this machine. Everything works "
                "meanwhile; fine meshes are slower.",
                loading=True,
                auto_close_seconds=None,
            )
        )
