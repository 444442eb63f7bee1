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
from abi.obstacles import primitive_kernels as sight
from abi.obstacles.packing import pack
from abi.obstacles.primitives import MeshShape
from abi.scene.scene import Scene

SIMPLIFYING = 0.3  # part of the budget that is left for simplification

util.setLogLevel(util.LOG_NONE)


@dataclass(frozen=True)
class Rival:
    """A planner, whether its path is simplified, and whether it starts again while time is left."""

    name: str
    planner: Callable[[Any], Any]
    simplified: bool = False
    repeated: bool = False


RIVALS = (
    Rival("RRT*", geometric.RRTstar),
    Rival("Informed RRT*", geometric.InformedRRTstar),
    Rival("BIT*", geometric.BITstar),
    Rival("AORRTC", geometric.AORRTC),
    Rival("RRTConnect + simplify", geometric.RRTConnect, simplified=True, repeated=True),
    Rival("FMT + simplify", geometric.FMT, simplified=True, repeated=True),
    Rival("BIT* + simplify", geometric.BITstar, simplified=True),
    Rival("AORRTC + simplify", geometric.AORRTC, simplified=True),
)


def solve(rival: Rival, scene: Scene, seconds: float) -> tuple[FloatArray | None, float]:
    """The planner's path (k, 3) after at most about ``seconds``, None where it has none; and time.

    Motions are tested as ours are, by the exact distance to the obstacles, so no resolution
    matters. The test is compiled; what it costs to call it from OMPL is the planner's. Planners
    that stop at their first path start again until the time is up, and the shortest path counts.
    """
    setup = _setup(rival, scene)
    begin = time.perf_counter()
    best, shortest = None, np.inf
    while (left := seconds - (time.perf_counter() - begin)) > 0:
        setup.solve(left * (1 - SIMPLIFYING) if rival.simplified else left)
        if setup.haveExactSolutionPath():
            if rival.simplified:
                left = seconds - (time.perf_counter() - begin)
                setup.simplifySolution(max(left, 1e-4))
            path = setup.getSolutionPath()
            if path.length() < shortest:
                states = [path.getState(k) for k in range(path.getStateCount())]
                best = np.array([[state[axis] for axis in range(3)] for state in states])
                shortest = path.length()
        if not rival.repeated:
            break
        setup.clear()
    return best, time.perf_counter() - begin


def _setup(rival: Rival, scene: Scene) -> Any:
    space = base.RealVectorStateSpace(3)
    bounds = base.RealVectorBounds(3)
    for axis in range(3):
        bounds.setLow(axis, scene.workspace.min[axis])
        bounds.setHigh(axis, scene.workspace.max[axis])
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)
    information = setup.getSpaceInformation()
    clear = _Clear(information, scene)
    information.setMotionValidator(clear)
    setup.setStateValidityChecker(clear.at)
    ends = space.allocState(), space.allocState()
    for state, point in zip(ends, (scene.start, scene.goal), strict=True):
        for axis in range(3):
            state[axis] = point[axis]
    setup.setStartAndGoalStates(*ends)
    setup.setOptimizationObjective(base.PathLengthOptimizationObjective(information))
    setup.setPlanner(rival.planner(information))
    setup.setup()
    return setup


class _Clear(base.MotionValidator):  # type: ignore[misc]
    """Whether a motion keeps the scene's clearance."""

    def __init__(self, information: Any, scene: Scene) -> None:
        super().__init__(information)
        self._solids = pack(
            tuple(solid for solid in scene.obstacles if not isinstance(solid, MeshShape))
        )
        self._margins = np.full(len(self._solids), scene.spline.clearance)

    def checkMotion(self, a: Any, b: Any, *_: Any) -> bool:
        """OMPL's question for a motion."""
        return not _blocked(self._solids, self._margins, a[0], a[1], a[2], b[0], b[1], b[2])

    def at(self, a: Any) -> bool:
        """OMPL's question for a state."""
        return self.checkMotion(a, a)


@numba.njit(cache=True)
def _blocked(
    solids: FloatArray,
    margins: FloatArray,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
) -> bool:
    return sight.blocked(solids, margins, 0, (ax, ay, az), (bx, by, bz))
