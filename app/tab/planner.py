"""Planner of one tab, which records its plans and shares those of a class.

Another choice ends a plan that is being made, and a slow one reports its progress.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import replace

from abi import compiling, progress
from abi.compiled import interpreted_calls
from abi.planner.live_planner import LivePlanner
from abi.planner.node_budget import NodeBudget
from abi.planner.plan import Plan
from abi.scene.scene import Scene
from app.process import metrics
from app.shared.shared_plans import SharedPlans

_log = logging.getLogger("abi.tab")

LOGGED_MS = 1000.0
"""Milliseconds beyond which a plan is logged."""
_QUICK = 0.4
"""Seconds of planning without a progress report."""


class TabPlanner:
    """A :class:`LivePlanner` whose plans appear in metrics and log.

    What runs before its code is compiled says nothing of the method: in a plan the times of such
    stages are 0, and of such a plan that of the whole is.

    Attributes:
        live: the planner itself.
        overtaken: whether something else has been chosen than what is planned; set from any thread.
        ended: moment at which a plan was told so last, [s], by the monotonic clock.
        processor_ms: time that the last plan took of the processor, [ms]; while many tabs plan at
            once it may have waited much longer, for which the plan can do nothing.
    """

    def __init__(self, tab: int, tell: Callable[[str], None]) -> None:
        """Begin with empty caches, for the tab with this number.

        Each plan raises :class:`abi.progress.CancelledError` once something else has been chosen;
        ``tell`` is called with the progress of a slow one.
        """
        self.live = LivePlanner()
        self.overtaken = False
        self.ended = 0.0
        self._tell = tell
        self._begun = 0.0
        self._does = self._said = ""
        self._tab = tab
        self._ms: Mapping[str, float] = {}
        self.processor_ms = 0.0

    def take(self, scene: Scene, shared: SharedPlans, full: bool = False) -> Plan | None:
        """The plan of ``scene`` that another tab has made, a ``full`` one if requested; or None."""
        if (found := shared.find(scene, full)) is None:
            return None
        self.live.adopt(scene, found.partial)
        self._ms, self.processor_ms = found.ms, found.total_ms
        compiling.begin()
        return found

    def __call__(self, scene: Scene, shared: SharedPlans | None) -> Plan:
        """Plan within a frame if possible; ``shared`` plans are offered to other tabs.

        What another of them plans at this moment is waited for, and taken.
        """
        if shared is None:
            return self._make(self.live, scene)
        while True:
            with shared.claim(scene) as mine:
                if mine:
                    plan = self._make(self.live, scene)
                    shared.keep(scene, plan)
                    return plan
            with self._watched():
                shared.wait(scene)
            if (made := self.take(scene, shared)) is not None:
                return made

    def finish(self, scene: Scene, shared: SharedPlans | None = None) -> Plan:
        """Plan in full, however long it takes, or take the full plan that another tab has made."""
        if shared is not None and (made := self.take(scene, shared, full=True)) is not None:
            return made
        plan = self._make(self.live.finish, scene)
        if shared is not None:
            shared.keep(scene, plan)
        return plan

    def _make(self, planner: Callable[[Scene], Plan], scene: Scene) -> Plan:
        """Make a plan and record it."""
        begin, before = time.thread_time(), interpreted_calls()
        try:
            with self._watched():
                compiling.wait_for_kept()
                plan = planner(scene)
        except progress.CancelledError:
            self.live.forget()  # of what was under way there may be a half
            raise
        self.processor_ms = 1e3 * (time.thread_time() - begin)
        compiling.begin()  # the next plan, of whichever tab, waits for kernels that are there
        metrics.observe_plan(plan.total_ms / 1e3, self._ms, plan.ms)
        self._ms = plan.ms
        if plan.total_ms > LOGGED_MS:
            nodes = 0 if plan.mesh is None else len(plan.mesh.points)
            fields = {"tab": self._tab, "ms": plan.total_ms, "nodes": nodes}
            _log.info("slow plan", extra=fields)
        if interpreted_calls() > before:
            self.live.budget = NodeBudget()  # nothing is to be learnt from such times
            plan = replace(plan, total_ms=0.0)
        if plan.interpreted:
            plan = replace(plan, ms={**plan.ms, **dict.fromkeys(plan.interpreted, 0.0)})
        return plan

    def _watched(self) -> AbstractContextManager[None]:
        """Watch a plan that is made, or waited for, in the block."""
        self._begun = time.monotonic()
        self._does = self._said = ""
        return progress.watched_by(self._is_cancelled, self._told)

    def _is_cancelled(self) -> bool:
        """Check whether the plan is not wanted any more."""
        self._report()
        if self.overtaken:
            self.ended = time.monotonic()
        return self.overtaken

    def _told(self, doing: str) -> None:
        """Receive what the plan is doing now."""
        self._does = doing
        self._report()

    def _report(self) -> None:
        if self._does != self._said and time.monotonic() - self._begun > _QUICK:
            self._said = self._does
            self._tell(self._does)
