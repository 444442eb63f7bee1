"""OMPL's planners in an arm's joint space: the same capsules, floor, column, limits and ends.

Space is q1 within three quarters of a turn to each side of the middle between start and goal, and
q2 and q3 within their limits; starts and goals are the poses of both branches. A motion is tested
by one compiled call, in steps in which no point of the arm moves more than :data:`STEP`, by the
same distance of a segment to the obstacles that our lattices take.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numba
import numpy as np
from ompl import base, geometric, util

from abi.arrays import FloatArray
from abi.compilation.helpers import declare_helpers
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.packing import pack
from abi.obstacles.primitive_tree_kernels import blocked
from abi.obstacles.primitives import Capsule
from abi.robot.paper_arm.link_capsules import COLUMN, UPPER_ARM
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.scene.scene import Scene

declare_helpers()

STEP = 0.2
"""Way of the arm's farthest point between two poses that are tried, [unit]."""
SIMPLIFYING = 0.3
"""Part of the budget that is left for simplification."""
_AROUND = 1.5 * math.pi
_FLAT = 1e-9

util.setLogLevel(util.LOG_NONE)


@dataclass(frozen=True)
class JointPlanner:
    """A planner of OMPL, and whether its path is simplified."""

    name: str
    create: Callable[[Any], Any]
    simplified: bool = False


PLANNERS = (
    JointPlanner("RRTConnect + simplify", geometric.RRTConnect, simplified=True),
    JointPlanner("BIT*", geometric.BITstar),
)


def solve(
    planner: JointPlanner,
    scene: Scene,
    arm: PaperArm,
    poses: tuple[FloatArray, FloatArray],
    ms: float,
) -> tuple[float | None, float]:
    """Plan within about so many milliseconds.

    Args:
        planner: the planner.
        scene: of convex obstacles.
        arm: its arm.
        poses: q1, q2 and q3 of start and goal on each free branch, (k, 3) each, [rad].
        ms: the budget, [ms].

    Returns:
        Length of the tool's path, [unit], None without one; and the time taken, [ms].
    """
    setup = _setup(planner, scene, arm, poses)
    begin = time.perf_counter()
    setup.solve(ms / 1e3 * ((1 - SIMPLIFYING) if planner.simplified else 1.0))
    left = ms / 1e3 - (time.perf_counter() - begin)
    if not setup.haveExactSolutionPath() and left > 0:
        setup.solve(left)
    elif planner.simplified:
        setup.simplifySolution(max(left, 1e-3))
    if not setup.haveExactSolutionPath():
        return None, 1e3 * (time.perf_counter() - begin)
    taken = 1e3 * (time.perf_counter() - begin)
    path = setup.getSolutionPath()
    path.interpolate(400)
    joints = np.array([_joints(path.getState(k)) for k in range(path.getStateCount())])
    tools = np.array([_tool(_numbers(scene, arm), *row) for row in joints])
    return float(np.linalg.norm(np.diff(tools, axis=0), axis=1).sum()), taken


def _setup(
    planner: JointPlanner, scene: Scene, arm: PaperArm, poses: tuple[FloatArray, FloatArray]
) -> Any:
    starts, goals = poses
    nearest = math.remainder(goals[0, 0] - starts[0, 0], 2 * math.pi)
    middle = float(starts[0, 0]) + nearest / 2
    limits = [(middle - _AROUND, middle + _AROUND), *arm.limits[1:3].tolist()]
    space = base.RealVectorStateSpace(3)
    bounds = base.RealVectorBounds(3)
    for axis, (low, high) in enumerate(limits):
        bounds.setLow(axis, low)
        bounds.setHigh(axis, high)
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    information = setup.getSpaceInformation()
    check = _ArmCheck(information, scene, arm)
    information.setMotionValidator(check)
    setup.setStateValidityChecker(check.at)
    check.at(_state(space, starts[0]))  # compiled before the time counts
    ends = base.GoalStates(information)
    for row in starts:
        for q1 in _turned(row[0], limits[0]):
            setup.addStartState(_state(space, (q1, row[1], row[2])))
    for row in goals:
        for q1 in _turned(row[0], limits[0]):
            ends.addState(_state(space, (q1, row[1], row[2])))
    setup.setGoal(ends)
    setup.setOptimizationObjective(base.PathLengthOptimizationObjective(information))
    setup.setPlanner(planner.create(information))
    setup.setup()
    return setup


def _state(space: Any, joints: Sequence[float]) -> Any:
    state = space.allocState()
    for axis in range(3):
        state[axis] = float(joints[axis])
    return state


def _turned(q1: float, limits: Sequence[float]) -> list[float]:
    """The angle within limits, by whole turns."""
    turns = (q1 + 2 * math.pi * k for k in range(-2, 3))
    return [angle for angle in turns if limits[0] <= angle <= limits[1]]


def _joints(state: Any) -> tuple[float, float, float]:
    return state[0], state[1], state[2]


class _ArmCheck(base.MotionValidator):  # type: ignore[misc]
    """Check that tool and arm are clear all along a motion."""

    def __init__(self, information: Any, scene: Scene, arm: PaperArm) -> None:
        super().__init__(information)
        obstacles = ObstacleSet(scene.obstacles)
        self._numbers = _numbers(scene, arm)
        self._capsules = np.array(
            [
                (c.body, c.low, c.high, c.radius, float(c.neighbour), float(c.grips))
                for c in arm.capsules
                if c.body != COLUMN
            ]
        )
        self._solids = obstacles.packed
        self._column = _column(arm)
        # margins of one length for each: they are filled in by the kernel
        self._margins = np.zeros(max(len(scene.obstacles), 2))

    def checkMotion(self, a: Any, b: Any, *_: Any) -> bool:
        """Check whether the motion from a to b is clear; OMPL's name."""
        return bool(
            _is_clear(
                *(_joints(a), _joints(b), self._numbers, self._capsules),
                *(self._solids, self._column, self._margins),
            )
        )

    def at(self, a: Any) -> bool:
        """Check whether state a is clear."""
        return self.checkMotion(a, a)


def _numbers(scene: Scene, arm: PaperArm) -> FloatArray:
    """Shoulder, both lengths, floor, clearances of tool and links, workspace, limits."""
    floor = min(float(arm.base[2]), scene.workspace.min[2])
    return np.array(
        [
            *(*arm.shoulder.tolist(), arm.a3, float(arm.forearm(scene.arm.q5)), floor),
            *(scene.spline.clearance, scene.arm.clearance),
            *(*scene.workspace.min, *scene.workspace.max),
            *(*arm.limits[1].tolist(), *arm.limits[2].tolist()),
        ]
    )


def _column(arm: PaperArm) -> FloatArray:
    x, y, z = arm.base.tolist()
    return pack(
        tuple(
            Capsule(
                shape="capsule",
                radius=c.radius,
                height=max(c.high - c.low, _FLAT),
                position=(x, y, z + (c.low + c.high) / 2),
            )
            for c in arm.capsules
            if c.body == COLUMN
        )
    )


@numba.njit(cache=True)
def _tool(numbers: FloatArray, q1: float, q2: float, q3: float) -> tuple[float, float, float]:
    upper, lower = numbers[3], numbers[4]
    r = upper * math.sin(q2) + lower * math.sin(q2 + q3)
    height = upper * math.cos(q2) + lower * math.cos(q2 + q3)
    x, y = numbers[0] + math.sin(q1) * r, numbers[1] - math.cos(q1) * r
    return x, y, numbers[2] + height


@numba.njit(cache=True)
def _is_clear(
    a: tuple[float, float, float],
    b: tuple[float, float, float],
    numbers: FloatArray,
    capsules: FloatArray,
    solids: FloatArray,
    column: FloatArray,
    margins: FloatArray,
) -> bool:
    turn = b[0] - a[0]
    reach = numbers[3] + numbers[4]
    way = reach * (abs(turn) + abs(b[1] - a[1]) + abs(b[2] - a[2]))
    count = int(way / STEP) + 1
    for k in range(count + 1):
        share = k / count
        q1, q2 = a[0] + share * turn, a[1] + share * (b[1] - a[1])
        if not _pose_is_clear(
            *(q1, q2, a[2] + share * (b[2] - a[2]), numbers, capsules, solids, column, margins)
        ):
            return False
    return True


@numba.njit(cache=True)
def _pose_is_clear(
    q1: float,
    q2: float,
    q3: float,
    numbers: FloatArray,
    capsules: FloatArray,
    solids: FloatArray,
    column: FloatArray,
    margins: FloatArray,
) -> bool:
    if not (numbers[14] <= q2 <= numbers[15] and numbers[16] <= q3 <= numbers[17]):
        return False
    tool = _tool(numbers, q1, q2, q3)
    for axis in range(3):
        if not numbers[8 + axis] <= tool[axis] <= numbers[11 + axis]:
            return False
    margins[:] = numbers[6]
    if len(solids) and blocked(solids, margins, 0, tool, tool):
        return False
    shoulder = (numbers[0], numbers[1], numbers[2])
    side, ahead = math.sin(q1), -math.cos(q1)
    s2, c2, s3, c3 = math.sin(q2), math.cos(q2), math.sin(q2 + q3), math.cos(q2 + q3)
    elbow = (
        shoulder[0] + numbers[3] * s2 * side,
        shoulder[1] + numbers[3] * s2 * ahead,
        shoulder[2] + numbers[3] * c2,
    )
    for k in range(len(capsules)):
        body, low, high, radius = capsules[k, 0], capsules[k, 1], capsules[k, 2], capsules[k, 3]
        foot, s, c = (shoulder, s2, c2) if body == UPPER_ARM else (elbow, s3, c3)
        p = (foot[0] + low * s * side, foot[1] + low * s * ahead, foot[2] + low * c)
        q = (foot[0] + high * s * side, foot[1] + high * s * ahead, foot[2] + high * c)
        if capsules[k, 5] == 0.0 and min(p[2], q[2]) - radius < numbers[5]:
            return False
        margins[:] = radius + numbers[7]
        if len(solids) and blocked(solids, margins, 0, p, q):
            return False
        margins[:] = radius
        if capsules[k, 4] == 0.0 and blocked(column, margins, 0, p, q):
            return False
    return True
