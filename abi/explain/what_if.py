"""Trial plans of a scene with one thing changed."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import scipy

from abi import progress
from abi.arrays import IntArray
from abi.errors import StageError
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.branch import STAGE_NAMES
from abi.planner.exclusion_cache import ExclusionCache
from abi.planner.joint_space_motion import HASTY
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.scene.scene import Scene
from abi.scene.settings import FINEST_PITCH
from abi.search.build_graph import build_graph
from abi.search.graph import Graph
from abi.tet_mesh.tet_mesh import shared_mesh

MOST_NODES = 60_000
"""Most nodes of a mesh that is tried."""

_NEGLIGIBLE = 1e-3  # part of the scene's clearance below which a clearance counts as none
_RESOLUTION = 1e-2  # of the largest clearance, as a part of it


class WhatIf:
    """Trials of a changed scene: whole plans, and connectivity of start and goal alone."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.obstacles = ObstacleSet(scene.obstacles)
        self._planner = Planner(effort=HASTY)
        self._exclude = ExclusionCache()

    def plan_past(self, stage: str, **change: Any) -> Plan | None:
        """Plan the changed scene; None when the plan does not get past ``stage``.

        Raises:
            CancelledError: as in every method.
        """
        progress.check()
        plan = self._planner(self.scene.replace(**change))
        if plan.error is None or STAGE_NAMES.index(plan.error.stage) > STAGE_NAMES.index(stage):
            return plan
        return None

    def connected(
        self, clearance: float, pitch: float | None = None, obstacles: ObstacleSet | None = None
    ) -> bool:
        """Check whether the graph connects start and goal; None means the scene's value."""
        progress.check()
        scene = self.scene
        obstacles = self.obstacles if obstacles is None else obstacles
        margin = clearance + scene.workspace.slack
        settings = scene.mesh if pitch is None else scene.mesh.model_copy(update={"pitch": pitch})
        # the exclusion's memory keeps it in use until the next pitch
        mesh = shared_mesh(scene.workspace, settings)
        free = self._exclude(mesh, obstacles, margin)
        try:
            graph = build_graph(free, obstacles, margin, scene.start, scene.goal, clearance)
        except StageError:
            return False
        component = components(graph)
        return bool(component[graph.start] == component[graph.goal])

    def finer_pitches(self) -> list[float]:
        """Finer pitches to try, each half the last, [unit]; none if the mesh is fine already."""
        settings, box = self.scene.mesh, self.scene.workspace
        most = min(settings.max_nodes, MOST_NODES)
        pitches = [settings.pitch]
        while True:
            pitch = float(f"{pitches[-1] / 2:.3g}")
            if (
                pitch < FINEST_PITCH
                or settings.model_copy(update={"pitch": pitch}).node_count(box) > most
            ):
                return pitches[1:]
            pitches.append(pitch)

    def largest_clearance(self, works: Callable[[float], bool]) -> float | None:
        """Largest clearance below the scene's that works, by bisection; None if none does.

        It is rounded to two digits, or to three if even five per cent more would work.

        Args:
            works: whether a clearance works; if one does, so should every smaller one.
        """
        clearance = self.scene.spline.clearance
        if clearance <= 0:
            return None
        slightly_less = rounded_down(clearance * (1 - _RESOLUTION), 2)
        if 1.05 * slightly_less >= clearance and works(slightly_less):
            return slightly_less
        if not works(0.0):
            return None
        low, high = 0.0, clearance
        while high > _NEGLIGIBLE * clearance and high - low > _RESOLUTION * low:
            middle = (low + high) / 2
            low, high = (middle, high) if works(middle) else (low, middle)
        for digits in (2, 3):
            rounded = rounded_down(low, digits)
            if 1.05 * rounded >= high and works(rounded):
                return rounded
        return low


def components(graph: Graph) -> IntArray:
    """Number (n,) of the connected component of each node of the graph."""
    size = len(graph.points)
    matrix = scipy.sparse.csr_array(
        (np.ones(len(graph.indices)), graph.indices, graph.indptr), (size, size)
    )
    labels: IntArray = scipy.sparse.csgraph.connected_components(matrix, directed=False)[1]
    return labels


def rounded_down(value: float, digits: int) -> float:
    """``value`` rounded down to a number of significant digits."""
    if value <= 0:
        return 0.0
    place = digits - 1 - math.floor(math.log10(value))
    # a float may lie a little below the decimals that it is written with
    return float(f"{math.floor(value * 10.0**place * (1 + 1e-12)) / 10.0**place:.{digits}g}")
