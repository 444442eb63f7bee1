"""OMPL's planners on a scene's point: exact checks of motions, and a budget of time."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numba
import numpy as np
from ompl import base, geometric, util

from abi.arrays import FloatArray
from abi.compilation.helpers import declare_helpers
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.packing import pack
from abi.obstacles.primitive_tree_kernels import blocked
from abi.scene.scene import Scene

declare_helpers()

SIMPLIFYING = 0.3  # part of the budget that is left for simplification

util.setLogLevel(util.LOG_NONE)


@dataclass(frozen=True)
class OmplPlanner:
    """A planner, whether its path is simplified, and whether it starts again while time is left."""

    name: str
    create: Callable[[Any], Any]
    simplified: bool = False
    repeated: bool = False


PLANNERS = (
    OmplPlanner("RRT*", geometric.RRTstar),
    OmplPlanner("Informed RRT*", geometric.InformedRRTstar),
    OmplPlanner("BIT*", geometric.BITstar),
    OmplPlanner("AORRTC", geometric.AORRTC),
    OmplPlanner("RRTConnect + simplify", geometric.RRTConnect, simplified=True, repeated=True),
    OmplPlanner("FMT + simplify", geometric.FMT, simplified=True, repeated=True),
    OmplPlanner("BIT* + simplify", geometric.BITstar, simplified=True),
    OmplPlanner("AORRTC + simplify", geometric.AORRTC, simplified=True),
)


def solve(planner: OmplPlanner, scene: Scene, seconds: float) -> tuple[FloatArray | None, float]:
    """Plan within about ``seconds``; the path (k, 3), [unit], or None, and the time taken, [s].

    Motions are tested as ours are, by the exact distance to the obstacles, so no resolution
    matters. The test is compiled; what it costs to call it from OMPL is the planner's. Planners
    that stop at their first path start again until the time is up, and the shortest path counts.
    """
    setup = _setup(planner, scene)
    begin = time.perf_counter()
    best, shortest = None, np.inf
    while (left := seconds - (time.perf_counter() - begin)) > 0:
        setup.solve(left * (1 - SIMPLIFYING) if planner.simplified else left)
        if setup.haveExactSolutionPath():
            if planner.simplified:
                left = seconds - (time.perf_counter() - begin)
                setup.simplifySolution(max(left, 1e-4))
            path = setup.getSolutionPath()
            if path.length() < shortest:
                states = [path.getState(k) for k in range(path.getStateCount())]
                best = np.array([[state[axis] for axis in range(3)] for state in states])
                shortest = path.length()
        if not planner.repeated:
            break
        setup.clear()
    return best, time.perf_counter() - begin


def _setup(planner: OmplPlanner, scene: Scene) -> Any:
    space = base.RealVectorStateSpace(3)
    bounds = base.RealVectorBounds(3)
    for axis in range(3):
        bounds.setLow(axis, scene.workspace.min[axis])
        bounds.setHigh(axis, scene.workspace.max[axis])
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    information = setup.getSpaceInformation()
    check = _ClearanceCheck(information, scene)
    information.setMotionValidator(check)
    setup.setStateValidityChecker(check.at)
    ends = space.allocState(), space.allocState()
    for state, point in zip(ends, (scene.start, scene.goal), strict=True):
        for axis in range(3):
            state[axis] = point[axis]
    setup.setStartAndGoalStates(*ends)
    setup.setOptimizationObjective(base.PathLengthOptimizationObjective(information))
    setup.setPlanner(planner.create(information))
    setup.setup()
    return setup


class _ClearanceCheck(base.MotionValidator):  # type: ignore[misc]
    """Check that a motion keeps the scene's clearance."""

    def __init__(self, information: Any, scene: Scene) -> None:
        super().__init__(information)
        self._primitives = pack(
            tuple(shape for shape in scene.obstacles if not isinstance(shape, MeshShape))
        )
        self._margins = np.full(len(self._primitives), scene.spline.clearance)

    def checkMotion(self, a: Any, b: Any, *_: Any) -> bool:
        """Check whether the motion from a to b is clear; OMPL's name."""
        return not _blocked(self._primitives, self._margins, a[0], a[1], a[2], b[0], b[1], b[2])

    def at(self, a: Any) -> bool:
        """Check whether state a is clear."""
        return self.checkMotion(a, a)


@numba.njit(cache=True)
def _blocked(
    primitives: FloatArray,
    margins: FloatArray,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
) -> bool:
    return blocked(primitives, margins, 0, (ax, ay, az), (bx, by, bz))
