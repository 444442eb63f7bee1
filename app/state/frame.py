"""Frame: the state of a tab's picture at one moment, from which every layer and panel draws."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from abi.certification.verdict import MotionVerdict
from abi.curves.bspline import BSpline
from abi.curves.fit import Fit
from abi.errors import AbiError
from abi.explain.base_map import BaseMap
from abi.explain.reason import Reason
from abi.planner.plan import Plan
from app.theatre.theatre import Theatre


@dataclass(frozen=True, eq=False)
class Frame:
    """Contents of a tab at one moment; the next frame is a copy with some parts replaced.

    Attributes:
        plan: the last one.
        before: the last plan at rest that is not this one, to compare; None if there was none.
        checked: the verdict on a motion from elsewhere, which is then the plan's; None for a plan
            of the tab's own.
        reason: diagnosis of its error.
        refused: error in the last input, which the plan leaves out.
        interactive: whether the input may still change: what takes long to draw can wait.
        outdated: whether a newer plan is being made.
        demonstrates: whether an obstacle moves by itself.
        shown: names of the switches that are on.
        mesh_view: which part of the mesh to draw, of :data:`abi.search.subset.VIEWS`.
        visited: number of nodes to draw in the order in which the chosen search expanded them.
        theatre: the search that is stepped through; None while none is.
        bent: the B-spline with control points moved by hand; None while none are.
        bases: places tried for the arm's base; None while none are.
        time: since the begin of the motion, [s].
        playing: whether it advances by itself.
        again: whether it begins anew after its end; otherwise another motion follows.
        lesson: whether one is gone through: what else there is to read waits.
        asks: whether its page asks something that is not answered yet: no number may give it away.
        lecture: whether the page is to be read from afar.
        stage: that a lecture shows alone, named as its folder; empty for all of them.
        label_scale: of the labels in the scene.
        rate: seconds of the motion for one of the clock, while it does.
        plots: whether the tab with the plots has been opened: until then it stays empty.
    """

    plan: Plan
    before: Plan | None = None
    checked: MotionVerdict | None = None
    reason: Reason | None = None
    refused: AbiError | None = None
    interactive: bool = False
    outdated: bool = False
    demonstrates: bool = False
    shown: frozenset[str] = frozenset()
    mesh_view: str = "near"
    visited: int = 0
    theatre: Theatre | None = None
    bent: Fit[BSpline] | None = None
    bases: BaseMap | None = None
    time: float = 0.0
    playing: bool = False
    again: bool = True
    lesson: bool = False
    asks: bool = False
    lecture: bool = False
    stage: str = ""
    label_scale: float = 1.0
    rate: float = 1.0
    plots: bool = False

    @property
    def current(self) -> bool:
        """Whether the plan belongs to the present input."""
        return not self.outdated and self.refused is None

    @property
    def tells_curve(self) -> bool:
        """Whether to show numbers of the followed curve.

        A lesson that does not show it has no use for them, and one that asks would give them away.
        """
        return not self.lesson or (not self.asks and self.plan.followed in self.shown)

    @property
    def duration(self) -> float:
        """Duration of the motion, [s]; 0 without one."""
        plan = self.plan
        return plan.profile.duration if plan.motion and plan.profile else 0.0


Draw = Callable[[Frame], None]
"""Shows a frame, of which it sends only what is new: a layer of a tab, or a panel that draws."""
