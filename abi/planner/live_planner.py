"""Plans that keep up with the hand: one search, or a coarser mesh, while it moves; all at rest."""

from __future__ import annotations

from abi.planner.node_budget import Pace
from abi.planner.plan import Plan, Planner
from abi.scene.scene import Scene


class LivePlanner:
    """Two planners, one for each mesh, so that neither loses what it remembers.

    Attributes:
        pace: how many nodes fit a frame.
        coarse: whether the last plan was on a coarser mesh than its scene asks for.
        partial: whether it was, or had one search alone.
    """

    def __init__(self, compile: bool = True) -> None:
        """Begin with nothing remembered; ``compile`` as for :class:`Planner`."""
        self.pace = Pace()
        self.coarse = self.partial = False
        self._whole, self._hasty = Planner(compile), Planner(compile)
        self._routed: tuple[object, ...] = ()

    def __call__(self, scene: Scene) -> Plan:
        """Plan within a frame if that can be done: in full, with one search, or coarsely."""
        route = _route(scene)
        if route == self._routed:
            return self.finish(scene)
        coarser = self.pace.coarser(scene)
        self.coarse = coarser is not None
        self.partial = not self.pace.fits_thrice(scene)
        if coarser is None:
            self._routed = () if self.partial else route
            made = self._whole(scene, chosen_only=self.partial)
        else:
            made = self._hasty(coarser, chosen_only=True)
        if made.mesh is not None and made.path is not None:
            # of a plan that ended before it, the arm's time is an earlier plan's
            arm = made.ms["arm"] if made.motion is not None else 0.0
            self.pace.took(len(made.mesh.points), made.total_ms - arm)
        return made

    def finish(self, scene: Scene) -> Plan:
        """Plan in full, however long it takes."""
        self.coarse = self.partial = False
        self._routed = _route(scene)
        return self._whole(scene)


def _route(scene: Scene) -> tuple[object, ...]:
    """What stages 1 to 3 depend on; all else is quick on any mesh."""
    return (
        scene.workspace,
        scene.mesh,
        scene.obstacles,
        scene.start,
        scene.goal,
        scene.search,
        scene.spline.clearance,
    )
