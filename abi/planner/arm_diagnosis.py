"""Diagnosis of a scene in which only the arm has no motion: changes that work, each tried."""

from __future__ import annotations

from typing import Any

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.errors import ArmNotClear, format_length
from abi.planner.plan import Plan
from abi.planner.reason import Reason
from abi.planner.what_if import WhatIf
from abi.scene.scene import Scene

_STEPS = (1.0, 2.0, 4.0)
"""Ways by which the base is moved, in steps of an eleventh of the arm's length."""
_WAYS = ((1, 0, 0), (-1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, 1), (0, 0, -1))


def arm_reason(scene: Scene, plan: Plan, error: ArmNotClear, what_if: WhatIf) -> Reason:
    """Find which link touches what, and a change that helps.

    In this order it tries both elbows, links nearer to the obstacles, another base, and finer
    pitches; also the scene without each obstacle.

    Raises:
        CancelledError: the caller has cancelled the trials.
    """
    points = _places(scene, plan, error)
    for remedy, change in _remedies(scene, plan, error, what_if):
        if what_if.plan_past("arm", **change):
            hint = f"{remedy} works: it has been tried."
            return Reason(error.message, hint, change, points)
    without = [
        k
        for k in range(len(scene.obstacles))
        if what_if.plan_past("arm", obstacles=_all_but(scene, k))
    ]
    if without:
        named = " or ".join(str(k + 1) for k in without)
        hint = f"Without obstacle {named} there is a motion: move it out of the way."
        return Reason(error.message, hint, None, points)
    hint = "Neither another elbow, base or pitch that was tried helps, nor one obstacle less."
    return Reason(error.message, hint, None, points)


def _remedies(
    scene: Scene, plan: Plan, error: ArmNotClear, what_if: WhatIf
) -> list[tuple[str, dict[str, Any]]]:
    """Changes to try, and the beginnings of sentences on them."""
    remedies: list[tuple[str, dict[str, Any]]] = []
    if not error.has_elbow:
        if scene.arm.axis is not None:
            remedies.append(("The direction of the tool left free", {"arm": {"axis": None}}))
    elif scene.arm.elbow != "auto":
        other = "down" if scene.arm.elbow == "up" else "up"
        remedies.append((f"The elbow {other}", {"arm": {"elbow": other}}))
    if scene.arm.clearance > 0:
        text = f"Links that may be as near as 0, not {format_length(scene.arm.clearance)},"
        remedies.append((text, {"arm": {"clearance": 0.0}}))
    for base in _bases(scene, plan):
        place = ", ".join(f"{number:g}" for number in base)
        remedies.append((f"The base at ({place})", {"arm": {"base": base, "elbow": "auto"}}))
    if error.where in ("path", "curve"):
        for fine in what_if.finer_pitches():
            remedies.append((f"A pitch of {format_length(fine)}", {"mesh": {"pitch": fine}}))
    return remedies


def _bases(scene: Scene, plan: Plan) -> list[list[float]]:
    """Places for the base, the nearest first."""
    step = (1.0 if plan.arm is None else plan.arm.reach) / 11
    moves = [scale * step * np.array(way) for scale in _STEPS for way in _WAYS]
    return [[float(f"{number:.3g}") for number in np.add(scene.arm.base, move)] for move in moves]


def _all_but(scene: Scene, left_out: int) -> list[Any]:
    return [one for k, one in enumerate(scene.obstacles) if k != left_out]


def _places(scene: Scene, plan: Plan, error: ArmNotClear) -> FloatArray:
    """Where the tool is when the arm is in the way, (k, 3), [unit], world."""
    if error.where in ("start", "goal"):
        places = [scene.start if error.where == "start" else scene.goal]
    elif plan.motion is not None and plan.arm_clearance is not None:
        motion, contacts = plan.motion, plan.arm_clearance.contacts[:1]
        rows = [int(np.searchsorted(motion.time, contact.time)) for contact in contacts]
        return read_only(motion.tool[rows].reshape(-1, 3).copy())
    else:
        places = []
    return read_only(np.array(places, dtype=float).reshape(-1, 3))
