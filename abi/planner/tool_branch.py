"""The branch of the tool alone: the arm follows, and may touch something on the way."""

from __future__ import annotations

import operator
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

from abi import progress
from abi.arm_planning.arm_model import JointPath
from abi.arm_planning.models import model_of
from abi.arm_planning.motion.arm_clearance import ArmClearance
from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arm_planning.motion_law import motion_law
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.curves import fit_bspline, fit_quadratic
from abi.curves.bspline import BSpline
from abi.curves.cubic_profile import PathProfile
from abi.curves.fit import Fit
from abi.curves.quadratic import Quadratic
from abi.errors import ClearanceNotHeld
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.exclusion_cache import ExclusionCache
from abi.planner.joint_space_motion import JointSpaceMotions
from abi.planner.planning_problem import PlanningProblem, sample_count
from abi.planner.remembered_call import RememberedCall
from abi.planner.shared_mesh import shared_mesh
from abi.planner.stage_results import AnyFit, CurveName, ShortestPath, TimedMotion
from abi.scene.scene import Scene
from abi.scene.settings import MotionSettings
from abi.search.build_graph import build_graph
from abi.search.graph import Graph
from abi.search.search import SEARCHES, SearchFunction, SearchResult
from abi.search.taut.lower_bound import Bound, lower_bound
from abi.search.taut.taut_path import TautPath
from abi.search.taut.taut_path import taut as pull_taut
from abi.tet_mesh.exclusion import FreeMesh

_JOINT_PATHS = 2
"""Largest number of joint paths along the tool's own curve."""


class ToolStages:
    """What the tool's stages call, each of which remembers its last result."""

    def __init__(self, searches: Mapping[str, SearchFunction] = SEARCHES) -> None:
        self.obstacles = RememberedCall(ObstacleSet)
        self.mesh = RememberedCall(shared_mesh)
        self.exclude = RememberedCall(ExclusionCache())
        self.graph = RememberedCall(build_graph)
        # compared with each other: what else the machine did meanwhile is not theirs
        clock = time.thread_time
        self.searches = {name: RememberedCall(search, clock) for name, search in searches.items()}
        self.path_clearance = RememberedCall(ObstacleSet.polyline_clearance)
        self.taut = RememberedCall(pull_taut)
        self.optimum = RememberedCall(lower_bound)
        self.bspline = RememberedCall(fit_bspline.fit)
        self.quadratic = RememberedCall(fit_quadratic.fit)
        self.profiles = RememberedCall(_profiles)
        self.model = RememberedCall(model_of)
        # methods of any arm, and their arguments
        self.collision_world: RememberedCall[..., CollisionWorld] = RememberedCall(operator.call)
        self.joint_paths: RememberedCall[..., Sequence[JointPath]] = RememberedCall(operator.call)
        self.motions: list[RememberedCall[..., ArmMotion]]
        self.motions = [RememberedCall(operator.call) for _ in range(_JOINT_PATHS)]
        self.arm_clearances: list[RememberedCall[..., ArmClearance]]
        self.joints = RememberedCall(JointSpaceMotions())
        self.arm_clearances = [RememberedCall(operator.call) for _ in range(_JOINT_PATHS)]

    @property
    def parts(self) -> dict[str, Sequence[RememberedCall[..., Any]]]:
        """Parts of each stage of which a plan has the time."""
        return {
            "mesh": (self.mesh, self.exclude),
            "graph": (self.graph,),
            **{name: (search,) for name, search in self.searches.items()},
            "path_clearance": (self.path_clearance,),
            "taut": (self.taut,),
            "optimum": (self.optimum,),
            "bspline": (self.bspline,),
            "quadratic": (self.quadratic,),
            "timing": (self.profiles,),
            "joint_search": (self.joints,),
            "arm": (self.model, self.collision_world, self.joint_paths, *self.along_joint_paths),
        }

    @property
    def along_joint_paths(self) -> tuple[RememberedCall[..., Any], ...]:
        """Stages that run once for each joint_path."""
        return (*self.motions, *self.arm_clearances)


@dataclass(frozen=True, eq=False)
class ToolBranch:
    """The tool alone as a :class:`abi.planner.branch.Branch`: stages that remember their results.

    Attributes:
        problem: what to plan.
        stages: the stages.
    """

    problem: PlanningProblem
    stages: ToolStages

    @classmethod
    def of(
        cls, scene: Scene, searches: tuple[str, ...], stages: ToolStages, hasty: bool
    ) -> ToolBranch:
        """The tool alone in a scene, the names of the searches to run, and whether it is hasty."""
        progress.tell("reading obstacles and arm")
        obstacles, model = stages.obstacles(scene.obstacles), stages.model(scene.arm, scene.unit)
        return cls(PlanningProblem(scene, obstacles, model, searches, hasty), stages)

    def free_mesh(self) -> FreeMesh:
        """Stage 1: the mesh without the nodes and edges that the obstacles exclude."""
        progress.tell("making the mesh")
        mesh = self.stages.mesh(self.problem.scene.workspace, self.problem.scene.mesh)
        return self.stages.exclude(mesh, self.problem.obstacles, self.problem.margin)

    def graph(self, free: FreeMesh) -> Graph:
        """Stage 2: start and goal joined to the mesh.

        Raises:
            StageError: start or goal is blocked, or they are the same point.
        """
        progress.tell("testing the mesh's edges")
        scene, obstacles, margin = self.problem.scene, self.problem.obstacles, self.problem.margin
        return self.stages.graph(
            free, obstacles, margin, scene.start, scene.goal, scene.spline.clearance
        )

    def shortest(self, graph: Graph) -> ShortestPath:
        """Stage 3: the shortest path, by the search that the scene chooses.

        Raises:
            NoPath: there is none.
        """
        progress.tell("searching")
        chosen = self.problem.scene.search
        path = self.stages.searches[chosen.algorithm](graph, chosen.weight)
        return ShortestPath(
            graph, path, self.stages.path_clearance(self.problem.obstacles, path.points)
        )

    def searches(self, shortest: ShortestPath) -> tuple[SearchResult, ...]:
        """Stage 3: all searches that are asked for."""
        chosen, searches = self.problem.scene.search, self.stages.searches
        return tuple(
            shortest.path
            if name == chosen.algorithm
            else searches[name](shortest.graph, chosen.weight)
            for name in self.problem.searches
        )

    def optimum(self) -> Bound:
        """Lower bound of the length of any curve."""
        scene = self.problem.scene
        ends = scene.start, scene.goal
        return self.stages.optimum(
            *ends, self.problem.obstacles, scene.spline.clearance, scene.workspace
        )

    def bspline(self, shortest: ShortestPath) -> tuple[TautPath | None, Fit[BSpline]]:
        """Stages 3½ and 4: the path pulled taut, if that is asked for, and a B-spline near it."""
        problem, stages, wanted = self.problem, self.stages, self.problem.scene.spline
        graph, path, away = shortest
        points, taut = path.points, None
        if problem.scene.search.taut:
            taut = stages.taut(graph, problem.obstacles, problem.margin, path)
            points, away = taut.points, taut.clearance
        progress.tell("fitting curves")
        return taut, stages.bspline(
            points, wanted.degree, problem.obstacles, wanted.clearance, taut is not None, away
        )

    def quadratic(self, bspline: Fit[BSpline]) -> Fit[Quadratic]:
        """Stage 5: the quadratic nearest to the B-spline."""
        scene, obstacles = self.problem.scene, self.problem.obstacles
        return self.stages.quadratic(
            bspline, obstacles, scene.spline.clearance, self.problem.quadratic_mode
        )

    def followed(self, bspline: Fit[BSpline], quadratic: Fit[Quadratic]) -> CurveName:
        """Name of the curve that the arm follows.

        Raises:
            ClearanceNotHeld: the scene leaves the choice open and neither keeps the clearance.
        """
        scene = self.problem.scene
        if scene.motion.curve != "auto":
            return scene.motion.curve
        if quadratic.holds:
            return "quadratic"
        if bspline.holds:
            return "bspline"
        raise ClearanceNotHeld(scene.spline.clearance, bspline.clearance.distance)

    def is_refuted(self, followed: AnyFit) -> bool:
        """Check if it shows at once that the arm is not clear along the curve on any joint_path.

        Only then need the motion along it not be sampled and measured, which takes longer.
        """
        problem, required, around = (
            self.problem,
            self.problem.scene.arm.clearance,
            self.collision_world,
        )
        if problem.model.is_refuted(followed.curve, followed.arc, around, required):
            self._skip(self.stages.joint_paths, *self.stages.along_joint_paths)
            return True
        joint_paths = self._joint_paths(followed)
        refuted = all(
            joint_path.is_refuted(partial(self._profile, joint_paths, k), around, required)
            for k, joint_path in enumerate(joint_paths)
        )
        if refuted:
            self._skip(*self.stages.along_joint_paths)
        return refuted

    @staticmethod
    def _skip(*stages: RememberedCall[..., Any]) -> None:
        """Let stages that do not run take no time."""
        for stage in stages:
            stage.ms = 0.0

    def motion(self, followed: AnyFit) -> TimedMotion:
        """Stage 6: the motion on the last joint_path that is clear, or else on the first."""
        joint_paths = self._joint_paths(followed)
        moved = [
            self._moved(k, joint_path, self._profile(joint_paths, k))
            for k, joint_path in enumerate(joint_paths)
        ]
        return next((one for one in reversed(moved) if one.is_clear), moved[0])

    def _moved(self, number: int, joint_path: JointPath, profile: PathProfile) -> TimedMotion:
        """The motion on one joint_path, with the memory of its number."""
        stages, required = self.stages, self.problem.scene.arm.clearance
        asked = self.problem.scene.motion
        motion = stages.motions[number](joint_path.motion, profile, sample_count(profile, asked))
        clearance = stages.arm_clearances[number](
            joint_path.clearance, motion, self.collision_world, required
        )
        return TimedMotion(profile, motion, clearance)

    @cached_property
    def collision_world(self) -> CollisionWorld:
        """Everything around the arm."""
        lowest = self.problem.scene.workspace.min[2]
        return self.stages.collision_world(
            self.problem.model.collision_world, self.problem.obstacles, lowest
        )

    def _joint_paths(self, followed: AnyFit) -> Sequence[JointPath]:
        """Joint paths along the curve, one for each branch of the arm."""
        progress.tell("moving the arm")
        problem, curve = self.problem, followed.curve
        return self.stages.joint_paths(
            *(problem.model.joint_paths, curve, followed.arc, problem.scene.arm),
            *(self.collision_world, problem.hasty),
        )

    def _profile(self, joint_paths: Sequence[JointPath], number: int) -> PathProfile:
        """Motion along one of the joint_paths."""
        return self.stages.profiles(joint_paths, self.problem.scene.motion)[number]


def _profiles(joint_paths: Sequence[JointPath], asked: MotionSettings) -> tuple[PathProfile, ...]:
    """Motion along each of the joint_paths by the law that is asked for."""
    return tuple(motion_law(joint_path, asked) for joint_path in joint_paths)
