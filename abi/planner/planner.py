"""The planner: runs the stages in order, from a scene to a plan.

A :class:`Planner` remembers the last result of each stage, so that a change runs only the stages
downstream of it.
"""

from __future__ import annotations

import operator
import threading
import time
from collections.abc import Sequence
from types import MappingProxyType
from typing import Any

from abi import compiling, progress
from abi.arm_planning.arm_model import Course
from abi.arm_planning.models import model_of
from abi.arm_planning.motion.arm_clearance import ArmClearance, is_clear
from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arm_planning.motion_law import motion_law
from abi.arm_planning.world.surroundings import Surroundings
from abi.compiled import interpreted_calls
from abi.curves import fit_bspline, fit_quadratic
from abi.curves.bspline import BSpline
from abi.curves.curve import arc_length
from abi.curves.fit import Fit
from abi.curves.quadratic import Quadratic
from abi.curves.timed_profile import PathProfile
from abi.errors import ArmNotClear, ClearanceNotHeld, StageError
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.arm_aware import ArmAware, ArmTask
from abi.planner.arm_words import contact_sentence
from abi.planner.exclusion_cache import ExclusionCache
from abi.planner.plan import Plan
from abi.planner.shared_mesh import shared_mesh
from abi.planner.stage import Stage
from abi.scene.scene import Scene, require_scene
from abi.scene.settings import MotionSettings
from abi.search.build_graph import build_graph
from abi.search.search import SEARCHES
from abi.search.taut.lower_bound import lower_bound
from abi.search.taut.taut_path import taut as pull_taut

SAMPLES = 401
"""Samples of the arm's motion, uniform in time."""

_BRANCHES = 2
"""Branches of an arm, at most, that follow the tool's own curve."""

_MANY_NODES, _MANY_OBSTACLES = 30_000, 300
"""Sizes above which waiting for the compiler takes less time than planning without it."""


def plan(scene: Scene) -> Plan:
    """Plan a scene once; a :class:`Planner` is faster for many scenes that differ little.

    Args:
        scene: the scene.

    Returns:
        The plan. If the scene has none, its ``error`` says why, and nothing is raised.

    Raises:
        SceneError: ``scene`` is no scene.
    """
    return Planner()(scene)


class Planner:
    """The stages of the method, each of which remembers its last result.

    A second plan reruns only the stages whose inputs have changed. Threads may share a planner:
    their calls take turns. To plan at the same time, each needs its own.
    """

    def __init__(self, compile: bool = True) -> None:
        """Start without any remembered results.

        Args:
            compile: whether to compile the inner loops in the background from the first plan on. A
                plan that would take longer than the compiler waits for it all the same.
        """
        self._compile, self._planned = compile, False
        self._turn = threading.Lock()
        self._obstacles = Stage(ObstacleSet)
        self._mesh = Stage(shared_mesh)
        self._exclude = Stage(ExclusionCache())
        self._graph = Stage(build_graph)
        # compared with each other: what else the machine did meanwhile is not theirs
        clock = time.thread_time
        self._searches = {name: Stage(search, clock) for name, search in SEARCHES.items()}
        self._path_clearance = Stage(ObstacleSet.polyline_clearance)
        self._taut = Stage(pull_taut)
        self._optimum = Stage(lower_bound)
        self._bspline = Stage(fit_bspline.fit)
        self._bspline_arc = Stage(arc_length)
        self._quadratic = Stage(fit_quadratic.fit)
        self._quadratic_arc = Stage(arc_length)
        self._profiles = Stage(_profiles)
        self._arm = Stage(model_of)
        # methods of any arm, and their arguments
        self._surroundings: Stage[..., Surroundings] = Stage(operator.call)
        self._courses: Stage[..., Sequence[Course]] = Stage(operator.call)
        self._motion: list[Stage[..., ArmMotion]]
        self._motion = [Stage(operator.call) for _ in range(_BRANCHES)]
        self._arm_clearance: list[Stage[..., ArmClearance]]
        self._arm_clearance = [Stage(operator.call) for _ in range(_BRANCHES)]
        self._arm_aware, self._arm_aware_ms, self._arm_aware_interpreted = ArmAware(), 0.0, False

    def skip_first(self) -> None:
        """Take the first plan, which does not wait for kernels to be loaded, for made elsewhere."""
        self._planned = True

    def __call__(self, scene: Scene, chosen_only: bool = False) -> Plan:
        """Plan a scene.

        Args:
            scene: the scene.
            chosen_only: whether to run only the search that ``scene.search.algorithm`` names, which
                is faster.

        Returns:
            The plan. If the scene has none, its ``error`` says why, and nothing is raised.

        Raises:
            SceneError: ``scene`` is no scene.
        """
        require_scene(scene)
        with self._turn:
            return self._plan(scene, chosen_only)

    def _plan(self, scene: Scene, chosen_only: bool) -> Plan:
        """Plan a scene, as the only call that runs."""
        if self._compile and scene.arm.model == "urdf":
            # loading takes a second, and such a plan without compiled loops many
            compiling.begin()
        # a tab's first plan does not wait: until it is drawn the page is empty
        if self._planned or self._compile:
            compiling.wait_for_loading()
        _wait_for_compiler(scene)
        begin = time.perf_counter()
        results: dict[str, Any] = {}
        self._arm_aware_ms, self._arm_aware_interpreted = 0.0, False
        try:
            self._run(scene, chosen_only, results)
        except StageError as error:
            # a copy: the stage remembers its error for scenes in another unit
            results["error"] = error.in_unit(scene.unit)
        total = 1e3 * (time.perf_counter() - begin)
        self._planned = True
        if self._compile:
            compiling.begin()
        return Plan(
            scene,
            **results,
            ms=MappingProxyType(self._times()),
            interpreted=self._interpreted(),
            total_ms=total,
        )

    def _run(self, scene: Scene, chosen_only: bool, results: dict[str, Any]) -> None:
        """Run the six stages of the method: each puts its result into ``results`` or raises."""
        workspace, clearance, search = scene.workspace, scene.spline.clearance, scene.search
        margin = clearance + workspace.slack
        progress.tell("reading obstacles and arm")
        obstacles = self._obstacles(scene.obstacles)
        # the arm stands there even when no path is found
        model = self._arm(scene.arm, scene.unit)
        results["arm"] = model.arm

        progress.tell("making the mesh")
        results["mesh"] = mesh = self._mesh(workspace, scene.mesh)
        results["free"] = free = self._exclude(mesh, obstacles, margin)

        progress.tell("testing the mesh's edges")
        results["graph"] = graph = self._graph(
            free, obstacles, margin, scene.start, scene.goal, clearance
        )

        progress.tell("searching")
        names: list[str] = [search.algorithm] if chosen_only else list(SEARCHES)
        searches = {name: self._searches[name](graph, search.weight) for name in names}
        results["searches"] = tuple(searches.values())
        results["path"] = path = searches[search.algorithm]
        results["path_clearance"] = self._path_clearance(obstacles, path.points)

        vertices, away = path.points, results["path_clearance"]
        if search.taut:
            results["taut"] = taut = self._taut(graph, obstacles, margin, path)
            vertices, away = taut.points, taut.clearance
        results["optimum"] = self._optimum(scene.start, scene.goal, obstacles, clearance, workspace)

        progress.tell("fitting curves")
        results["bspline"] = bspline = self._bspline(
            vertices, scene.spline.degree, obstacles, clearance, search.taut, away
        )
        results["bspline_arc"] = bspline_arc = self._bspline_arc(bspline.curve)

        results["quadratic"] = quadratic = self._quadratic(
            bspline, bspline_arc, obstacles, clearance, scene.quadratic.mode
        )
        results["quadratic_arc"] = self._quadratic_arc(quadratic.curve)
        results["followed"] = followed = _followed(scene, bspline, quadratic)
        curve, arc = results[followed].curve, results[f"{followed}_arc"]

        progress.tell("moving the arm")
        surroundings = self._surroundings(model.surroundings, obstacles, workspace.min[2])
        courses = self._courses(model.courses, curve, arc, scene.arm, obstacles, surroundings)
        task = ArmTask(
            scene, model, obstacles, surroundings, free, results.get("taut"), margin, SAMPLES
        )
        self._move(task, courses, names, results)

    def _move(
        self, task: ArmTask, courses: Sequence[Course], names: list[str], results: dict[str, Any]
    ) -> None:
        """Stage 6: follow the tool alone, or a curve that the whole arm is clear along."""
        avoid = task.scene.arm.avoid
        paths = [*zip(courses, self._profiles(courses, task.scene.motion), strict=True)]
        refuted = avoid and _are_refuted(paths, task.scene, task.surroundings)
        if not refuted:
            self._follow(task, paths, results)
        else:  # stages that do not run take no time
            for stage in self._on_branches:
                stage.ms = 0.0
        if refuted or (avoid and not is_clear(results["motion"], results["arm_clearance"])):
            try:
                self._avoid(task, names, results)
            except ArmNotClear as fault:
                if refuted:
                    self._follow(task, paths, results)
                raise results["motion"].error or _with_contact(fault, results, task.scene) from None
        elif results["motion"].error is not None:
            raise results["motion"].error

    def _follow(
        self, task: ArmTask, paths: Sequence[tuple[Course, PathProfile]], results: dict[str, Any]
    ) -> None:
        """Stage 6 along the tool's own curve: the first branch that is clear, or else the first."""
        for k, (course, profile) in enumerate(paths):
            motion = self._motion[k](course.motion, profile, SAMPLES)
            clear = self._arm_clearance[k](
                *(course.clearance, motion, task.obstacles, task.surroundings),
                task.scene.arm.clearance,
            )
            found = {"profile": profile, "motion": motion, "arm_clearance": clear}
            if k == 0 or is_clear(motion, clear):
                results.update(found)

    def _avoid(self, task: ArmTask, names: list[str], results: dict[str, Any]) -> None:
        """Replace results by those of a motion whose whole arm is clear, or raise."""
        progress.tell("avoiding with the whole arm")
        begin, before = time.perf_counter(), interpreted_calls()
        try:
            aware = self._arm_aware(task, names)
        finally:
            self._arm_aware_ms = 1e3 * (time.perf_counter() - begin)
            self._arm_aware_interpreted = interpreted_calls() > before
        results["tool_only"] = results[results["followed"]]
        results.update(aware)

    @property
    def _on_branches(self) -> list[Stage[..., Any]]:
        """Stages that run once for each branch."""
        return [*self._motion, *self._arm_clearance]

    def _times(self) -> dict[str, float]:
        """Time of each stage when it last ran, [ms]."""
        times = {name: sum(one.ms for one in parts) for name, parts in self._parts().items()}
        return times | {"arm_aware": self._arm_aware_ms}

    def _interpreted(self) -> frozenset[str]:
        """Stages in which inner loops ran as Python when they last ran."""
        parts = self._parts().items()
        names = {name for name, stages in parts if any(stage.interpreted for stage in stages)}
        return frozenset(names | {"arm_aware"} if self._arm_aware_interpreted else names)

    def _parts(self) -> dict[str, Sequence[Stage[..., Any]]]:
        """Parts of each stage that is told of."""
        return {
            "mesh": (self._mesh, self._exclude),
            "graph": (self._graph,),
            **{name: (search,) for name, search in self._searches.items()},
            "path_clearance": (self._path_clearance,),
            "taut": (self._taut,),
            "optimum": (self._optimum,),
            "bspline": (self._bspline, self._bspline_arc),
            "quadratic": (self._quadratic, self._quadratic_arc),
            "timing": (self._profiles,),
            "arm": (self._arm, self._surroundings, self._courses, *self._on_branches),
        }


def _profiles(courses: Sequence[Course], asked: MotionSettings) -> tuple[PathProfile, ...]:
    """Motion along each of the courses by the law that is asked for."""
    return tuple(motion_law(course, asked) for course in courses)


def _are_refuted(
    paths: Sequence[tuple[Course, PathProfile]], scene: Scene, surroundings: Surroundings
) -> bool:
    """Check if it shows at once that no branch of the arm is clear along the tool's own curve.

    Only then need the motion along it not be sampled and measured, which takes longer.
    """
    required = scene.arm.clearance
    return all(course.is_refuted(profile, surroundings, required) for course, profile in paths)


def _wait_for_compiler(scene: Scene) -> None:
    """Compile before planning where that is faster than planning without."""
    if compiling.is_done():
        return
    many = scene.mesh.node_count(scene.workspace) > _MANY_NODES
    if many or len(scene.obstacles) > _MANY_OBSTACLES:
        progress.tell("compiling inner loops, once on this machine")
        compiling.compile()


def _with_contact(fault: ArmNotClear, results: dict[str, Any], scene: Scene) -> ArmNotClear:
    """The fault, with link and obstacle where it names none: those of the tool's own curve."""
    contacts = results["arm_clearance"].contacts
    if fault.where in ("start", "goal") or not contacts:
        return fault
    sentence = contact_sentence(contacts[0], scene.unit)
    return fault.along_tool(sentence[:1].lower() + sentence[1:])


def _followed(scene: Scene, bspline: Fit[BSpline], quadratic: Fit[Quadratic]) -> str:
    """Name of the curve that the arm executes.

    Raises:
        ClearanceNotHeld: the scene leaves the choice open and neither curve keeps the clearance.
    """
    if scene.motion.curve != "auto":
        return scene.motion.curve
    if quadratic.holds:
        return "quadratic"
    if bspline.holds:
        return "bspline"
    raise ClearanceNotHeld(scene.spline.clearance, bspline.clearance.distance)
