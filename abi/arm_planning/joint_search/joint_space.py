"""An arm's joint space: which positions and straight motions in it are proven clear."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from abi import arguments
from abi.arm_planning.joint_search.tree_kernels import edges_are_clear
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arm_planning.world.collision_world_kernels import Obstacles
from abi.arrays import FloatArray, ShortRepr, flat, read_only
from abi.robot.bodies.capsule_table import Bodies
from abi.robot.kinematics.chain_kernels import ChainTable
from abi.robot.urdf_arm import UrdfArm


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

    @property
    def kernel_arguments(self) -> tuple[ChainTable, Bodies, Obstacles]:
        """The arm's joints, its bodies, and what these keep clear of."""
        around = self.collision_world.beyond(self.margin)
        return self.arm.chain.table, self.arm.bodies, around

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

        That it is inside no closed mesh is not checked: see :func:`inside_meshes
        <abi.arm_planning.world.chain_distances.inside_meshes>`.
        """
        path = arguments.numbers("path", path, (-1, len(self.weights)))
        return bool(edges_are_clear(*self.kernel_arguments, flat(path / self.arm.scales)))
