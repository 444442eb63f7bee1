"""Plans of a scene with one thing different: tried, not guessed."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
import scipy

from abi.arrays import IntArray
from abi.errors import StageError
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.exclusion_cache import ExclusionCache
from abi.planner.plan import Plan
from abi.planner.planner import SLACK, Planner
from abi.scene.scene import FINEST_PITCH, Scene
from abi.search import graph
from abi.search.graph import Graph
from abi.tet_mesh import tet_mesh as mesh
from abi.tet_mesh.tet_mesh import TetMesh

MOST_NODES = 60_000

_STAGES = ("mesh", "graph", "search", "bspline", "quadratic", "timing", "arm")
_COARSEST = 1e-3  # of what is asked: below this a clearance counts as none
_FINE = 1e-2  # of itself: how closely the largest clearance is found


class CancelledError(Exception):
    """Raised when the caller no longer wants the answer."""


class WhatIf:
    """Plans changed scenes, and tells quickly whether start and goal are connected at all."""

    def __init__(self, scene: Scene, cancelled: Callable[[], bool]) -> None:
        self.scene = scene
        self.obstacles = ObstacleSet(scene.obstacles)
        self._cancelled = cancelled
        self._planner = Planner()
        self._exclude = ExclusionCache()
        self._mesh = lru_cache(maxsize=1)(self._tetrahedralised)

    def plan_past(self, stage: str, **change: Any) -> Plan | None:
        """The plan of the changed scene when it gets past ``stage``, else None.

        Raises:
            CancelledError: as in every method.
        """
        self._check_cancelled()
        made = self._planner(self.scene.replace(**change))
        if made.error is None or _STAGES.index(made.error.stage) > _STAGES.index(stage):
            return made
        return None

    def connected(
        self, clearance: float, pitch: float | None = None, obstacles: ObstacleSet | None = None
    ) -> bool:
        """Whether the graph connects start and goal; None stands for the scene's own."""
        self._check_cancelled()
        scene = self.scene
        blocking = self.obstacles if obstacles is None else obstacles
        margin = clearance + SLACK * max(scene.workspace.size)
        free = self._exclude(self._mesh(pitch or scene.mesh.pitch), blocking, margin)
        try:
            nodes = graph.build(free, blocking, margin, scene.start, scene.goal, clearance)
        except StageError:
            return False
        component = components(nodes)
        return bool(component[nodes.start] == component[nodes.goal])

    def finer_pitches(self) -> list[float]:
        """Finer pitches to try, halved again and again, [unit]; none when the mesh is fine."""
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
        """The largest clearance below the scene's that works, or None; found by bisection.

        It has two digits, or three where five per cent more than the two would work too.

        Args:
            works: whether a clearance works; if one does, so should every smaller one.
        """
        asked = self.scene.spline.clearance
        if asked <= 0:
            return None
        little_less = rounded_down(asked * (1 - _FINE), 2)
        if 1.05 * little_less >= asked and works(little_less):
            return little_less
        if not works(0.0):
            return None
        low, high = 0.0, asked
        while high > _COARSEST * asked and high - low > _FINE * low:
            middle = (low + high) / 2
            low, high = (middle, high) if works(middle) else (low, middle)
        for digits in (2, 3):
            shorter = rounded_down(low, digits)
            if 1.05 * shorter >= high and works(shorter):
                return shorter
        return low

    def _check_cancelled(self) -> None:
        if self._cancelled():
            raise CancelledError

    def _tetrahedralised(self, pitch: float) -> TetMesh:
        settings = self.scene.mesh.model_copy(update={"pitch": pitch})
        return mesh.tetrahedralise(self.scene.workspace, settings)


def components(nodes: Graph) -> IntArray:
    """Number (n,) of the connected component of the graph that each node is in."""
    size = len(nodes.points)
    matrix = scipy.sparse.csr_array(
        (np.ones(len(nodes.indices)), nodes.indices, nodes.indptr), (size, size)
    )
    found: IntArray = scipy.sparse.csgraph.connected_components(matrix, directed=False)[1]
    return found


def rounded_down(value: float, digits: int) -> float:
    """``value`` with so many significant digits, not above it."""
    if value <= 0:
        return 0.0
    place = digits - 1 - math.floor(math.log10(value))
    # a float that is a little below its own decimals stays what it reads
    return float(f"{math.floor(value * 10.0**place * (1 + 1e-12)) / 10.0**place:.{digits}g}")
