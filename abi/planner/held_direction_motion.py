"""Motions in the space of the joints that keep the direction of the tool for a part of their time.

When a motion is where is known only once it has been found: a path is sought whose part by length
is as asked. Where its part by time is too short, the motion is slower there; where that is not
enough, another path with a longer part is sought.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from abi.arm_planning.arm_errors import direction_not_held, no_joint_motion
from abi.arm_planning.joint_search.held_direction import HeldDirection
from abi.arm_planning.joint_search.held_path import path_holding
from abi.arm_planning.joint_search.held_search import HeldSearch
from abi.arm_planning.joint_search.joint_motion import passage_of, proven_motion
from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arm_planning.joint_search.joint_spline import JointSpline, spline_near
from abi.arm_planning.joint_search.search_joints import JointSearch, JointSearchEffort
from abi.arm_planning.motion.arm_clearance import is_clear
from abi.arm_planning.motion.urdf_motion import ChainJointPath
from abi.arm_planning.motion_law import motion_law
from abi.arrays import FloatArray
from abi.planner.plan import Plan
from abi.planner.planning_problem import sample_count
from abi.robot.urdf_arm import UrdfArm
from abi.scene.scene import Scene
from abi.scene.settings import MotionSettings

_TRIES, _PAIRS = 16, 4
"""Paths, at most, that are sought, and pairs of a start and a goal between which they are."""
_FACTORS = (1.0, 1.5, 2.25, 3.5, 5.0, 8.0)
"""Times as slow as elsewhere that the motion may be in the part, to take as much time as it has to.
"""
_LONGER = 0.02
"""Share of the way by which the part is longer, at either end, than it was too short by."""
_PLACES = 2001
"""Places of a curve among which the one nearest to a pose is found."""
_SAMPLES = 401
"""Samples of a motion by which it is timed."""


def move_holding(
    hold: HeldDirection,
    space: JointSpace,
    scene: Scene,
    ends: tuple[FloatArray, FloatArray],
    effort: JointSearchEffort,
) -> Plan:
    """Plan of a motion alone that keeps a direction during a part of it, all of it proven clear.

    Args:
        hold: the direction, and when it is kept.
        space: the arm and what it keeps clear of.
        scene: the scene.
        ends: joint positions (k, n) at the start, and at the goal, that are clear.
        effort: how long to search.

    Raises:
        NoJointMotion: none was found, or the joints are at the goal already.
    """
    held, (starts, goals) = HeldSearch(space, hold), ends
    starts = _aligned(hold, "start", starts) if hold.begin == 0 else starts
    goals = _aligned(hold, "goal", goals) if hold.end == 1 else goals
    nearest = _nearest_pairs(space, starts, goals)
    for pair in nearest:
        tries = range(effort.seed, effort.seed + _TRIES // len(nearest))
        efforts = [replace(effort, seed=seed) for seed in tries]
        found = _between(hold, held, scene, pair, efforts)
        if found is not None:
            return found
    raise direction_not_held("path", hold.tolerance, (hold.begin, hold.end))


def _between(
    hold: HeldDirection,
    held: HeldSearch,
    scene: Scene,
    pair: tuple[FloatArray, FloatArray],
    efforts: Sequence[JointSearchEffort],
) -> Plan | None:
    """Plan of a motion from a start to a goal, (1, n) each; None where no effort leads to one."""
    asked, space = (hold.begin, hold.end), held.space
    if (pair[0] == pair[1]).all():
        raise no_joint_motion("same")
    for effort in efforts:
        found = path_holding(held, asked, *pair, effort)
        if found is None:
            continue
        search, inner = found
        assert search.path is not None
        spline = spline_near(space, search.path)
        if spline is None:
            continue
        short = (0.0, 0.0)
        for factor in _FACTORS:
            passage = _passage(inner, space.arm, factor, spline)
            lacks = _shorter_by(hold, _part_of(inner, passage, scene.motion))
            if lacks is None:
                moved = _moved(hold, space, scene, (search, inner), factor)
                if moved is not None:
                    return moved
                break
            if lacks == short:  # the law is as fast as the joints' limits let it, whatever the way
                break
            short = lacks
        asked = _longer(asked, short)
    return None


def _nearest_pairs(
    space: JointSpace, starts: FloatArray, goals: FloatArray
) -> list[tuple[FloatArray, FloatArray]]:
    """A few pairs of a start and a goal, (1, n) each, whose joints are nearest to each other."""
    away = np.linalg.norm((starts[:, None] - goals) * space.weights, axis=2)
    best = np.argsort(away, axis=None, kind="stable")[:_PAIRS]
    rows = zip(*np.unravel_index(best, away.shape), strict=True)
    return [(starts[i : i + 1], goals[j : j + 1]) for i, j in rows]


def _aligned(hold: HeldDirection, end: str, poses: FloatArray) -> FloatArray:
    """Those joint positions (k, n) that keep the direction.

    Raises:
        NoJointMotion: there are none.
    """
    angles, tolerance = hold.angles(poses), hold.tolerance
    if angles.min() > tolerance:
        raise direction_not_held(end, tolerance, (hold.begin, hold.end), float(angles.min()))
    return np.asarray(poses[angles <= tolerance])


def _passage(inner: FloatArray, arm: UrdfArm, factor: float, spline: JointSpline) -> ChainJointPath:
    """The way along a curve, so many times as slow between its places nearest to two poses."""
    places = np.linspace(0.0, 1.0, _PLACES)
    positions = spline(places)
    begin, end = (float(places[np.abs(positions - row).sum(axis=1).argmin()]) for row in inner)
    return passage_of(spline, arm, (begin, end), factor if end > begin else 1.0)


def _part_of(
    inner: FloatArray, passage: ChainJointPath, settings: MotionSettings
) -> tuple[float, float]:
    """Shares of a motion's time at which it is nearest to two poses (2, n)."""
    positions = _timed(passage, settings)
    begin, end = (int(np.abs(positions - row).sum(axis=1).argmin()) for row in inner)
    return begin / (_SAMPLES - 1), end / (_SAMPLES - 1)


def _shorter_by(hold: HeldDirection, at: tuple[float, float]) -> tuple[float, float] | None:
    """Shares of time by which a part is too short at both ends; None where it is long enough."""
    late = at[0] - hold.begin if hold.begin > 0 else 0.0
    early = hold.end - at[1] if hold.end < 1 else 0.0
    return (max(late, 0.0), max(early, 0.0)) if max(late, early) > 0 else None


def _longer(part: tuple[float, float], by: tuple[float, float]) -> tuple[float, float]:
    """A part by length that is longer, if need be by half of what is left before and after it."""
    begin, end = part
    before, after = by
    return max(begin - before - _LONGER, begin / 2), min(end + after + _LONGER, (1 + end) / 2)


def _moved(
    hold: HeldDirection,
    space: JointSpace,
    scene: Scene,
    found: tuple[JointSearch, FloatArray],
    factor: float,
) -> Plan | None:
    """Plan of a motion along a smooth curve near a path.

    ``found`` is the search that found the path, and the joints where the part of it begins and ends
    (2, n).

    Returns:
        None if no motion is clear and keeps the direction.
    """
    search, inner = found
    assert search.path is not None
    way = partial(_passage, inner, space.arm, factor)
    lack = partial(_lack, hold, scene.motion, way)
    spline = spline_near(space, search.path, lack=lack)
    if spline is None:
        return None
    passage = way(spline)
    profile = motion_law(passage, scene.motion)
    count = sample_count(profile, scene.motion)
    around = space.collision_world, space.margin
    motion, clearance = proven_motion(passage, profile, count, *around)
    if not is_clear(motion, clearance) or hold.fault(motion.positions) is not None:
        return None
    return Plan(scene, profile=profile, motion=motion, arm_clearance=clearance, joint_search=search)


def _lack(
    hold: HeldDirection,
    settings: MotionSettings,
    way: Callable[[JointSpline], ChainJointPath],
    spline: JointSpline,
) -> float | None:
    """Parameter at which a motion along a curve keeps the direction least; None if it is kept."""
    positions = _timed(way(spline), settings)
    row = hold.fault(positions)
    if row is None:
        return None
    places = np.linspace(0.0, 1.0, _PLACES)
    away = np.abs(spline(places) - positions[row]).sum(axis=1)
    return float(places[away.argmin()])


def _timed(passage: ChainJointPath, settings: MotionSettings) -> FloatArray:
    """Joint positions at uniform times of a motion by the law that is asked for."""
    profile = motion_law(passage, settings)
    return passage.at(profile(np.linspace(0.0, profile.duration, _SAMPLES)))
