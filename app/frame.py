"""One picture of a tab: all that its layers, and the panels that draw, are drawn from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

from abi.errors import AbiError
from abi.planner.diagnosis import Reason
from abi.planner.plan import Plan
from app.style import Colour


@dataclass(frozen=True)
class Switch:
    """A line of the legend that switches something drawn on and off.

    Attributes:
        name: what :attr:`Frame.shown` has while it is on.
        label: what the page calls it.
        colour: the colour in which it is drawn.
        on: whether a new tab shows it.
    """

    name: str
    label: str
    colour: Colour
    on: bool = True


@dataclass(frozen=True, eq=False)
class Frame:
    """What a tab shows at one moment; the next is a copy with some parts replaced.

    Attributes:
        plan: what was planned last.
        reason: what was found out about its error.
        refused: what is wrong with what was typed last; the plan is of the scene before it.
        coarse: whether the plan's mesh is coarser than asked for, while the hand moves.
        partial: whether it is, or two of its searches wait until the hand rests.
        hasty: whether the hand may still move: what takes long to draw can wait.
        outdated: whether a newer plan is on its way.
        shown: names of the switches that are on.
        mesh_view: which part of the mesh to draw, of :data:`abi.search.subset.VIEWS`.
        expanded_share: part of the chosen search's expansions to draw, 0 to 1.
        time: moment of the motion, [s].
        playing: whether that moment goes on by itself.
    """

    plan: Plan
    reason: Reason | None = None
    refused: AbiError | None = None
    coarse: bool = False
    partial: bool = False
    hasty: bool = False
    outdated: bool = False
    shown: frozenset[str] = frozenset()
    mesh_view: str = "near"
    expanded_share: float = 0.0
    time: float = 0.0
    playing: bool = False

    @property
    def faded(self) -> bool:
        """Whether the plan is older than the panels."""
        return self.outdated or self.refused is not None

    @property
    def duration(self) -> float:
        """Time that the motion takes, [s]; 0 without one."""
        plan = self.plan
        return plan.profile.duration if plan.motion and plan.profile else 0.0


class Drawn(Protocol):
    """A layer, or a panel that draws."""

    def draw(self, frame: Frame) -> None:
        """Show ``frame``; return at once where all that it needs of it is what it drew last."""


class Switched(Protocol):
    """Something with lines in the legend."""

    switches: ClassVar[tuple[Switch, ...]]
