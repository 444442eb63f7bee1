"""The arm as URDF, in metres."""

from __future__ import annotations

from abi.arm.arm import urdf
from abi.errors import ExportError
from abi.planner.plan import Plan


def write(plan: Plan, name: str) -> bytes:
    """The arm with the plan's link lengths, at the origin of its root link.

    Raises:
        ExportError: the plan has no arm.
    """
    if plan.arm is None:
        raise ExportError("There is no arm to export: the scene was not planned.")
    return urdf(plan.arm).encode()
