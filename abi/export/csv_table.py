"""The motion as comma-separated values (RFC 4180), one row per sample."""

from __future__ import annotations

import csv
import io

import numpy as np

from abi.export.joint_trajectory import motion_of
from abi.planner.plan import Plan


def write(plan: Plan, name: str) -> bytes:
    """Write time, joints, tool position and tool velocity, with units in the header.

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
    table.writerow(["time [s]", *joints, *places, *speeds])
    columns = motion.time[:, None], motion.positions, motion.tool, motion.velocity
    table.writerows(np.hstack(columns).tolist())
    return text.getvalue().encode()
