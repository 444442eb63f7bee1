"""Diagnoses of plans, made once for all tabs that show the plan."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable

from abi.explain.diagnosis import explain
from abi.explain.reason import Reason
from abi.planner.plan import Plan


class Diagnoses:
    """Reasons of failed plans, kept as long as the plans; thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._reasons: weakref.WeakKeyDictionary[Plan, Reason | None] = weakref.WeakKeyDictionary()
        self._begun: weakref.WeakSet[Plan] = weakref.WeakSet()

    def make(self, plan: Plan, interrupted: Callable[[], bool]) -> bool:
        """Diagnose ``plan``, which takes about as long as ten plans; whether it is diagnosed now.

        It is not where input has ``interrupted``, or while another tab is at it: ask again later.
        """
        with self._lock:
            if plan in self._reasons or plan in self._begun:
                return plan in self._reasons
            self._begun.add(plan)
        try:
            reason = explain(plan.scene, plan, interrupted)
            if interrupted():
                return False
            with self._lock:
                self._reasons[plan] = reason
            return True
        finally:
            with self._lock:
                self._begun.discard(plan)

    def reason(self, plan: Plan) -> Reason | None:
        """Reason of a diagnosed plan; None if there is none."""
        with self._lock:
            return self._reasons.get(plan)


DIAGNOSES = Diagnoses()
"""The diagnoses of this process."""
