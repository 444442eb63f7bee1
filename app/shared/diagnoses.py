"""Reasons of failed plans, each found once for all tabs that show the plan, and kept as long."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable

from abi.explain.diagnosis import explain
from abi.explain.reason import Reason
from abi.planner.plan import Plan

_lock = threading.Lock()
_reasons: weakref.WeakKeyDictionary[Plan, Reason | None] = weakref.WeakKeyDictionary()
_begun: weakref.WeakSet[Plan] = weakref.WeakSet()


def diagnose(plan: Plan, interrupted: Callable[[], bool]) -> bool:
    """Diagnose ``plan``, which takes about as long as ten plans; whether it is diagnosed now.

    It is not where input has ``interrupted``, or while another tab is at it: ask again later.
    """
    with _lock:
        if plan in _reasons or plan in _begun:
            return plan in _reasons
        _begun.add(plan)
    try:
        reason = explain(plan.scene, plan, interrupted)
        if interrupted():
            return False
        with _lock:
            _reasons[plan] = reason
        return True
    finally:
        with _lock:
            _begun.discard(plan)


def reason_of(plan: Plan) -> Reason | None:
    """Reason of a diagnosed plan; None if there is none."""
    with _lock:
        return _reasons.get(plan)
