"""Plans for the whole arm: on the branch where the path is shortest, of those with a motion.

They are made only if the arm is not proven clear along the tool's own plan. The branches of the
paper's arm are the two sides of its elbow, which meet only where the arm is stretched; those of
another arm are its start poses. They are searched one by one. If none of them leads to a motion, an
arm with redundant joints has further ones.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from typing import NamedTuple

from abi.arm_planning.arm_model import ArmBranch, BranchTask
from abi.arm_planning.branch.arm_exclusion import ArmExclusionCache
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.errors import ArmNotClear
from abi.planner.branch import BranchResults, ShortestPath
from abi.planner.pipeline import find_path, follow_path
from abi.planner.planning_task import PlanningTask
from abi.planner.whole_arm_branch import WholeArmBranch

_PATIENCE = 20
"""Times as many tries to prove a segment clear where there is no path else."""


class _Candidate(NamedTuple):
    """A branch that has a path, and the results so far."""

    branch: WholeArmBranch
    path: ShortestPath
    results: BranchResults


class ArmAware:
    """Planner for the whole arm, which remembers what the arm excludes from the mesh."""

    def __init__(self) -> None:
        self._exclude: dict[str, ArmExclusionCache] = {}

    def __call__(
        self, task: PlanningTask, collision_world: CollisionWorld, tool: BranchResults
    ) -> BranchResults:
        """Results on a branch on which the whole arm is proven clear.

        Args:
            task: what to plan.
            collision_world: everything around the arm.
            tool: results of the tool alone, up to the curves.

        Raises:
            ArmNotClear: no branch has a motion; tells why.
        """
        assert tool.free is not None
        slack = task.margin - task.scene.spline.clearance
        asked = BranchTask(task.scene, task.obstacles, collision_world, tool.free.mesh, slack)
        arm_branches = task.model.branches(asked)
        on = partial(self._branch, task, collision_world, tool)
        faults: dict[str, ArmNotClear] = {}
        candidates = _with_path([on(one, one.name) for one in arm_branches], tool, faults)
        if not candidates:  # near the base axis, and along an obstacle, a proof may take more
            shut = [one for one in arm_branches if faults[one.name].where == "path"]
            patient = [on(one.scaled(tries=_PATIENCE), one.name) for one in shut]
            candidates = _with_path(patient, tool, faults)
        for branch, path, results in sorted(candidates, key=_cost):
            try:
                follow_path(branch, path, results)
            except ArmNotClear as fault:
                faults[branch.arm_branch.name] = fault
            else:
                return results
        others = task.model.other_branches(asked)
        branches = (on(one, f"other {number}") for number, one in enumerate(others.branches))
        return _first_motion(branches, tool, [*faults.values()], others.note)

    def _branch(
        self,
        task: PlanningTask,
        collision_world: CollisionWorld,
        tool: BranchResults,
        arm_branch: ArmBranch,
        memory: str,
    ) -> WholeArmBranch:
        """An arm's branch; what it excludes is kept in a ``memory`` of that name."""
        assert tool.free is not None
        exclude = self._exclude.setdefault(memory, ArmExclusionCache())
        return WholeArmBranch(task, collision_world, tool.free, tool.taut, arm_branch, exclude)


def _with_path(
    branches: Iterable[WholeArmBranch], tool: BranchResults, faults: dict[str, ArmNotClear]
) -> list[_Candidate]:
    """The branches that have a path; ``faults`` gets why the others have none."""
    candidates = []
    for branch in branches:
        results = tool.for_arm()
        try:
            candidates.append(_Candidate(branch, find_path(branch, results), results))
        except ArmNotClear as fault:
            faults[branch.arm_branch.name] = fault
    return candidates


def _first_motion(
    branches: Iterable[WholeArmBranch],
    tool: BranchResults,
    faults: Sequence[ArmNotClear],
    note: str,
) -> BranchResults:
    """Results on the first of the further branches that leads to a motion.

    Args:
        branches: the branches.
        tool: results of the tool alone.
        faults: why those tried before lead to none.
        note: sentence on why there are no further ones.

    Raises:
        ArmNotClear: there is none.
    """
    found = []
    for branch in branches:
        results = tool.for_arm()
        try:
            follow_path(branch, find_path(branch, results), results)
        except ArmNotClear as fault:
            found.append(fault)
        else:
            return results
    raise ArmNotClear.of_all(faults, found, note)


def _cost(candidate: _Candidate) -> float:
    return candidate.path.path.cost
