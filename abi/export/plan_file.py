"""The whole plan as JSON: what ``abi plan --full`` prints, for ``abi verify`` and scripts."""

from __future__ import annotations

import json

from abi.export.joint_trajectory import motion_state
from abi.planner.plan import Plan
from abi.planner.task_plan import TaskPlan


def write(plan: Plan, name: str) -> bytes:
    """Write the plan with its mesh and every sample; an incomplete plan says why.

    ``arm.state`` says whether the motion is proven clear.
    """
    data = plan.to_dict(full=True)
    if data["arm"] is not None:
        data["arm"]["state"] = motion_state(plan)
    return (json.dumps(data, indent=1, allow_nan=False) + "\n").encode()


def write_tasks(plan: TaskPlan) -> bytes:
    """Write the plans of all legs with every sample, and the motion that they join to."""
    return (json.dumps(plan.to_dict(full=True), indent=1, allow_nan=False) + "\n").encode()
