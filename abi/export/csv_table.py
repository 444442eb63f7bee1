"""The motion as comma-separated values (RFC 4180), one row per sample."""

from __future__ import annotations

import csv
import io

import numpy as np

from abi.export.joint_trajectory import is_marked, motion_of, motion_state
from abi.planner.plan import Plan


def write(plan: Plan, name: str) -> bytes:
    """Write time, joints, tool position and tool velocity, with units in the header.

    A motion that is not proven clear, or passes limits, says so in one more column.

    Raises:
        ExportError: there is no motion.
    """
    motion, unit = motion_of(plan), plan.scene.unit
    named = zip(motion.joints, motion.slides, strict=True)
    joints = [f"{joint} [{unit if slides else 'rad'}]" for joint, slides in named]
    places = [f"{axis} [{unit}]" for axis in "xyz"]
    speeds = [f"v{axis} [{unit}/s]" for axis in "xyz"]
    text = io.StringIO(newline="")
    table = csv.writer(text)
    state = motion_state(plan) if is_marked(plan) else ""
    table.writerow(["time [s]", *joints, *places, *speeds, *filter(None, [state and "state"])])
    columns = motion.time[:, None], motion.positions, motion.tool, motion.tool_velocity
    rows = np.hstack(columns).tolist()
    table.writerows([[*row, state] for row in rows] if state else rows)
    return text.getvalue().encode()
