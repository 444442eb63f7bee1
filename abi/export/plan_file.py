"""The whole plan as JSON: what ``abi plan --full`` prints, for ``abi verify`` and scripts."""

from __future__ import annotations

import json

from abi.planner.plan import Plan


def write(plan: Plan, name: str) -> bytes:
    """Write the plan with its mesh and every sample; an incomplete plan says why."""
    return (json.dumps(plan.to_dict(full=True), indent=1, allow_nan=False) + "\n").encode()
