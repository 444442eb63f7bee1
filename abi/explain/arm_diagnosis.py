"""Diagnosis of a scene in which only the arm has no motion: changes that work, each tested."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np

from abi.arm_planning.arm_errors import ArmNotClear
from abi.arm_planning.motion.arm_clearance import Contact
from abi.arrays import FloatArray, read_only
from abi.errors import format_length, format_point
from abi.explain.reason import Reason
from abi.explain.what_if import WhatIf
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.obstacles.pose import rotation
from abi.planner.plan import Plan
from abi.scene.scene import Scene
from abi.scene.without_obstacles import without_obstacles

_STEPS = (1.0, 2.0, 4.0)
"""Displacements of the base to try, in steps of an eleventh of the arm's length."""
_SHIFTS = (1.0, 2.0, 4.0)
"""Displacements of an obstacle to try, in multiples of the contact's depth plus a margin."""
_MOVED = 3
"""Most obstacles that are moved: those with the deepest contacts."""
_LEAST = 0.01
"""Margin of a moved obstacle beyond the contact, over the arm's reach."""
_WAYS = ((1, 0, 0), (-1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, 1), (0, 0, -1))
_ALONG = 1e-6
"""Largest part of a displacement across the mounting surface that counts as along it."""


def arm_reason(scene: Scene, plan: Plan, error: ArmNotClear, what_if: WhatIf) -> Reason:
    """Find which link touches what, and a change that helps.

    Tried, in this order: both elbows, links nearer to the obstacles, the base elsewhere, finer
    pitches; each obstacle that is touched moved away, and each left out; if that helps, it is put
    past the arm that moves without it.

    Raises:
        CancelledError: the caller has cancelled the trials.
    """
    points = _places(scene, plan, error)
    for remedy, change in _remedies(scene, plan, error, what_if):
        if what_if.plan_past("arm", **change):
            hint = f"{remedy} works (tested)."
            return Reason(error.message, hint, change, points)
    without: dict[int, Plan] = {}
    for number, place in itertools.chain(_shifts(scene, plan), _past(scene, what_if, without)):
        change = {"obstacles": _with_moved(scene, number, place)}
        if what_if.plan_past("arm", **change):
            hint = f"Obstacle {number + 1} at {format_point(place)} works (tested)."
            return Reason(error.message, hint, change, points, moved=number)
    if without:
        named = " or ".join(str(k + 1) for k in without)
        hint = f"Without obstacle {named} there is a motion; no place for it that was tried works."
        return Reason(error.message, hint, None, points)
    hint = (
        "Neither another elbow, base or node spacing that was tried helps, nor one obstacle less."
    )
    return Reason(error.message, hint, None, points)


def _remedies(
    scene: Scene, plan: Plan, error: ArmNotClear, what_if: WhatIf
) -> list[tuple[str, dict[str, Any]]]:
    """Changes to try, and the beginnings of sentences about them."""
    remedies: list[tuple[str, dict[str, Any]]] = []
    if not error.has_elbow:
        if scene.arm.axis is not None:
            remedies.append(("The direction of the gripper left free", {"arm": {"axis": None}}))
    elif scene.arm.elbow != "auto":
        other = "down" if scene.arm.elbow == "up" else "up"
        remedies.append((f"The elbow {other}", {"arm": {"elbow": other}}))
    if scene.arm.clearance > 0:
        text = f"Links that may be as near as 0, not {format_length(scene.arm.clearance)},"
        remedies.append((text, {"arm": {"clearance": 0.0}}))
    has_other_side = error.has_elbow and scene.arm.elbow != "auto"
    elbow = {"elbow": "auto"} if has_other_side else {}
    for base in _bases(scene, plan):
        change = {"arm": {"base": base, **elbow}}
        remedies.append((f"The base at {format_point(base)}", change))
    if error.where in ("path", "curve"):
        for fine in what_if.finer_pitches():
            remedies.append((f"A node spacing of {format_length(fine)}", {"mesh": {"pitch": fine}}))
    return remedies


def _bases(scene: Scene, plan: Plan) -> list[list[float]]:
    """Places for the base, nearest first, on the floor or wall on which it stands."""
    step = (1.0 if plan.arm is None else plan.arm.reach) / 11
    across = rotation(scene.arm.base_wxyz)[:, 2]
    ways = [np.array(way) for way in _WAYS if abs(np.dot(way, across)) <= _ALONG]
    moves = [scale * step * way for scale in _STEPS for way in ways]
    return [[float(f"{number:.3g}") for number in np.add(scene.arm.base, move)] for move in moves]


def _shifts(scene: Scene, plan: Plan) -> list[tuple[int, list[float]]]:
    """Obstacles that the arm touches along the tool's own curve, and places to try for them.

    Each goes away from the link that is deepest in it, by depth and clearance and more.
    """
    motion, clearance, arm = plan.motion, plan.arm_clearance, plan.arm
    if motion is None or clearance is None or arm is None:
        return []
    deepest: dict[int, Contact] = {}
    for contact in clearance.contacts:
        if isinstance(contact.obstacle, int):
            deepest.setdefault(contact.obstacle, contact)
    step = arm.reach * _LEAST + clearance.required
    shifts = []
    for number, contact in list(deepest.items())[:_MOVED]:
        row = int(np.searchsorted(motion.time, contact.time))
        ends = arm.place(motion.positions[row : row + 1])[0]
        of_link = [link == contact.link for link in arm.capsule_links]
        obstacle = scene.obstacles[number]
        way = _way_out(obstacle, ends[of_link], step)
        for times in _SHIFTS:
            to = np.add(obstacle.position, times * (contact.depth + step) * way)
            shifts.append((number, [float(f"{coordinate:.3g}") for coordinate in to]))
    return shifts


def _past(
    scene: Scene, what_if: WhatIf, without: dict[int, Plan]
) -> Iterator[tuple[int, list[float]]]:
    """Obstacles without which there is a motion, which are added to ``without``, and places for
    them just past all that the arm sweeps in it, the nearest first.
    """
    for number, obstacle in enumerate(scene.obstacles):
        plan = what_if.plan_past("arm", **without_obstacles(scene, (number,)))
        if plan is None or plan.motion is None or plan.arm is None:
            continue
        without[number] = plan
        ends, radii = plan.arm.place(plan.motion.positions), plan.arm.radii[:, None]
        low = (ends.min(axis=(0, 2)) - radii).min(axis=0)
        high = (ends.max(axis=(0, 2)) + radii).max(axis=0)
        bottom, top = map(np.ravel, ObstacleSet((obstacle,)).bounds)
        room = plan.arm.reach * _LEAST + scene.arm.clearance + scene.spline.clearance
        ways = np.concatenate([np.diag(high - bottom + room), np.diag(low - top - room)])
        for way in ways[np.abs(ways).max(axis=1).argsort(kind="stable")]:
            to = np.add(obstacle.position, way)
            yield number, [float(f"{coordinate:.4g}") for coordinate in to]


def _way_out(obstacle: Obstacle, ends: FloatArray, step: float) -> FloatArray:
    """Unit vector (3,) along which an obstacle leaves the segments (k, 2, 3) of a link soonest."""
    moves = step * np.concatenate([np.eye(3), -np.eye(3)])
    moved = ends[:, None] - moves[:, None]  # as far as the segments go, so the obstacle stays
    gaps = ObstacleSet((obstacle,)).polyline_clearances(moved.reshape(-1, 2, 3))
    nearest = gaps.reshape(len(ends), 6).min(axis=0)
    slope = nearest[:3] - nearest[3:]
    size = float(np.linalg.norm(slope))
    return slope / size if size > 0 else np.array([0.0, 0.0, 1.0])


def _with_moved(scene: Scene, number: int, place: list[float]) -> list[Any]:
    data = [obstacle.model_dump(mode="json") for obstacle in scene.obstacles]
    data[number]["position"] = place
    return data


def _places(scene: Scene, plan: Plan, error: ArmNotClear) -> FloatArray:
    """Positions of the tool at which the arm is in the way, (k, 3), [unit], world."""
    if error.where in ("start", "goal"):
        places = [scene.start if error.where == "start" else scene.goal]
    elif plan.motion is not None and plan.arm_clearance is not None:
        motion, contacts = plan.motion, plan.arm_clearance.contacts[:1]
        rows = [int(np.searchsorted(motion.time, contact.time)) for contact in contacts]
        return read_only(motion.tool[rows].reshape(-1, 3).copy())
    else:
        places = []
    return read_only(np.array(places, dtype=float).reshape(-1, 3))
