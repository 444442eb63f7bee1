"""Live planner: plans within a frame while something is dragged, in full at rest."""

from __future__ import annotations

from dataclasses import replace

from abi.planner.joint_space_motion import HASTY
from abi.planner.node_budget import NodeBudget
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.scene.scene import Scene


class LivePlanner:
    """Two planners, one for the scene's mesh and one for a coarser mesh, each with its own memory.

    Neither begins to compile the inner loops: :func:`abi.compile` does, beside the first plans.

    Attributes:
        budget: number of nodes that fit a frame.
    """

    def __init__(self) -> None:
        self.budget = NodeBudget()
        self._last_settings: tuple[object, ...] = ()
        self.forget()

    def __call__(self, scene: Scene) -> Plan:
        """Plan within a frame if possible: in full, by one search, or on a coarser mesh."""
        settings = _path_settings(scene)
        if settings == self._last_settings:
            return self.finish(scene)
        coarser = self.budget.coarser(scene)
        coarse = coarser is not None
        planner = self._coarse_planner if coarse else self._planner
        partial = coarse or planner.keeps_branch or not self.budget.fits_all_searches(scene)
        if not coarse:
            self._last_settings = () if partial else settings
        plan = planner(coarser or scene, chosen_only=partial, hasty=partial)
        if plan.mesh is not None and plan.path is not None:
            # the arm's time is an earlier plan's where this one ended before it
            arm = plan.ms["arm"] if plan.motion is not None else 0.0
            self.budget.learn(len(plan.mesh.points), plan.total_ms - arm)
        return replace(plan, coarse=coarse, partial=partial) if partial else plan

    def forget(self) -> None:
        """Drop the memory of earlier plans, but not what the budget has learnt from them."""
        self._planner = Planner(compile=False)
        self._coarse_planner = Planner(compile=False, effort=HASTY)
        self._last_settings = ()

    def finish(self, scene: Scene) -> Plan:
        """Plan in full, however long it takes."""
        self.budget.release()
        self._last_settings = _path_settings(scene)
        return self._planner(scene)

    def adopt(self, scene: Scene, partial: bool = False) -> None:
        """Continue from a plan of ``scene`` that another planner has made, in part or in full."""
        self._planner.skip_first()
        self._coarse_planner.skip_first()
        if not partial:
            self.budget.release()
        self._last_settings = () if partial else _path_settings(scene)


def _path_settings(scene: Scene) -> tuple[object, ...]:
    """Fields on which stages 1 to 3 depend; the other stages are fast on any mesh."""
    return (
        scene.workspace,
        scene.mesh,
        scene.obstacles,
        scene.start,
        scene.goal,
        scene.search,
        scene.spline.clearance,
        scene.arm if scene.arm.avoid else None,
    )
