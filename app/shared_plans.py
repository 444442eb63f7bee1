"""Plans that other tabs need, too: of the scenes that a teacher shows to all."""

from __future__ import annotations

import threading
from collections import deque

from abi import compiling
from abi.planner.plan import Plan
from abi.scene.scene import Scene

_KEPT = 3
_MAX_NODES = 30_000
"""Nodes of a mesh that is kept; a larger one takes much memory."""


class SharedPlans:
    """The last few full plans; may be asked from any thread, as a plan never changes."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._plans: deque[tuple[bool, Plan]] = deque(maxlen=_KEPT)

    def find(self, scene: Scene) -> Plan | None:
        """The plan of an equal scene; None without one, or with one from before compilation."""
        with self._lock:
            plans = tuple(self._plans)
        compiled = compiling.is_done()
        return next((plan for key, plan in plans if key == compiled and plan.scene == scene), None)

    def keep(self, plan: Plan) -> None:
        """Keep a full plan for others, unless it is large."""
        if plan.mesh is None or len(plan.mesh.points) > _MAX_NODES:
            return
        with self._lock:
            self._plans.appendleft((compiling.is_done(), plan))
