"""Background loading, while the page loads and after the first plan.

First comes what a tab's first picture needs, with the plan of the scene that tabs open with unless
one is there already; then the kernels, with a notice of how far they are if they take long, the
bodies of the arm, and the process that reads files. A class that opens at once finds all of it made
or being made, once.
"""

from __future__ import annotations

import contextlib
import importlib
import threading
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import viser

from abi import compiling
from app.process.unused_memory import loaded

if TYPE_CHECKING:
    from abi.scene.scene import Scene
    from app.shared.shared_plans import SharedPlans

PLAN_TIMEOUT = 4.0
"""Seconds after which compilation no longer waits for a first plan."""
NOTICE_DELAY = 2.0
"""Seconds of compilation before the first notice, and between two notices."""


class WarmUp:
    """Thread that prepares the first picture and compiles or loads the kernels.

    Attributes:
        planned: to be set once a plan is drawn: until then the plan has the processor.
        thread: in which all this is done.
    """

    def __init__(self, scene: Scene, opening: SharedPlans) -> None:
        """Prepare for tabs that open ``scene``, whose plan goes into ``opening``."""
        self._scene, self._opening = scene, opening
        self.planned = threading.Event()
        self._lock = threading.Lock()
        self._clients: list[viser.ClientHandle] = []
        self._notices: list[viser.NotificationHandle] = []
        self._told: tuple[str, str] | None = None
        self._done = False
        self.thread = threading.Thread(target=self._work, name="warm-up", daemon=True)
        self.thread.start()

    def add(self, client: viser.ClientHandle) -> None:
        """Notify a new client of compilation, now or once it takes long."""
        with self._lock:
            if self._done:
                return
            self._clients.append(client)
            if self._told is not None:
                self._notify(client, *self._told)

    def _work(self) -> None:
        try:
            prepare_picture()
            self._plan_opening()
        finally:
            loaded()
        self.planned.wait(PLAN_TIMEOUT)
        self._load()
        try:
            compiling.begin(spare=1)  # for the tabs
            while not compiling.wait(NOTICE_DELAY):
                self._tell(*_words(compiling.share_done(), compiling.time_left()))
            self._call_kernels()
            if self.planned.is_set():
                self._warm_reader()
        finally:
            with self._lock:
                self._done = True
                self._clients.clear()
                for notice in self._notices:
                    notice.remove()
                self._notices.clear()

    def _plan_opening(self) -> None:
        """Plan the opening scene, unless a tab has done so."""
        from abi.planner.foreseen import kernels_foreseen
        from abi.planner.live_planner import LivePlanner

        with self._opening.claim(self._scene) as mine:
            if not mine or self._opening.find(self._scene) is not None:
                return
            if foreseen := kernels_foreseen(self._scene):
                compiling.foresee(foreseen)
            plan = LivePlanner()(self._scene)
            # as of a tab: of code that is not compiled the times say nothing
            plan = replace(plan, ms=MappingProxyType(dict.fromkeys(plan.ms, 0.0)), total_ms=0.0)
            self._opening.keep(self._scene, plan)
        self.planned.set()

    def _load(self) -> None:
        """Load the kernels kept by an earlier run, then make the bodies of the arm."""
        from app.layers.arm.arm import prepare_bodies

        compiling.begin()
        compiling.wait_for_kept()
        compiling.wait_for_loading()
        found = self._opening.find(self._scene)
        if found is not None and found.arm is not None:
            prepare_bodies(found.arm)

    @staticmethod
    def _call_kernels() -> None:
        """Plan once, since first calls take milliseconds that would be shown as a search's time."""
        from abi.planner.planner import plan
        from abi.scene.scene import load_scene

        plan(load_scene("paper"))

    @staticmethod
    def _warm_reader() -> None:
        """Start the reader process, which takes two seconds."""
        from app.reading.reader import READER

        with contextlib.suppress(OSError):  # the first file tries again
            READER.warm()

    def _tell(self, title: str, body: str) -> None:
        """Show the progress of compilation in all tabs."""
        with self._lock:
            first, self._told = self._told is None, (title, body)
            if first:
                for client in self._clients:
                    self._notify(client, title, body)
            else:
                for notice in self._notices:
                    notice.title, notice.body = title, body

    def _notify(self, client: viser.ClientHandle, title: str, body: str) -> None:
        self._notices.append(
            client.add_notification(title, body, loading=True, auto_close_seconds=None)
        )


def _words(share: float | None, left: str) -> tuple[str, str]:
    """Title and text of the notice, from the share that is compiled and the time that is left."""
    done = "" if share is None else f": {share:.0%} are done"
    return (
        f"First start: {f'faster in about {left}' if left else 'getting faster'}",
        f"The program is being compiled, once on this machine{done}. What this scene needs comes "
        "first. Meanwhile everything works but fine meshes, which wait for it.",
    )


def prepare_picture() -> None:
    """Import what a tab needs, and build the slowest part of its first page.

    The arm's solids would take the interpreter from the first plan, which comes before them.
    """
    importlib.import_module("app.tab.session")
    from app.panels.teach.figures import paper_text

    paper_text()
