"""Plans for the whole arm: on the branch where the path is shortest, of those with a motion.

They are made only if the arm is not proven clear along the tool's own plan. The branches of the
paper's arm are the two sides of its elbow, which meet only where the arm is stretched; those of
another arm are its start poses. They are searched one by one. If none of them leads to a motion, an
arm with redundant joints has further ones.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from heapq import heappop, heappush

from abi.arm_planning.arm_errors import ArmNotClear
from abi.arm_planning.branch.arm_branch import ArmBranch
from abi.arm_planning.branch.branch_memory import BranchMemory
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.planner.plan import Plan
from abi.planner.planning_problem import PlanningProblem
from abi.planner.whole_arm_branch import WholeArmBranch

_NO_PATH = ("start", "goal", "path")
"""Faults that there are before a path is found."""
_PATIENCE = 20
"""Times as many tries to prove a segment clear where there is no path else."""


class ArmAware:
    """Planner for the whole arm, which remembers what the arm excludes from the mesh.

    Attributes:
        kept: name of the branch that led to the last plan, in haste the only one that is tried as
            long as it leads to a motion; then the first other that does. Empty for none, and for an
            arm whose branches are the two sides of its elbow.
    """

    def __init__(self) -> None:
        self._memories: dict[str, BranchMemory] = {}
        self.kept, self._memory = "", ""

    def __call__(
        self, problem: PlanningProblem, collision_world: CollisionWorld, tool: Plan
    ) -> Plan:
        """The plan on a branch on which the whole arm is proven clear.

        Args:
            problem: what to plan; in haste the kept branch will do if it has a motion.
            collision_world: everything around the arm.
            tool: the plan for the tool alone, up to the curves.

        Raises:
            ArmNotClear: no branch has a motion; tells why.
        """
        assert tool.free is not None
        slack = problem.margin - problem.scene.spline.clearance
        asked = problem.scene, collision_world, tool.free.mesh, slack

        def on(arm_branch: ArmBranch, memory: str) -> WholeArmBranch:
            """An arm's branch, with the memory of that name."""
            kept = self._memories.setdefault(memory, BranchMemory())
            return WholeArmBranch(problem, collision_world, tool, arm_branch, kept)

        if problem.hasty and self.kept:
            kept = [on(one, self._memory) for one in problem.model.branches(*asked, self.kept)]
            if (found := _shortest_motion(kept)[0]) is not None:
                return found.plan
        every, found, faults = list[WholeArmBranch](), None, dict[str, ArmNotClear]()
        if problem.hasty and not problem.model.arm.has_elbow:
            # to make all takes longer than a frame, and at rest they are compared
            for one in problem.model.branches_in_turn(*asked):
                every.append(on(one, one.name))
                found, refused = _shortest_motion(every[-1:])
                faults |= refused
                if found is not None:
                    break
        else:
            every = [on(one, one.name) for one in problem.model.branches(*asked)]
            found, faults = _shortest_motion(every)
        self.kept = ""
        if found is not None and not problem.model.arm.has_elbow:
            self.kept = self._memory = found.arm_branch.name
        if found is None and all(fault.where in _NO_PATH for fault in faults.values()):
            # near the base axis, and along an obstacle, a proof may take more
            shut = [one.arm_branch for one in every if faults[one.arm_branch.name].where == "path"]
            patient = [on(one.scaled(tries=_PATIENCE), one.name) for one in shut]
            found, again = _shortest_motion(patient)
            faults |= again
        if found is not None:
            return found.plan
        others, note = problem.model.other_branches(*asked)
        branches = (on(one, f"other {number}") for number, one in enumerate(others))
        of_name = {one.arm_branch.name: one for one in every}
        why = [(of_name[name], fault) for name, fault in faults.items()]
        name, number, plan = _first_motion(branches, why, note)
        self.kept, self._memory = name, f"other {number}"
        return plan


_Fault = tuple[WholeArmBranch, ArmNotClear]
"""A branch, and why it leads to no motion."""


def _shortest_motion(
    branches: Sequence[WholeArmBranch],
) -> tuple[WholeArmBranch | None, dict[str, ArmNotClear]]:
    """The branch with the shortest path that leads to a motion, planned; None without any.

    Whether a path's edges are clear takes longest, so it is asked only of a branch whose path may
    be the shortest, by the search on all its edges.

    Returns:
        It, and why branches by their names lead to none: those without a path first.
    """
    shut: dict[int, ArmNotClear] = {}
    failed: dict[str, ArmNotClear] = {}
    # cost of the path, or a lower bound as long as there is none; of equals the first branch
    waiting: list[tuple[float, int, WholeArmBranch]] = []
    for number, branch in enumerate(branches):
        try:
            heappush(waiting, (branch.least_cost(branch.build_graph()), number, branch))
        except ArmNotClear as fault:
            shut[number] = fault
    found = None
    while waiting and found is None:
        _, number, branch = heappop(waiting)
        graph, path = branch.plan.graph, branch.plan.path
        try:
            if path is None:
                assert graph is not None
                heappush(waiting, (branch.search(graph), number, branch))
            else:
                branch.move_arm(branch.fit_curves())
                found = branch
        except ArmNotClear as fault:
            if path is None:
                shut[number] = fault
            else:
                failed[branch.arm_branch.name] = fault
    names = [one.arm_branch.name for one in branches]
    return found, {names[number]: shut[number] for number in sorted(shut)} | failed


def _first_motion(
    branches: Iterable[WholeArmBranch],
    faults: Sequence[_Fault],
    note: str,
) -> tuple[str, int, Plan]:
    """The plan on the first of the further branches that leads to a motion.

    Args:
        branches: the branches.
        faults: why those tried before lead to none.
        note: sentence on why there are no further ones.

    Returns:
        Name and number of that branch, and the plan.

    Raises:
        ArmNotClear: there is none.
    """
    found: list[_Fault] = []
    for number, branch in enumerate(branches):
        try:
            branch.find_path()
            branch.move_arm(branch.fit_curves())
        except ArmNotClear as fault:
            found.append((branch, fault))
        else:
            return branch.arm_branch.name, number, branch.plan
    first, others = ([fault for _, fault in some] for some in (faults, found))
    error = ArmNotClear.of_all(first, others, note)
    error.explain = partial(_explained, faults, found, note)
    raise error


def _explained(faults: Sequence[_Fault], others: Sequence[_Fault], note: str) -> ArmNotClear:
    """The error of all branches with what the links themselves do."""
    first, rest = ([one.explained(fault) for one, fault in some] for some in (faults, others))
    return ArmNotClear.of_all(first, rest, note)
