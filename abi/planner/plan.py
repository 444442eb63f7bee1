"""The stages in order: a scene in, a plan out.

A :class:`Planner` remembers the last result of each stage, so that a change runs only what lies
downstream of it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Generic, ParamSpec, TypeVar

import numpy as np

from abi import compiling
from abi.arm import trajectory
from abi.arm.arm import Arm
from abi.arm.trajectory import ArmMotion
from abi.curves import curve, fit_bspline, fit_quadratic
from abi.curves import speed_profile as timing
from abi.curves.bspline import BSpline
from abi.curves.curve import ArcLength, Curve
from abi.curves.fit import Fit
from abi.curves.quadratic import Quadratic
from abi.curves.speed_profile import Profile
from abi.errors import ClearanceNotHeld, StageError
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.exclusion_cache import ExclusionCache
from abi.scene.scene import Scene
from abi.search import graph
from abi.search.graph import Graph
from abi.search.search import SEARCHES, SearchResult
from abi.taut.lower_bound import Bound, lower_bound
from abi.taut.taut_path import TautPath, taut
from abi.tet_mesh import tet_mesh as mesh
from abi.tet_mesh.exclusion import FreeMesh
from abi.tet_mesh.tet_mesh import TetMesh

_P = ParamSpec("_P")
_R = TypeVar("_R")

SLACK = 1e-3
"""What mesh edges keep beyond the clearance, as a part of the workspace's longest side: room in
which a smooth curve can round the corners of the path."""

SAMPLES = 401
"""Samples of the arm's motion, uniform in time."""

_MANY_NODES, _MANY_OBSTACLES = 30_000, 300
"""From so many on, waiting for the compiler takes less time than running without it."""

_BRIEF, _HASTY = 50.0, 0.3
"""Searches that take less, [ms], are timed twice: the first finds nothing in the caches, and may be
held up by something else. In haste only those that take next to nothing."""


@dataclass(frozen=True, eq=False)
class Plan:
    """What the stages made of a scene; a stage that was not reached is None.

    ``ms`` is what each stage took when it last ran, [ms]; ``total_ms`` is this call alone.
    """

    scene: Scene
    mesh: TetMesh | None = None
    free: FreeMesh | None = None
    graph: Graph | None = None
    searches: tuple[SearchResult, ...] = ()
    path: SearchResult | None = None
    path_clearance: float = math.inf
    taut: TautPath | None = None
    optimum: Bound | None = None
    bspline: Fit[BSpline] | None = None
    bspline_arc: ArcLength | None = None
    quadratic: Fit[Quadratic] | None = None
    quadratic_arc: ArcLength | None = None
    followed: str | None = None
    profile: Profile | None = None
    arm: Arm | None = None
    motion: ArmMotion | None = None
    error: StageError | None = None
    ms: Mapping[str, float] = field(default_factory=dict)
    total_ms: float = 0.0

    @property
    def followed_curve(self) -> Fit[BSpline] | Fit[Quadratic] | None:
        """The curve the arm executes."""
        return {"bspline": self.bspline, "quadratic": self.quadratic}.get(self.followed or "")

    @property
    def lower_bound(self) -> float:
        """No curve from start to goal is shorter than this, [unit]: the straight line."""
        return float(np.linalg.norm(np.subtract(self.scene.goal, self.scene.start)))

    @property
    def best_known(self) -> float | None:
        """Length of the shortest of this plan's curves that keep the clearance, [unit]."""
        lengths = [found.length for found in (self.path, self.taut) if found is not None]
        for fitted, arc in (
            (self.bspline, self.bspline_arc),
            (self.quadratic, self.quadratic_arc),
        ):
            if fitted is not None and arc is not None and fitted.holds:
                lengths.append(arc.length)
        return min(lengths, default=None)

    def to_dict(self, full: bool = False) -> dict[str, Any]:
        """Plain data, as in ``docs/scene-and-plan.md``; ``full`` adds the mesh and all samples."""
        from abi.planner.plan_json import to_dict

        return to_dict(self, full)


class Planner:
    """Runs the stages; remembers the last result of each."""

    def __init__(self, compile: bool = True) -> None:
        """Begin with nothing remembered.

        Args:
            compile: whether to compile the inner loops in the background from the first plan on.
        """
        self._compile, self._planned = compile, False
        self._obstacles = _Remembered(ObstacleSet)
        self._mesh = _Remembered(mesh.tetrahedralise)
        self._free = _Remembered(ExclusionCache())
        self._graph = _Remembered(graph.build)
        self._searches = {name: _Remembered(search) for name, search in SEARCHES.items()}
        self._path_clearance = _Remembered(ObstacleSet.polyline_clearance)
        self._taut = _Remembered(taut)
        self._optimum = _Remembered(lower_bound)
        self._bspline = _Remembered(fit_bspline.fit)
        self._bspline_arc = _Remembered(curve.arc_length)
        self._quadratic = _Remembered(fit_quadratic.fit)
        self._quadratic_arc = _Remembered(curve.arc_length)
        self._profile = _Remembered(timing.three_phase)
        self._arm = _Remembered(Arm.from_settings)
        self._motion = _Remembered(trajectory.follow)

    def __call__(self, scene: Scene, chosen_only: bool = False) -> Plan:
        """Plan ``scene``; a scene without a plan returns a plan whose ``error`` is set.

        Args:
            scene: what to plan.
            chosen_only: run only the search whose path goes on, for a plan in haste.
        """
        if self._planned:
            compiling.wait_for_loading()
        begin = time.perf_counter()
        reached: dict[str, Any] = {}
        for search in self._searches.values():
            search.again = _HASTY if chosen_only else _BRIEF
        names: list[str] = [scene.search.algorithm] if chosen_only else list(self._searches)
        try:
            self._run(scene, names, reached)
        except StageError as error:
            error.tell(scene.unit)
            reached["error"] = error
        total = 1e3 * (time.perf_counter() - begin)
        self._planned = True
        if self._compile:
            compiling.begin()
        return Plan(scene, **reached, ms=MappingProxyType(self._ms()), total_ms=total)

    def _run(self, scene: Scene, algorithms: list[str], reached: dict[str, Any]) -> None:
        """The method: each stage puts its result into ``reached`` or raises."""
        _wait_for_the_compiler(scene)
        asked = scene.spline.clearance
        margin = asked + SLACK * max(scene.workspace.size)
        obstacles = self._obstacles(scene.obstacles)

        # The arm stands there even when no path is found.
        reached["arm"] = arm = self._arm(scene.arm, scene.unit)
        # 1 tetrahedral mesh of the workspace without the obstacles
        reached["mesh"] = tets = self._mesh(scene.workspace, scene.mesh)
        reached["free"] = free = self._free(tets, obstacles, margin)
        # 2 graph
        reached["graph"] = nodes = self._graph(
            free, obstacles, margin, scene.start, scene.goal, asked
        )
        # 3 A*, Dijkstra, Bellman-Ford
        reached["searches"] = found = tuple(
            self._searches[name](nodes, scene.search.weight) for name in algorithms
        )
        reached["path"] = path = next(
            result for result in found if result.algorithm == scene.search.algorithm
        )
        reached["path_clearance"] = self._path_clearance(obstacles, path.points)
        # 3½ the path pulled taut, and how short any curve can be
        way_points = path.points
        if scene.search.taut:
            reached["taut"] = string = self._taut(nodes, obstacles, margin, path)
            way_points = string.points
        reached["optimum"] = self._optimum(
            scene.start, scene.goal, obstacles, asked, scene.workspace
        )
        # 4 B-spline, kept clear of the obstacles
        reached["bspline"] = spline = self._bspline(
            way_points, scene.spline.degree, obstacles, asked, scene.search.taut
        )
        reached["bspline_arc"] = spline_arc = self._bspline_arc(spline.curve)
        # 5 quadratic curve with exact ends, and a motion in three phases
        reached["quadratic"] = quadratic = self._quadratic(
            spline, spline_arc, obstacles, asked, scene.quadratic.mode
        )
        reached["quadratic_arc"] = quadratic_arc = self._quadratic_arc(quadratic.curve)
        reached["followed"] = followed = _followed(scene, spline, quadratic)
        path_curve: Curve = spline.curve if followed == "bspline" else quadratic.curve
        arc = spline_arc if followed == "bspline" else quadratic_arc
        motion = scene.motion
        reached["profile"] = profile = self._profile(
            arc.length, motion.speed, motion.acceleration, motion.deceleration
        )
        # 6 inverse kinematics
        reached["motion"] = moved = self._motion(
            path_curve, arc, profile, arm, scene.arm, obstacles, SAMPLES
        )
        if moved.error is not None:
            raise moved.error

    def _ms(self) -> dict[str, float]:
        return {
            "mesh": self._mesh.ms + self._free.ms,
            "graph": self._graph.ms,
            **{name: search.ms for name, search in self._searches.items()},
            "path_clearance": self._path_clearance.ms,
            "taut": self._taut.ms,
            "optimum": self._optimum.ms,
            "bspline": self._bspline.ms + self._bspline_arc.ms,
            "quadratic": self._quadratic.ms + self._quadratic_arc.ms,
            "timing": self._profile.ms,
            "arm": self._arm.ms + self._motion.ms,
        }


def _wait_for_the_compiler(scene: Scene) -> None:
    """Compile before planning where that is quicker than to plan without."""
    if compiling.is_done():
        return
    many = scene.mesh.node_count(scene.workspace) > _MANY_NODES
    if many or len(scene.obstacles) > _MANY_OBSTACLES:
        compiling.compile()


def plan(scene: Scene) -> Plan:
    """Plan ``scene`` once; see :class:`Planner` to plan many that differ little."""
    return Planner()(scene)


class _Remembered(Generic[_P, _R]):
    """A stage with a memory of one: equal arguments give back the same object.

    Attributes:
        ms: what it took.
        again: what takes less, [ms], is timed twice, and the lesser time counts.
    """

    def __init__(self, function: Callable[_P, _R]) -> None:
        self._function = function
        self.again = 0.0
        self._arguments: tuple[object, ...] | None = None
        self._result: _R | None = None
        self._error: StageError | None = None
        self.ms = 0.0

    def __call__(self, *args: _P.args, **kwargs: _P.kwargs) -> _R:
        if self._arguments is None or not _same(self._arguments, args):
            self._arguments, self._result, self._error = None, None, None
            begin = time.perf_counter()
            try:
                self._result = self._function(*args, **kwargs)
            except StageError as error:
                self._error = error
            self._arguments = args
            self.ms = 1e3 * (time.perf_counter() - begin)
            if self.ms < self.again and self._error is None:
                begin = time.perf_counter()
                self._function(*args, **kwargs)
                self.ms = min(self.ms, 1e3 * (time.perf_counter() - begin))
        if self._error is not None:
            raise self._error
        return self._result  # type: ignore[return-value]


def _same(before: tuple[object, ...], now: tuple[object, ...]) -> bool:
    """Settings compare by value, results and their arrays by identity."""
    return len(before) == len(now) and all(
        a is b or (not isinstance(a, np.ndarray) and a == b)
        for a, b in zip(before, now, strict=True)
    )


def _followed(scene: Scene, spline: Fit[BSpline], quadratic: Fit[Quadratic]) -> str:
    """Which curve the arm executes.

    Raises:
        ClearanceNotHeld: neither curve keeps the clearance and the scene leaves the choice to us.
    """
    if scene.motion.curve != "auto":
        return scene.motion.curve
    if quadratic.holds:
        return "quadratic"
    if spline.holds:
        return "bspline"
    raise ClearanceNotHeld(scene.spline.clearance, spline.clearance.distance)
