"""Planner of one tab, which records its plans and shares those of a class."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping
from dataclasses import replace

from abi import compiling, progress
from abi.compiled import interpreted_calls
from abi.planner.live_planner import LivePlanner
from abi.planner.node_budget import NodeBudget
from abi.planner.plan import Plan
from abi.scene.scene import Scene
from app.process import metrics
from app.shared.shared_plans import SharedPlans
from app.tab.plan_watch import PlanWatch

_log = logging.getLogger("abi.tab")

LOGGED_MS = 1000.0
"""Milliseconds beyond which a plan is logged."""


class TabPlanner:
    """A :class:`LivePlanner` whose plans appear in metrics and log.

    What runs before its code is compiled says nothing of the method: in a plan the times of such
    stages are 0, and of such a plan that of the whole is.

    Attributes:
        live: the planner itself.
        processor_ms: time that the last plan took of the processor, [ms]; while many tabs plan at
            once it may have waited much longer, for which the plan can do nothing.
    """

    def __init__(self, tab: int, watch: PlanWatch) -> None:
        """Begin with empty caches, for the tab with this number, whose plans are watched.

        Each plan raises :class:`abi.progress.CancelledError` once something else has been chosen.
        """
        self.live = LivePlanner()
        self._watch = watch
        self._tab = tab
        self._ms: Mapping[str, float] = {}
        self.processor_ms = 0.0

    def take(self, scene: Scene, shared: SharedPlans, full: bool = False) -> Plan | None:
        """The plan of ``scene`` that another tab has made, a ``full`` one if requested; or None."""
        if (found := shared.find(scene, full)) is None:
            return None
        self.live.adopt(scene, found.coarse, found.partial)
        self._ms, self.processor_ms = found.plan.ms, found.plan.total_ms
        compiling.begin()
        return found.plan

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
                    shared.keep(scene, plan, self.live.coarse, self.live.partial)
                    return plan
            self._watch.begin()
            with progress.watched_by(self._watch.cancelled, self._watch.told):
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
        self._watch.begin()
        try:
            with progress.watched_by(self._watch.cancelled, self._watch.told):
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
