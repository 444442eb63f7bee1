"""Map of the places tried for an arm's base in a region, with the result of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from abi.arrays import ShortRepr
from abi.obstacles.pose import Vec3
from abi.scene.scene import Scene


@dataclass(frozen=True)
class BaseTrial:
    """A place of the base that was tried, and the cell of the region that it stands for.

    Attributes:
        base: the place, [unit], world.
        cell: sides of the cell around it, [unit].
        length: length of the curve that the arm follows, on all legs of its tasks, [unit]; None
            without a certified plan.
        clearance: distance that the links are proven to keep from the obstacles, [unit].
        fault: reason why there is no certified plan; empty if there is one.
        rank: how far the plan got; larger is farther.
    """

    base: Vec3
    cell: Vec3
    length: float | None = None
    clearance: float = 0.0
    fault: str = ""
    rank: int = 0

    @property
    def order(self) -> tuple[float, float]:
        """Sort key of places, best first: by length, then by clearance."""
        if self.length is None:
            return float("inf"), -self.rank
        return self.length, -self.clearance


@dataclass(frozen=True, eq=False, repr=False)
class BaseMap(ShortRepr):
    """The places tried so far.

    Attributes:
        scene: the scene, with the base that it has.
        low: low corner of the region, [unit], world.
        high: its high corner.
        trials: all places, in the order in which they were tried.
        cells: those whose cells cover the region as finely as it was searched.
        planned: number of plans made so far, and the expected total.
        is_done: whether the search is complete.
        fault: sentence on why no base helps, if the tool itself has no plan; else empty.
    """

    scene: Scene
    low: Vec3
    high: Vec3
    trials: tuple[BaseTrial, ...] = ()
    cells: tuple[BaseTrial, ...] = ()
    planned: tuple[int, int] = (0, 1)
    is_done: bool = False
    fault: str = ""

    @property
    def best(self) -> BaseTrial | None:
        """Place of the shortest certified plan, the clearest among equals; None without any."""
        found = [trial for trial in self.trials if trial.length is not None]
        return min(found, key=lambda trial: trial.order, default=None)

    @property
    def lengths(self) -> tuple[float, float] | None:
        """Least and greatest length found, [unit]; None without any."""
        lengths = [trial.length for trial in self.trials if trial.length is not None]
        return (min(lengths), max(lengths)) if lengths else None

    @property
    def faults(self) -> Mapping[str, int]:
        """Number of places for each reason why a plan is not certified, most frequent first."""
        counts = Counter(trial.fault for trial in self.trials if trial.length is None)
        return dict(counts.most_common())
