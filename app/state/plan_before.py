"""The plan before a drag, for comparison with the present one."""

from __future__ import annotations

from abi.planner.plan import Plan
from app.state.frame import Frame


class PlanBefore:
    """Keeps the last plan at rest that is not the present one."""

    def __init__(self) -> None:
        self._rested: Plan | None = None
        self._before: Plan | None = None

    def follow(self, frame: Frame) -> Plan | None:
        """Take the next frame; the plan at rest before its plan, None if there was none."""
        if frame.plan is not self._rested:
            self._before = self._rested
            if not (frame.interactive or frame.partial or frame.outdated):
                self._rested = frame.plan
        return self._before
