"""The branch of the tool alone: the arm follows, and may touch something on the way."""

from __future__ import annotations

import operator
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from abi import progress
from abi.arm_planning.branch.arm_branch import JointPath
from abi.arm_planning.joint_search.search_joints import JointSearchEffort
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
from abi.errors import clearance_not_held
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.branch import Branch
from abi.planner.exclusion_cache import ExclusionCache
from abi.planner.joint_space_motion import JointSpaceMotions
from abi.planner.plan import Plan
from abi.planner.planning_problem import PlanningProblem, sample_count
from abi.planner.remembered_call import RememberedCall
from abi.planner.stage_results import AnyFit, CurveName
from abi.scene.scene import Scene
from abi.scene.settings import MotionSettings
from abi.search.build_graph import build_graph
from abi.search.graph import Graph
from abi.search.search import SEARCHES, SearchFunction, SearchResult
from abi.search.taut.lower_bound import Bound, lower_bound
from abi.search.taut.taut_path import TautPath
from abi.search.taut.taut_path import taut as pull_taut
from abi.tet_mesh.exclusion import FreeMesh
from abi.tet_mesh.tet_mesh import shared_mesh

_JOINT_PATHS = 2
"""Largest number of joint paths along the tool's own curve."""


class ToolBranch(Branch):
    """The tool alone: each of its stages remembers its last result from one plan to the next."""

    def __init__(self, searches: Mapping[str, SearchFunction] = SEARCHES) -> None:
        """Remember nothing yet; ``searches`` are those of stage 3, by name."""
        self._read_obstacles = RememberedCall(ObstacleSet)
        self._make_mesh = RememberedCall(shared_mesh)
        self._exclude = RememberedCall(ExclusionCache())
        self._build_graph = RememberedCall(build_graph)
        # compared with each other: what else the machine did meanwhile is not theirs
        clock = time.thread_time
        self._find = {name: RememberedCall(search, clock) for name, search in searches.items()}
        self._clearance_of = RememberedCall(ObstacleSet.polyline_clearance)
        self._pull_taut = RememberedCall(pull_taut)
        self._lower_bound = RememberedCall(lower_bound)
        self._fit_bspline = RememberedCall(fit_bspline.fit)
        self._fit_quadratic = RememberedCall(fit_quadratic.fit)
        self._profiles = RememberedCall(_profiles)
        self._model_of = RememberedCall(model_of)
        # methods of any arm, and their arguments
        self._collision_world: RememberedCall[..., CollisionWorld] = RememberedCall(operator.call)
        self._joint_paths: RememberedCall[..., Sequence[JointPath]] = RememberedCall(operator.call)
        self._motions: list[RememberedCall[..., ArmMotion]]
        self._motions = [RememberedCall(operator.call) for _ in range(_JOINT_PATHS)]
        self._arm_clearances: list[RememberedCall[..., ArmClearance]]
        self._arm_clearances = [RememberedCall(operator.call) for _ in range(_JOINT_PATHS)]
        self._search_joints = RememberedCall(JointSpaceMotions())

    def begin(self, scene: Scene, searches: tuple[str, ...], hasty: bool) -> None:
        """Begin the plan of a scene, with the names of the searches to run."""
        progress.tell("reading obstacles and arm")
        obstacles, model = (
            self._read_obstacles(scene.obstacles),
            self._model_of(scene.arm, scene.unit),
        )
        self.problem = PlanningProblem(scene, obstacles, model, searches, hasty)
        self.plan = Plan(scene, arm=model.arm)

    @property
    def parts(self) -> dict[str, Sequence[RememberedCall[..., Any]]]:
        """Parts of each stage of which a plan has the time."""
        return {
            "mesh": (self._make_mesh, self._exclude),
            "graph": (self._build_graph,),
            **{name: (search,) for name, search in self._find.items()},
            "path_clearance": (self._clearance_of,),
            "taut": (self._pull_taut,),
            "optimum": (self._lower_bound,),
            "bspline": (self._fit_bspline,),
            "quadratic": (self._fit_quadratic,),
            "timing": (self._profiles,),
            "joint_search": (self._search_joints,),
            "arm": (
                *(self._model_of, self._collision_world, self._joint_paths),
                *self._along_joint_paths,
            ),
        }

    @property
    def _along_joint_paths(self) -> tuple[RememberedCall[..., Any], ...]:
        """Calls that are made once for each joint path."""
        return (*self._motions, *self._arm_clearances)

    def free_mesh(self) -> FreeMesh:
        """Stage 1: the mesh without the nodes and edges that the obstacles exclude."""
        progress.tell("making the mesh")
        mesh = self._make_mesh(self.problem.scene.workspace, self.problem.scene.mesh)
        return self._exclude(mesh, self.problem.obstacles, self.problem.margin)

    def graph(self, free: FreeMesh) -> Graph:
        """Stage 2: start and goal joined to the mesh.

        Raises:
            StageError: start or goal is blocked, or they are the same point.
        """
        progress.tell("testing the mesh's edges")
        scene, obstacles, margin = self.problem.scene, self.problem.obstacles, self.problem.margin
        return self._build_graph(
            free, obstacles, margin, scene.start, scene.goal, scene.spline.clearance
        )

    def shortest(self, graph: Graph) -> tuple[Graph, SearchResult, float]:
        """Stage 3: the shortest path, by the search that the scene chooses.

        Raises:
            StageError: there is none.
        """
        progress.tell("searching")
        chosen = self.problem.scene.search
        path = self._find[chosen.algorithm](graph, chosen.weight)
        return graph, path, self._clearance_of(self.problem.obstacles, path.points)

    def searches(self, graph: Graph, path: SearchResult) -> tuple[SearchResult, ...]:
        """Stage 3: all searches that are asked for."""
        chosen = self.problem.scene.search
        return tuple(
            path if name == chosen.algorithm else self._find[name](graph, chosen.weight)
            for name in self.problem.searches
        )

    def optimum(self) -> Bound:
        """Lower bound of the length of any curve."""
        scene = self.problem.scene
        ends = scene.start, scene.goal
        return self._lower_bound(
            *ends, self.problem.obstacles, scene.spline.clearance, scene.workspace
        )

    def bspline(
        self, graph: Graph, path: SearchResult, away: float
    ) -> tuple[TautPath | None, Fit[BSpline]]:
        """Stages 3½ and 4: the path pulled taut, if that is asked for, and a B-spline near it."""
        problem, wanted = self.problem, self.problem.scene.spline
        points, taut = path.points, None
        if problem.scene.search.taut:
            taut = self._pull_taut(graph, problem.obstacles, problem.margin, path)
            points, away = taut.points, taut.clearance
        progress.tell("fitting curves")
        return taut, self._fit_bspline(
            points, wanted.degree, problem.obstacles, wanted.clearance, taut is not None, away
        )

    def quadratic(self, bspline: Fit[BSpline]) -> Fit[Quadratic]:
        """Stage 5: the quadratic nearest to the B-spline."""
        scene, obstacles = self.problem.scene, self.problem.obstacles
        return self._fit_quadratic(
            bspline, obstacles, scene.spline.clearance, self.problem.quadratic_mode
        )

    def followed(self, bspline: Fit[BSpline], quadratic: Fit[Quadratic]) -> CurveName:
        """Name of the curve that the arm follows.

        Raises:
            StageError: the scene leaves the choice open and neither keeps the clearance.
        """
        scene = self.problem.scene
        if scene.motion.curve != "auto":
            return scene.motion.curve
        if quadratic.holds:
            return "quadratic"
        if bspline.holds:
            return "bspline"
        raise clearance_not_held(scene.spline.clearance, bspline.clearance.distance)

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
            self._skip(self._joint_paths, *self._along_joint_paths)
            return True
        joint_paths = self._paths_along(followed)
        refuted = all(
            joint_path.is_refuted(partial(self._profile, joint_paths, k), around, required)
            for k, joint_path in enumerate(joint_paths)
        )
        if refuted:
            self._skip(*self._along_joint_paths)
        return refuted

    @staticmethod
    def _skip(*stages: RememberedCall[..., Any]) -> None:
        """Let stages that do not run take no time."""
        for stage in stages:
            stage.ms = 0.0

    def motion(self, followed: AnyFit) -> Plan:
        """Stage 6: the motion on the last joint path that is clear, or else on the first."""
        joint_paths = self._paths_along(followed)
        moved = [
            self._moved(k, joint_path, self._profile(joint_paths, k))
            for k, joint_path in enumerate(joint_paths)
        ]
        return next((one for one in reversed(moved) if one.is_arm_clear), moved[0])

    def _moved(self, number: int, joint_path: JointPath, profile: PathProfile) -> Plan:
        """The plan with the motion on one joint path, with the memory of its number."""
        scene = self.problem.scene
        count = sample_count(profile, scene.motion)
        motion = self._motions[number](joint_path.motion, profile, count)
        clearance = self._arm_clearances[number](
            joint_path.clearance, motion, self.collision_world, scene.arm.clearance
        )
        return replace(self.plan, profile=profile, motion=motion, arm_clearance=clearance)

    @property
    def collision_world(self) -> CollisionWorld:
        """Everything around the arm."""
        lowest = self.problem.scene.workspace.min[2]
        return self._collision_world(
            self.problem.model.collision_world, self.problem.obstacles, lowest
        )

    def _paths_along(self, followed: AnyFit) -> Sequence[JointPath]:
        """Joint paths along the curve, one for each branch of the arm."""
        progress.tell("moving the arm")
        problem, curve = self.problem, followed.curve
        return self._joint_paths(
            *(problem.model.joint_paths, curve, followed.arc, problem.scene.arm),
            *(self.collision_world, problem.hasty),
        )

    def joint_motion(self, effort: JointSearchEffort) -> Plan:
        """The plan of a motion that is sought in the space of the joints instead, and nothing else.

        Raises:
            NoJointMotion: there is none.
        """
        problem, arm = self.problem, self.problem.model.chain_arm
        assert arm is not None
        return self._search_joints(problem.scene, arm, self.collision_world, effort, problem.hasty)

    def _profile(self, joint_paths: Sequence[JointPath], number: int) -> PathProfile:
        """Motion along one of the joint_paths."""
        return self._profiles(joint_paths, self.problem.scene.motion)[number]


def _profiles(joint_paths: Sequence[JointPath], asked: MotionSettings) -> tuple[PathProfile, ...]:
    """Motion along each of the joint_paths by the law that is asked for."""
    return tuple(motion_law(joint_path, asked) for joint_path in joint_paths)
