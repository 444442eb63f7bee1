"""Plans shared by several tabs: of scenes that a teacher shows, or that all tabs open with."""

from __future__ import annotations

import contextlib
import threading
from collections import deque
from collections.abc import Iterator

from abi import progress
from abi.planner.plan import Plan
from abi.scene.scene import Scene

_KEPT = 4
_MAX_NODES = 30_000
"""Most nodes of a mesh that is kept; a larger one takes much memory."""


class SharedPlans:
    """The latest plans; thread-safe, as a plan never changes."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        # by what was to be planned: the plan's own scene may have a coarser mesh
        self._plans: deque[tuple[Scene, Plan]] = deque(maxlen=_KEPT)
        self._claims: list[tuple[Scene, threading.Event]] = []

    def find(self, scene: Scene, full: bool = False) -> Plan | None:
        """The plan of an equal scene, a ``full`` one if requested; None if there is none."""
        with self._lock:
            plans = tuple(self._plans)
        usable = [plan for asked, plan in plans if _equal(asked, scene)]
        wanted = (one for one in usable if not (full and one.partial))
        return min(wanted, key=lambda one: one.partial, default=None)

    def keep(self, scene: Scene, plan: Plan) -> None:
        """Keep a plan of ``scene`` for other tabs, unless it is large."""
        if plan.mesh is None or len(plan.mesh.points) > _MAX_NODES:
            return
        with self._lock:
            self._plans.appendleft((scene, plan))

    @contextlib.contextmanager
    def claim(self, scene: Scene) -> Iterator[bool]:
        """Claim to plan ``scene`` for others within the block; False if another tab has."""
        over = threading.Event()
        with self._lock:
            mine = not any(_equal(one, scene) for one, _ in self._claims)
            if mine:
                self._claims.append((scene, over))
        try:
            yield mine
        finally:
            if mine:
                with self._lock:
                    self._claims = [claim for claim in self._claims if claim[1] is not over]
                over.set()

    def wait(self, scene: Scene) -> None:
        """Wait for the tab that plans ``scene`` now, if its plan is still wanted.

        Raises:
            CancelledError: it is not; see :func:`abi.progress.watched_by`.
        """
        with self._lock:
            claims = [over for one, over in self._claims if _equal(one, scene)]
        for over in claims:
            progress.wait(over)


def _equal(a: Scene, b: Scene) -> bool:
    return a is b or a == b
