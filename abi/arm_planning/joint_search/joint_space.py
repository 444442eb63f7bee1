"""An arm's joint space: which positions and straight motions in it are proven clear."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from abi import arguments
from abi.arm_planning.joint_search.tree_kernels import ArmInWorld, edges_are_clear
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arrays import FloatArray, ShortRepr, flat, read_only
from abi.robot.urdf_arm import UrdfArm

MOST_TRIES = 20_000
"""Most pairs of bodies that the proof of one edge may try."""


@dataclass(frozen=True, eq=False, repr=False)
class JointSpace(ShortRepr):
    """The joint positions of an arm in its collision world.

    Attributes:
        arm: the arm.
        collision_world: what it keeps clear of.
        margin: distance that it keeps from obstacles, at least 0, [unit].
    """

    arm: UrdfArm
    collision_world: CollisionWorld
    margin: float

    def __post_init__(self) -> None:
        arguments.keep(self, margin=arguments.number("margin", self.margin, 0.0))

    @cached_property
    def weights(self) -> FloatArray:
        """Factors of the joints in distances, (n,): 1 for turns, 1 / reach for slides."""
        slides = np.array(self.arm.chain.slides)
        return read_only(np.where(slides, 1 / self.arm.reach, 1.0))

    @cached_property
    def kernel_arm(self) -> ArmInWorld:
        """Arm and collision world in the format of the kernels."""
        around = self.collision_world.beyond(self.margin)
        return ArmInWorld(self.arm.chain.table, self.arm.bodies, around, MOST_TRIES)

    def distance(self, path: FloatArray) -> float:
        """Length of a path (k, n) of joint positions, [rad], slides over the arm's reach."""
        path = arguments.numbers("path", path, (-1, len(self.weights)))
        return float(np.linalg.norm(np.diff(path, axis=0) * self.weights, axis=1).sum())

    def is_within(self, positions: FloatArray) -> bool:
        """Check whether joint positions (k, n) keep the joints' limits."""
        positions = arguments.numbers("positions", positions, (-1, len(self.weights)))
        low, high = self.arm.limits.T
        return bool(((low <= positions) & (positions <= high)).all())

    def clear(self, path: FloatArray) -> bool:
        """Check whether the arm is proven clear along a joint path (k, n), k >= 2.

        That it is inside no closed mesh is not checked: see :meth:`clear_poses`.
        """
        path = arguments.numbers("path", path, (-1, len(self.weights)))
        return bool(edges_are_clear(self.kernel_arm, flat(path / self.arm.scales)))
