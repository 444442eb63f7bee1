"""The motion as comma-separated values (RFC 4180), one row per sample."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

import numpy as np

from abi.export.joint_trajectory import holding, is_marked, motion_of, motion_state
from abi.planner.plan import Plan

_PLACES, _SPEEDS, _STATE = ("x", "y", "z"), ("vx", "vy", "vz"), "state"


def write(plan: Plan, name: str) -> bytes:
    """Write time, joints, tool position and tool velocity, with units in the header.

    A motion that is not proven clear, passes limits, or whose tool holds something says so in one
    more column. Where a joint
    is called as that or a column of the tool is, these are called ``tool_x`` and the like.

    Raises:
        AbiError: there is no motion.
    """
    motion, unit = motion_of(plan), plan.scene.unit
    named = zip(motion.joints, motion.slides, strict=True)
    joints = [f"{joint} [{unit if slides else 'rad'}]" for joint, slides in named]
    before = _before_tool(plan, motion.joints)
    places = [f"{before}{axis} [{unit}]" for axis in _PLACES]
    speeds = [f"{before}{axis} [{unit}/s]" for axis in _SPEEDS]
    text = io.StringIO(newline="")
    table = csv.writer(text)
    state = motion_state(plan) if is_marked(plan) or holding(plan) else ""
    marks = [f"{before}{_STATE}"] if state else []
    table.writerow(["time [s]", *joints, *places, *speeds, *marks])
    columns = motion.time[:, None], motion.positions, motion.tool, motion.tool_velocity
    rows = np.hstack(columns).tolist()
    table.writerows([[*row, state] for row in rows] if state else rows)
    return text.getvalue().encode()


def _before_tool(plan: Plan, moving: Sequence[str]) -> str:
    """What tells columns of the tool from joints of the robot, also from those that stand still."""
    arm, before = plan.arm, ""
    names = {*moving, *(() if arm is None else arm.chain.held)}
    while names & {f"{before}{name}" for name in (*_PLACES, *_SPEEDS, _STATE)}:
        before += "tool_"
    return before
