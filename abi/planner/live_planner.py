"""Plans that keep up with the hand: one search, or a coarser mesh, while it moves; all at rest."""

from __future__ import annotations

from abi.planner.node_budget import NodeBudget
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.scene.scene import Scene


class LivePlanner:
    """Two planners, one for each mesh, so that neither loses what it remembers.

    Attributes:
        budget: how many nodes fit a frame.
        coarse: whether the last plan was on a coarser mesh than its scene asks for.
        partial: whether it was, or had one search alone.
    """

    def __init__(self, compile: bool = True) -> None:
        """Begin with nothing remembered; ``compile`` as for :class:`Planner`."""
        self.budget = NodeBudget()
        self.coarse = self.partial = False
        self._on_whole_mesh, self._on_coarse_mesh = Planner(compile), Planner(compile)
        self._last_route: tuple[object, ...] = ()

    def __call__(self, scene: Scene) -> Plan:
        """Plan within a frame if that can be done: in full, with one search, or coarsely."""
        route = _route(scene)
        if route == self._last_route:
            return self.finish(scene)
        coarser = self.budget.coarser(scene)
        self.coarse = coarser is not None
        self.partial = not self.budget.fits_all_searches(scene)
        if coarser is None:
            self._last_route = () if self.partial else route
            made = self._on_whole_mesh(scene, chosen_only=self.partial)
        else:
            made = self._on_coarse_mesh(coarser, chosen_only=True)
        if made.mesh is not None and made.path is not None:
            # of a plan that ended before it, the arm's time is an earlier plan's
            arm = made.ms["arm"] if made.motion is not None else 0.0
            self.budget.learn(len(made.mesh.points), made.total_ms - arm)
        return made

    def finish(self, scene: Scene) -> Plan:
        """Plan in full, however long it takes."""
        self.coarse = self.partial = False
        self._last_route = _route(scene)
        return self._on_whole_mesh(scene)


def _route(scene: Scene) -> tuple[object, ...]:
    """Settings that stages 1 to 3 depend on; all else is quick on any mesh."""
    return (
        scene.workspace,
        scene.mesh,
        scene.obstacles,
        scene.start,
        scene.goal,
        scene.search,
        scene.spline.clearance,
    )
