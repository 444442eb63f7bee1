"""Exact meshes of an arm by coal, and OMPL's RRTConnect, for MotionBenchMaker's problems."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any

import numpy as np

from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.robot.urdf_arm import UrdfArm

_EVERY = 4
_SECONDS = 5.0
"""Processor time that OMPL may take: by the clock it would find less on a busy machine, [s]."""
_RESOLUTION = 0.02
"""Way between two poses that OMPL tests on an edge, [rad]."""


def poses_touching(arm: UrdfArm, obstacles: ObstacleSet, positions: FloatArray) -> int:
    """Number of poses, of every fourth of some (k, n), at which a mesh touches an obstacle."""
    import coal

    from benchmarks.mesh_oracle import obstacle_object

    solids = [obstacle_object(one) for one in obstacles]
    request, touching = coal.CollisionRequest(), 0
    for poses in arm.chain.poses(positions[::_EVERY] / arm.scales):
        links = [
            coal.CollisionObject(mesh, _transform(poses, frame, pose))
            for mesh, frame, pose in _meshes(arm)
        ]
        touching += any(
            coal.collide(link, solid, request, coal.CollisionResult())
            for link in links
            for solid in solids
        )
    return touching


@lru_cache(maxsize=4)
def _meshes(arm: UrdfArm) -> list[tuple[Any, int, FloatArray]]:
    """Every mesh of a link, the joint that moves it, and its pose in that frame."""
    from benchmarks.mesh_oracle import geometry

    return [
        (geometry(shape), frame, arm.chain.places[link] @ shape.pose)
        for link, frame in arm.chain.frames.items()
        for shape in arm.chain.robot.links[link].shapes
    ]


def _transform(poses: FloatArray, frame: int, pose: FloatArray) -> Any:
    """World from shape at one pose of the arm, (m + 1, 3, 4)."""
    import coal

    world = pose if frame < 0 else np.vstack([poses[frame], [0, 0, 0, 1]]) @ pose
    return coal.Transform3s(world[:3, :3].copy(), world[:3, 3].copy())


def ompl_length(space: JointSpace, start: FloatArray, goal: FloatArray) -> float:
    """Length of OMPL's path with simplification, [rad]; inf if it finds none in its time."""
    check = partial(_is_clear, space)
    path = ompl_path(check, space.arm.limits, start, goal, _RESOLUTION)
    if path is None:
        return float("inf")
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def _is_clear(space: JointSpace, pose: FloatArray) -> bool:
    """Whether a pose (n,) of the joints is clear."""
    return space.clear(np.stack([pose, pose]))


def ompl_path(
    is_clear: Callable[[FloatArray], bool],
    limits: FloatArray,
    start: FloatArray,
    goal: FloatArray,
    step: float,
) -> FloatArray | None:
    """Path of OMPL's RRTConnect with simplification, (k, n), [rad]; None if it finds none.

    Args:
        is_clear: of a pose (n,).
        limits: of the joints, (n, 2), [rad].
        start: pose at the start, (n,), [rad].
        goal: pose at the goal, (n,), [rad].
        step: way between two poses that are tested on an edge, [rad].
    """
    from ompl import base, geometric, util

    util.setLogLevel(util.LOG_NONE)
    count = len(start)
    joints = base.RealVectorStateSpace(count)
    bounds = base.RealVectorBounds(count)
    for k, (low, high) in enumerate(limits.tolist()):
        bounds.setLow(k, low)
        bounds.setHigh(k, high)
    joints.setBounds(bounds)
    setup = geometric.SimpleSetup(joints)
    setup.setStateValidityChecker(partial(_is_valid, is_clear, count))
    setup.getSpaceInformation().setStateValidityCheckingResolution(step / joints.getMaximumExtent())
    ends = []
    for pose in (start, goal):
        state = joints.allocState()
        for k, value in enumerate(pose.tolist()):
            state[k] = value
        ends.append(state)
    setup.setStartAndGoalStates(*ends)
    setup.setPlanner(geometric.RRTConnect(setup.getSpaceInformation()))
    end = time.thread_time() + _SECONDS
    over = base.PlannerTerminationCondition(partial(_is_over, end))
    if not setup.solve(over) or not setup.haveExactSolutionPath():
        return None
    setup.simplifySolution()
    states = setup.getSolutionPath().getStates()
    return np.array([[state[k] for k in range(count)] for state in states])


def _is_over(end: float) -> bool:
    """Whether this thread's processor time has come to an end, [s]."""
    return time.thread_time() > end


def _is_valid(is_clear: Callable[[FloatArray], bool], count: int, state: Any) -> bool:
    """Whether a state of OMPL is clear."""
    return is_clear(np.array([state[k] for k in range(count)]))
