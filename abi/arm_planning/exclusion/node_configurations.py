"""Configurations of a URDF arm: joint positions with the tool at each node of a mesh."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from abi import arguments
from abi.arm_planning.exclusion.node_configuration_kernels import (
    BoxedTree,
    bound_configurations,
    spread,
)
from abi.arrays import BoolArray, FloatArray, IntArray, flat, read_only
from abi.robot.kinematics.start_poses import REACHED
from abi.robot.urdf_arm import UrdfArm
from abi.tet_mesh.tet_mesh import TetMesh

_LONGEST = 0.7
"""Largest step of a joint between neighbours that are connected, [rad] or [m]."""


@dataclass(frozen=True, eq=False)
class NodeConfigurations:
    """Joint positions at the nodes that an arm reaches, spread from the start.

    Attributes:
        arm: the arm.
        mesh: the mesh.
        start: where the tool starts, shape (3,), [unit], world.
        first: joint positions there, shape (n,), [rad] or [unit].
        home: those that spare joints drift to, shape (n,), [rad] or [unit].
        positions: joint positions at all m nodes, shape (m, n), [rad] or [unit]; those of a node
            that is not reached mean nothing.
        reached: whether the arm reaches each node, shape (m,).
    """

    arm: UrdfArm
    mesh: TetMesh
    start: FloatArray
    first: FloatArray
    home: FloatArray
    positions: FloatArray
    reached: BoolArray

    def __post_init__(self) -> None:
        nodes, joints = len(self.mesh.points), len(self.arm.scales)
        arguments.keep(
            self,
            start=arguments.numbers("start", self.start, (3,)),
            first=arguments.numbers("first", self.first, (joints,)),
            home=arguments.numbers("home", self.home, (joints,)),
            positions=arguments.numbers("positions", self.positions, (nodes, joints)),
            reached=arguments.flags("reached", self.reached, (nodes,)),
        )

    def near(self, point: FloatArray) -> tuple[FloatArray, FloatArray] | None:
        """Node and joints of the configuration nearest to a point (3,), or None."""
        point = arguments.numbers("point", point, (3,))
        if np.array_equal(point, self.start):
            return self.start, self.first
        if not len(self._nodes):
            return None
        node = int(self._nodes[self._tree.query(point)[1]])
        return self.mesh.points[node], self.positions[node]

    @cached_property
    def coordinates(self) -> FloatArray:
        """The positions as the kernels have them, flat (m n,), [rad] or [m]."""
        return flat(self.positions / self.arm.scales)

    @cached_property
    def tree(self) -> BoxedTree:
        """The mesh's nodes in a tree, and boxes: of each capsule about 16 bytes a node."""
        nodes, bodies = self.mesh.node_tree, self.arm.bodies
        boxes = np.tile(np.repeat([np.inf, -np.inf], 3), len(nodes.balls) // 4 * len(bodies.radii))
        bound_configurations(
            self.arm.chain.table, bodies, self.coordinates, nodes, self.reached, boxes
        )
        return nodes, read_only(boxes)

    @cached_property
    def _nodes(self) -> IntArray:
        return np.flatnonzero(self.reached).astype(np.int32)

    @cached_property
    def _tree(self) -> scipy.spatial.cKDTree:
        return scipy.spatial.cKDTree(self.mesh.points[self._nodes])


def spread_over(
    arm: UrdfArm, mesh: TetMesh, start: FloatArray, first: FloatArray, home: FloatArray
) -> NodeConfigurations:
    """Spread an arm's inverse kinematics over a mesh, from a pose at the start.

    Args:
        arm: the arm.
        mesh: the mesh.
        start: where the tool starts, shape (3,), [unit], world.
        first: joint positions there, shape (n,), [rad] or [unit].
        home: those that spare joints drift to, shape (n,), [rad] or [unit].
    """
    start = arguments.numbers("start", start, (3,))
    first = arguments.numbers("first", first, (len(arm.scales),))
    home = arguments.numbers("home", home, (len(arm.scales),))
    indptr, indices = mesh.neighbours
    configurations = np.zeros((len(mesh.points), len(home)))
    reached = np.zeros(len(mesh.points), dtype=np.bool_)
    nearest = int(np.linalg.norm(mesh.points - start, axis=1).argmin())
    configurations[nearest] = first / arm.scales
    queue, tries = np.full(len(reached), nearest, np.int32), np.zeros(len(reached), np.int32)
    nodes = flat(mesh.points * arm.metres), indptr, indices
    task = arm.chain.table, nodes, flat(home / arm.scales), (REACHED, _LONGEST)
    counts = spread(*task, (0, 0), configurations.reshape(-1), reached, queue, tries)
    while counts[0] < counts[1]:  # the result may become unwanted between two calls
        counts = spread(*task, counts, configurations.reshape(-1), reached, queue, tries)
    positions = read_only(configurations * arm.scales)
    return NodeConfigurations(arm, mesh, start, first, home, positions, read_only(reached))
