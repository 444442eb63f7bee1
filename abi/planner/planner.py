"""The planner: runs the stages in order, from a scene to a plan.

A :class:`Planner` remembers the last result of each stage, so that a change runs only the stages
downstream of it.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from types import MappingProxyType

from abi import compiling, progress
from abi.arm_planning.arm_errors import ArmNotClear, NoJointMotion
from abi.arm_planning.joint_search.search_joints import JointSearchEffort
from abi.compiled import interpreted_calls
from abi.errors import StageError
from abi.planner.arm_aware import ArmAware
from abi.planner.arm_words import contact_sentence
from abi.planner.foreseen import kernels_foreseen
from abi.planner.joint_space_motion import THOROUGH, asks_for_joints, may_search_joints
from abi.planner.plan import Plan
from abi.planner.slow_motion import refuse_slow
from abi.planner.stage_results import AnyFit
from abi.planner.tool_branch import ToolBranch
from abi.scene.arm_end import ENDS
from abi.scene.scene import Scene, require_scene
from abi.search.search import SEARCHES, SearchFunction

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

    def __init__(
        self,
        compile: bool = True,
        effort: JointSearchEffort = THOROUGH,
        searches: Mapping[str, SearchFunction] = SEARCHES,
    ) -> None:
        """Start without any remembered results.

        Args:
            compile: whether to compile the inner loops in the background from the first plan on. A
                plan that would take longer than the compiler waits for it all the same.
            effort: how long a motion is sought in the space of the joints.
            searches: the searches of stage 3, by the names that scenes have for them.
        """
        self._effort = effort
        self._compile, self._planned = compile, False
        self._turn = threading.Lock()
        self._tool = ToolBranch(searches)
        self._arm_aware, self._arm_aware_ms, self._arm_aware_interpreted = ArmAware(), 0.0, False
        self._in_joints = False  # whether the mesh led to no motion last, and the joints did

    def skip_first(self) -> None:
        """Take the first plan, which does not wait for kernels to be loaded, for made elsewhere."""
        self._planned = True

    @property
    def keeps_branch(self) -> bool:
        """Whether a hasty plan would try first, or alone, where a URDF arm moved in the last."""
        return self._in_joints or bool(self._arm_aware.kept)

    def __call__(self, scene: Scene, chosen_only: bool = False, hasty: bool = False) -> Plan:
        """Plan a scene.

        Args:
            scene: the scene.
            chosen_only: whether to run only the search that ``scene.search.algorithm`` names, which
                is faster.
            hasty: whether somebody waits for one of many plans: a URDF arm is then tried from the
                start pose of the last plan alone, or in the space of its joints if that had none,
                as long as there is a motion there, and then from one pose after the other until
                one has a motion; its path may be longer than need be, a path of its joints is kept
                while it is clear, and a quadratic that it does not follow is that of least squares.

        Returns:
            The plan. If the scene has none, its ``error`` says why, and nothing is raised.

        Raises:
            SceneError: ``scene`` is no scene.
        """
        require_scene(scene)
        with self._turn:
            return self._plan(scene, chosen_only, hasty)

    def _plan(self, scene: Scene, chosen_only: bool, hasty: bool) -> Plan:
        """Plan a scene, as the only call that runs."""
        if self._compile and (foreseen := kernels_foreseen(scene)):
            compiling.foresee(foreseen)
        # a tab's first plan does not wait: until it is drawn the page is empty
        if self._planned or self._compile:
            compiling.wait_for_loading()
        _wait_for_compiler(scene)
        begin = time.perf_counter()
        self._arm_aware_ms, self._arm_aware_interpreted = 0.0, False
        searches = (scene.search.algorithm,) if chosen_only else tuple(SEARCHES)
        self._tool.begin(scene, searches, hasty)
        found, fault = None, None
        try:
            found = self._run(self._tool)
            refuse_slow(found)
        except StageError as error:
            # a copy: the stage remembers its error for scenes in another unit
            fault = error.in_unit(scene.unit)
        total = 1e3 * (time.perf_counter() - begin)
        self._planned = True
        if self._compile:
            compiling.begin()
        plan = self._tool.plan if found is None else found  # as far as it came
        return replace(
            plan,
            error=fault,
            ms=MappingProxyType(self._times(plan.joint_search is not None)),
            interpreted=self._interpreted(),
            total_ms=total,
        )

    def _run(self, tool: ToolBranch) -> Plan:
        """Plan for the tool alone and, if the arm is not clear along that, for the whole arm.

        Returns:
            The plan of the branch that counts.

        Raises:
            StageError: there is no path or no curve for the tool, or no motion for the arm.
        """
        scene = tool.problem.scene
        if asks_for_joints(scene.arm):
            with suppress(StageError):  # what there is of the tool's own curve is shown, too
                self._curve(tool)
            return self._through_joints(tool)
        curve = self._curve(tool)
        if not scene.arm.avoid:
            moved = tool.move_arm(curve)
            if moved.motion is not None and moved.motion.error is not None:
                raise moved.motion.error
            return moved
        refuted = tool.is_refuted(curve)
        if not refuted and tool.move_arm(curve).is_arm_clear:
            return tool.plan
        in_joints: NoJointMotion | None = None
        if tool.problem.hasty and self._in_joints and may_search_joints(scene.arm):
            with suppress(NoJointMotion):
                return self._through_joints(tool)
        self._in_joints = False
        try:
            return self._avoid(tool)
        except ArmNotClear as fault:
            on_mesh = fault
        if may_search_joints(scene.arm):
            try:
                found = self._through_joints(tool)
            except NoJointMotion as fault:
                in_joints = fault
            else:
                self._in_joints = True
                return found
        # what is shown and told where there is no motion at all takes a while
        moved = tool.move_arm(curve)
        if on_mesh.explain is not None:
            on_mesh = on_mesh.explain()
        why: StageError = _with_contact(on_mesh, moved, scene)
        # where it leaves its pose the tool's own curve says less than why no pose will do
        held_up = on_mesh.where in ENDS and on_mesh.obstacle is not None
        reach = None if moved.motion is None else moved.motion.error
        if reach is not None and (on_mesh.has_elbow or not held_up):
            why = reach
        if in_joints is not None and isinstance(why, ArmNotClear) and in_joints.where not in ENDS:
            why = why.nor_in_joints(in_joints)
        raise why

    def _curve(self, tool: ToolBranch) -> AnyFit:
        """The curve of the tool alone that the arm is to follow.

        Raises:
            StageError: there is no path or no curve.
        """
        tool.find_path()
        tool.plan = replace(tool.plan, optimum=tool.optimum())
        return tool.fit_curves()

    def _through_joints(self, tool: ToolBranch) -> Plan:
        """The plan with a motion that is sought in the space of the joints.

        Raises:
            NoJointMotion: there is none.
        """
        found = tool.joint_motion(self._effort)
        return replace(
            tool.plan,
            profile=found.profile,
            motion=found.motion,
            arm_clearance=found.arm_clearance,
            followed=None,
            tool_only=tool.plan.followed_curve,
            joint_search=found.joint_search,
        )

    def _avoid(self, tool: ToolBranch) -> Plan:
        """The plan on the branch of the arm whose motion is clear and shortest.

        Raises:
            ArmNotClear: there is none.
        """
        progress.tell("avoiding with the whole arm")
        begin, before = time.perf_counter(), interpreted_calls()
        try:
            return self._arm_aware(tool.problem, tool.collision_world, tool.plan)
        finally:
            self._arm_aware_ms = 1e3 * (time.perf_counter() - begin)
            self._arm_aware_interpreted = interpreted_calls() > before

    def _times(self, searched: bool) -> dict[str, float]:
        """Time of each stage when it last ran, [ms]; of the joints' search if ``searched``."""
        parts = self._tool.parts.items()
        times = {name: sum(one.ms for one in stages) for name, stages in parts}
        if not searched:
            times["joint_search"] = 0.0  # that of another scene
        return times | {"arm_aware": self._arm_aware_ms}

    def _interpreted(self) -> frozenset[str]:
        """Stages in which inner loops ran as Python when they last ran."""
        parts = self._tool.parts.items()
        names = {name for name, stages in parts if any(stage.interpreted for stage in stages)}
        return frozenset(names | {"arm_aware"} if self._arm_aware_interpreted else names)


def _wait_for_compiler(scene: Scene) -> None:
    """Compile before planning where that is faster than planning without."""
    if compiling.is_done():
        return
    many = scene.mesh.node_count(scene.workspace) > _MANY_NODES
    if many or len(scene.obstacles) > _MANY_OBSTACLES:
        compiling.compile()


def _with_contact(fault: ArmNotClear, moved: Plan, scene: Scene) -> ArmNotClear:
    """The fault, with link and obstacle where it names none: those of the tool's own curve."""
    contacts = () if moved.arm_clearance is None else moved.arm_clearance.contacts
    if fault.where in ("start", "goal") or not contacts:
        return fault
    sentence = contact_sentence(contacts[0], scene.unit)
    return fault.along_tool(sentence[:1].lower() + sentence[1:])
