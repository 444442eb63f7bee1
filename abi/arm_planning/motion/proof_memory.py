"""Cache of the last proof that an arm keeps clear on a motion.

While an obstacle is dragged that is not in the way, the motion stays, and with it the directions
that separate the arm from itself, from the floor and from the obstacles that stand where they
stood. So only those from what has moved are sought anew. Those that separate it from itself and
from the floor are the same whatever distance from the obstacles is to be proven.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from abi.arm_planning.certificates.chain_certificate import certify_chain
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arrays import BoolArray, FloatArray, read_only
from abi.curves.clearance.certificate import Certificate, Refutation
from abi.obstacles.obstacle_set import Obstacle
from abi.robot.urdf_arm import UrdfArm

_Number = TypeVar("_Number", bound=np.generic)

_ALL = slice(None)
"""All rows."""


class ProofMemory:
    """Proofs for an arm, of which the last is cached, and that of the arm without obstacles."""

    def __init__(self, arm: UrdfArm) -> None:
        self._arm = arm
        self._last: Certificate | None = None
        self._asked: tuple[object, ...] = ()  # margin and ground of the last
        self._obstacles: Sequence[Obstacle] = ()  # of the last
        self._of_itself: Certificate | Refutation | None = None
        self._of: tuple[FloatArray, object] | None = None  # joints and ground of that

    def certify(
        self, positions: FloatArray, around: CollisionWorld, margin: float
    ) -> Certificate | Refutation:
        """Certify as :func:`certify_chain` does, reusing what remains of the last proof.

        Args:
            positions: joint positions (k, n), k >= 2, [rad] or [unit].
            around: obstacles and floor.
            margin: distance to prove from obstacles, at least 0, [unit].
        """
        asked, known = (margin, around.ground), self._last
        if known is not None and known.positions is positions and asked == self._asked:
            found = self._updated(known, around, margin)
        else:
            found = self._anew(positions, around, margin)
        if isinstance(found, Certificate):
            self._last, self._asked = found, asked
            self._obstacles = around.obstacles.obstacles
        return found

    def _anew(
        self, positions: FloatArray, around: CollisionWorld, margin: float
    ) -> Certificate | Refutation:
        """A proof at joint positions (k, n) of which at most the arm's own part is known."""
        own, of = self._of_itself, self._of
        if own is None or of is None or of[0] is not positions or of[1] != around.ground:
            own = certify_chain(self._arm, positions, around.only(around.numbers < 0), 0.0)
            self._of_itself, self._of = own, (positions, around.ground)
        if isinstance(own, Refutation):
            return own
        solids = around.only(around.numbers >= 0)
        new = certify_chain(self._arm, positions, solids, margin, with_itself=False)
        return new if isinstance(new, Refutation) else _both(own, new, new.margin)

    def _updated(
        self, known: Certificate, around: CollisionWorld, margin: float
    ) -> Certificate | Refutation:
        """Update the last proof after obstacles may have moved."""
        assert known.positions is not None
        numbers, moved = around.changed_since(self._obstacles)
        stays = (known.obstacle < 0) | np.isin(known.obstacle, [*numbers])
        has_moved = len(numbers) < len(around.obstacles)
        if not has_moved and stays.all():
            return known
        new = certify_chain(self._arm, known.positions, moved, margin, with_itself=False)
        if isinstance(new, Refutation):
            return new
        margin = new.margin if has_moved else known.margin if numbers else math.inf
        return _both(known, new, margin, stays)


def _both(
    known: Certificate,
    new: Certificate,
    margin: float,
    stays: BoolArray | slice = _ALL,
) -> Certificate:
    """What remains of a proof, the rows flagged in ``stays``, followed by a new one."""
    assert known.closer is not None
    assert new.closer is not None
    return Certificate(
        margin=margin,
        pieces=_joined(known.pieces[stays], new.pieces),
        poses=_joined(known.poses[stays], new.poses),
        capsule=_joined(known.capsule[stays], new.capsule),
        obstacle=_joined(known.obstacle[stays], new.obstacle),
        directions=_joined(known.directions[stays], new.directions),
        positions=known.positions,
        closer=_joined(known.closer[stays], new.closer),
    )


def _joined(before: NDArray[_Number], new: NDArray[_Number]) -> NDArray[_Number]:
    """Rows that remain, followed by new ones."""
    return read_only(np.concatenate([before, new]))
