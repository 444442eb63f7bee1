"""Cache of polylines along which an arm's tool was led, from one plan to the next.

While an obstacle is dragged most polylines that are asked about are those of the last plan, and the
other obstacles stand where they stood. So the joints along a polyline are kept, and where the arm
was clear only what has changed around it is asked about.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence

from abi.arm_planning.branch.followed import Followed
from abi.arm_planning.motion.urdf_motion import ChainJointPath
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arm_planning.world.world_change import Change, World, world_change
from abi.curves.clearance.certificate import Refutation
from abi.obstacles.obstacle_set import Obstacle

_MOST = 4_000
"""Most polylines that are cached."""
_WORLDS = 16
"""Latest collision worlds for which it is known what was clear."""

Key = tuple[object, ...]
"""Cache key beside the collision world, such as the bytes of a polyline."""


Refute = Callable[[Followed, CollisionWorld, bool], Refutation | None]
"""Function that finds where joints are not clear of the world and, with the flag, of the arm
itself."""


class SegmentMemory:
    """Cached results for an arm that starts from one pose.

    Attributes:
        joint_path: the last curve that it was moved along, as bytes of its points, and the joints
            along it; None if there was none.
    """

    def __init__(self) -> None:
        self.joint_path: tuple[bytes, ChainJointPath] | None = None
        # answers, and the number of the collision world for which each holds
        self._known: dict[Key, tuple[Followed, Refutation | None, int]] = {}
        self._worlds: deque[World] = deque(maxlen=_WORLDS)
        self._latest = -1
        self._around: CollisionWorld | None = None
        self._changes: dict[int, Change | None] = {}

    def enter(self, obstacles: Sequence[Obstacle], around: CollisionWorld) -> None:
        """Switch to these obstacles, in the order of their numbers."""
        if around is self._around:
            return
        self._worlds.append(World.of(obstacles, around))
        self._latest, self._around, self._changes = self._latest + 1, around, {}

    def examined(
        self, key: Key, follow: Callable[[], Followed], refute: Refute
    ) -> tuple[Followed, Refutation | None]:
        """Joints along a polyline, and where the arm is not clear on it.

        Args:
            key: the polyline and the joints to begin with, as bytes, and what else the answer
                depends on beside the surroundings.
            follow: finds the joints, if they are not known.
            refute: finds where they are not clear of all or some surroundings, if need be.
        """
        known = self._known.pop(key, None)
        assert self._around is not None
        if known is None:
            followed = follow()
            fault = refute(followed, self._around, True)
        else:
            followed, fault, world = known
            change = self._since(world)
            if change is None or (fault is not None and not _remains(change, fault)):
                fault = refute(followed, self._around, True)
            elif fault is None and change.moved:
                fault = refute(followed, change.around, False)
        if len(self._known) >= _MOST:
            del self._known[next(iter(self._known))]
        self._known[key] = followed, fault, self._latest
        return followed, fault

    def _since(self, world: int) -> Change | None:
        """Changes since an answer; None if unknown, or if more than obstacles changed."""
        if world not in self._changes:
            self._changes[world] = self._change(world)
        return self._changes[world]

    def _change(self, world: int) -> Change | None:
        first = self._latest - len(self._worlds) + 1
        if world < first or self._around is None:
            return None
        return world_change(self._worlds[world - first], self._worlds[-1], self._around)


def _remains(change: Change, fault: Refutation) -> bool:
    """Check if a collision found before is still there: with itself, or what has not moved."""
    return fault.obstacle < 0 or fault.obstacle in change.stays
