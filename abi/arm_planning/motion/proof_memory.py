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

from abi.arm_planning.certificates.arm_certificate import ArmCertificate
from abi.arm_planning.certificates.chain_certificate import certify_chain
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arm_planning.world.world_change import Change, World, world_change
from abi.arrays import BoolArray, FloatArray, read_only
from abi.curves.clearance.certificate import Refutation
from abi.obstacles.obstacle_set import Obstacle
from abi.robot.urdf_arm import UrdfArm

_Number = TypeVar("_Number", bound=np.generic)

_ALL = slice(None)
"""All rows."""


class ProofMemory:
    """Proofs for an arm, of which the last is cached, and that of the arm without obstacles."""

    def __init__(self, arm: UrdfArm) -> None:
        self._arm = arm
        self._last: ArmCertificate | None = None
        self._required, self._world = 0.0, World((), 0.0, ())  # of the last
        self._of_itself: ArmCertificate | Refutation | None = None
        self._of: tuple[FloatArray, World] | None = None  # positions and world of that

    def certify(
        self,
        positions: FloatArray,
        obstacles: Sequence[Obstacle],
        around: CollisionWorld,
        margin: float,
    ) -> ArmCertificate | Refutation:
        """Certify as :func:`certify_chain` does, reusing what remains of the last proof.

        Args:
            positions: joint positions (k, n), k >= 2, [rad] or [unit].
            obstacles: the obstacles, in the order of their numbers.
            around: they and the floor, in the format of the kernels.
            margin: distance to prove from obstacles, at least 0, [unit].
        """
        world, known, change = World.of(obstacles, around), self._last, None
        if known is not None and known.positions is positions and self._required == margin:
            change = world_change(self._world, world, around)
        if known is None or change is None:
            found = self._anew(positions, world, around, margin)
        else:
            found = self._updated(known, change, margin)
        if isinstance(found, ArmCertificate):
            self._last, self._required, self._world = found, margin, world
        return found

    def _anew(
        self, positions: FloatArray, world: World, around: CollisionWorld, margin: float
    ) -> ArmCertificate | Refutation:
        """A proof at joint positions (k, n) of which at most the arm's own part is known."""
        own, of = self._of_itself, self._of
        if (
            own is None
            or of is None
            or of[0] is not positions
            or (of[1].floor, of[1].allowed) != (world.floor, world.allowed)
        ):
            own = certify_chain(self._arm, positions, around.only(around.numbers < 0), 0.0)
            self._of_itself, self._of = own, (positions, world)
        if isinstance(own, Refutation):
            return own
        solids = around.only(around.numbers >= 0)
        new = certify_chain(self._arm, positions, solids, margin, with_itself=False)
        return new if isinstance(new, Refutation) else _both(own, new, new.margin)

    def _updated(
        self, known: ArmCertificate, change: Change, margin: float
    ) -> ArmCertificate | Refutation:
        """Update a proof after a change."""
        assert known.positions is not None
        stays = (known.obstacle < 0) | np.isin(known.obstacle, [*change.stays])
        if not change.moved and stays.all():
            return known
        new = certify_chain(self._arm, known.positions, change.around, margin, with_itself=False)
        if isinstance(new, Refutation):
            return new
        margin = new.margin if change.moved else known.margin if change.stays else math.inf
        return _both(known, new, margin, stays)


def _both(
    known: ArmCertificate,
    new: ArmCertificate,
    margin: float,
    stays: BoolArray | slice = _ALL,
) -> ArmCertificate:
    """What remains of a proof, the rows flagged in ``stays``, followed by a new one."""
    assert known.closer is not None
    assert new.closer is not None
    return ArmCertificate(
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
