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
        # obstacles of the latest worlds, which are alike but for these
        self._obstacles: deque[Sequence[Obstacle]] = deque(maxlen=_WORLDS)
        self._latest = -1
        self._around: CollisionWorld | None = None
        self._changes: dict[int, tuple[frozenset[int], CollisionWorld]] = {}

    def enter(self, around: CollisionWorld) -> None:
        """Switch to this collision world."""
        if around is self._around:
            return
        if self._around is not None and around.ground != self._around.ground:
            self._obstacles.clear()
        self._obstacles.append(around.obstacles.obstacles)
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
            if self._latest - world >= len(self._obstacles):
                fault = refute(followed, self._around, True)
            else:
                stays, moved = self._since(world, self._around)
                if fault is not None and fault.obstacle >= 0 and fault.obstacle not in stays:
                    fault = refute(followed, self._around, True)
                elif fault is None and len(stays) < len(self._around.obstacles):
                    fault = refute(followed, moved, False)
        if len(self._known) >= _MOST:
            del self._known[next(iter(self._known))]
        self._known[key] = followed, fault, self._latest
        return followed, fault

    def _since(self, world: int, around: CollisionWorld) -> tuple[frozenset[int], CollisionWorld]:
        """What stays where it was in one of the latest worlds, and the world of the others."""
        if world not in self._changes:
            before = self._obstacles[world - self._latest - 1]
            self._changes[world] = around.changed_since(before)
        return self._changes[world]
