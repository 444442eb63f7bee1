"""The method: the stages in order, a scene in, a plan out.

A :class:`Planner` remembers the last result of each stage, so that a change runs only what lies
downstream of it.
"""

from __future__ import annotations

import time
from types import MappingProxyType
from typing import Any

from abi import compiling
from abi.arm import trajectory
from abi.arm.arm import Arm
from abi.arrays import FloatArray
from abi.curves import curve, fit_bspline, fit_quadratic, speed_profile
from abi.curves.bspline import BSpline
from abi.curves.curve import ArcLength, Curve
from abi.curves.fit import Fit
from abi.curves.quadratic import Quadratic
from abi.errors import ClearanceNotHeld, StageError
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.exclusion_cache import ExclusionCache
from abi.planner.plan import Plan
from abi.planner.stage import Stage
from abi.scene.scene import Scene
from abi.search import graph
from abi.search.search import SEARCHES
from abi.taut import lower_bound, taut_path
from abi.tet_mesh import tet_mesh

SLACK = 1e-3
"""Room that mesh edges keep beyond the clearance, as a part of the workspace's longest side.

In it a smooth curve can round the corners of the path.
"""

SAMPLES = 401
"""Samples of the arm's motion, uniform in time."""

_MANY_NODES, _MANY_OBSTACLES = 30_000, 300
"""Sizes from which waiting for the compiler takes less time than running without it."""


def plan(scene: Scene) -> Plan:
    """Plan ``scene`` once; see :class:`Planner` to plan many that differ little."""
    return Planner()(scene)


class Planner:
    """Runs the stages; remembers the last result of each."""

    def __init__(self, compile: bool = True) -> None:
        """Begin with nothing remembered.

        Args:
            compile: whether to compile the inner loops in the background from the first plan on.
        """
        self._compile, self._planned = compile, False
        self._obstacles = Stage(ObstacleSet)
        self._mesh = Stage(tet_mesh.tetrahedralise)
        self._exclude = Stage(ExclusionCache())
        self._graph = Stage(graph.build)
        self._searches = {name: Stage(search) for name, search in SEARCHES.items()}
        self._path_clearance = Stage(ObstacleSet.polyline_clearance)
        self._taut = Stage(taut_path.taut)
        self._optimum = Stage(lower_bound.lower_bound)
        self._bspline = Stage(fit_bspline.fit)
        self._bspline_arc = Stage(curve.arc_length)
        self._quadratic = Stage(fit_quadratic.fit)
        self._quadratic_arc = Stage(curve.arc_length)
        self._profile = Stage(speed_profile.three_phase)
        self._arm = Stage(Arm.from_settings)
        self._motion = Stage(trajectory.follow)

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
        try:
            self._run(scene, chosen_only, reached)
        except StageError as error:
            error.set_unit(scene.unit)
            reached["error"] = error
        total = 1e3 * (time.perf_counter() - begin)
        self._planned = True
        if self._compile:
            compiling.begin()
        return Plan(scene, **reached, ms=MappingProxyType(self._ms()), total_ms=total)

    def _run(self, scene: Scene, chosen_only: bool, reached: dict[str, Any]) -> None:
        """Run the method: each stage puts its result into ``reached`` or raises."""
        _wait_for_the_compiler(scene)
        obstacles = self._obstacles(scene.obstacles)
        # The arm stands there even when no path is found.
        reached["arm"] = self._arm(scene.arm, scene.unit)
        points = self._find_path(scene, obstacles, chosen_only, reached)
        followed, arc = self._fit_curves(scene, obstacles, points, reached)
        self._move_arm(scene, obstacles, followed, arc, reached)

    def _find_path(
        self, scene: Scene, obstacles: ObstacleSet, chosen_only: bool, reached: dict[str, Any]
    ) -> FloatArray:
        """Stages 1 to 3½; vertices (k, 3) of the path that the curves follow, [unit], world."""
        clearance, search = scene.spline.clearance, scene.search
        margin = clearance + SLACK * max(scene.workspace.size)
        # 1 tetrahedral mesh of the workspace without the obstacles
        reached["mesh"] = mesh = self._mesh(scene.workspace, scene.mesh)
        reached["free"] = free = self._exclude(mesh, obstacles, margin)
        # 2 graph
        reached["graph"] = nodes = self._graph(
            free, obstacles, margin, scene.start, scene.goal, clearance
        )
        # 3 A*, Dijkstra, Bellman-Ford
        names: list[str] = [search.algorithm] if chosen_only else list(self._searches)
        found = {name: self._searches[name](nodes, search.weight) for name in names}
        reached["searches"] = tuple(found.values())
        reached["path"] = path = found[search.algorithm]
        reached["path_clearance"] = self._path_clearance(obstacles, path.points)
        # 3½ the path pulled taut, and how short any curve can be
        points = path.points
        if search.taut:
            reached["taut"] = taut = self._taut(nodes, obstacles, margin, path)
            points = taut.points
        reached["optimum"] = self._optimum(
            scene.start, scene.goal, obstacles, clearance, scene.workspace
        )
        return points

    def _fit_curves(
        self, scene: Scene, obstacles: ObstacleSet, points: FloatArray, reached: dict[str, Any]
    ) -> tuple[Curve, ArcLength]:
        """Stages 4 and 5; the curve that the arm executes, and its arc length."""
        clearance = scene.spline.clearance
        # 4 B-spline, kept clear of the obstacles
        reached["bspline"] = bspline = self._bspline(
            points, scene.spline.degree, obstacles, clearance, scene.search.taut
        )
        reached["bspline_arc"] = bspline_arc = self._bspline_arc(bspline.curve)
        # 5 quadratic curve with exact ends
        reached["quadratic"] = quadratic = self._quadratic(
            bspline, bspline_arc, obstacles, clearance, scene.quadratic.mode
        )
        reached["quadratic_arc"] = quadratic_arc = self._quadratic_arc(quadratic.curve)
        reached["followed"] = followed = _followed(scene, bspline, quadratic)
        if followed == "bspline":
            return bspline.curve, bspline_arc
        return quadratic.curve, quadratic_arc

    def _move_arm(
        self,
        scene: Scene,
        obstacles: ObstacleSet,
        followed: Curve,
        arc: ArcLength,
        reached: dict[str, Any],
    ) -> None:
        """Stages 5 and 6: a motion along the curve in three phases, and the joints that follow."""
        speeds = scene.motion
        reached["profile"] = profile = self._profile(
            arc.length, speeds.speed, speeds.acceleration, speeds.deceleration
        )
        # 6 inverse kinematics
        reached["motion"] = motion = self._motion(
            followed, arc, profile, reached["arm"], scene.arm, obstacles, SAMPLES
        )
        if motion.error is not None:
            raise motion.error

    def _ms(self) -> dict[str, float]:
        return {
            "mesh": self._mesh.ms + self._exclude.ms,
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


def _followed(scene: Scene, bspline: Fit[BSpline], quadratic: Fit[Quadratic]) -> str:
    """Name of the curve that the arm executes.

    Raises:
        ClearanceNotHeld: neither curve keeps the clearance and the scene leaves the choice to us.
    """
    if scene.motion.curve != "auto":
        return scene.motion.curve
    if quadratic.holds:
        return "quadratic"
    if bspline.holds:
        return "bspline"
    raise ClearanceNotHeld(scene.spline.clearance, bspline.clearance.distance)
