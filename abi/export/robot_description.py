"""The arm as URDF, in metres."""

from __future__ import annotations

from abi.errors import ExportError
from abi.planner.plan import Plan


def write(plan: Plan, name: str) -> bytes:
    """Write the arm, with its root link at the origin: the paper's arm, or the URDF it came from.

    Raises:
        ExportError: the plan has no arm.
    """
    if plan.arm is None:
        raise ExportError("There is no arm to export: the scene was not planned.")
    return plan.arm.description().encode()
