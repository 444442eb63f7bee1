"""Memory of one branch of an arm: the nodes that it excludes from a mesh, obstacle by obstacle."""

from __future__ import annotations

import numpy as np

from abi.arm_planning.branch.arm_branch import ArmBranch
from abi.arrays import BoolArray, ByteArray, IntArray, read_only
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.tet_mesh.exclusion import Exclusion, FreeMesh, apply
from abi.tet_mesh.tet_mesh import TetMesh

_NO_IDS = read_only(np.zeros(0, dtype=np.int32))

_MANY = 50_000
"""Number of nodes from which they are tested together near a triangle mesh, which is quicker."""

_NOT_ASKED = read_only(np.zeros(1, dtype=np.uint8))
_TOUCHES = 2
"""What is known of an obstacle at a node: 0 where nobody asked, 1 where it is not touched, or 2."""


class BranchMemory:
    """What is kept of an arm's branch from one plan to the next.

    It remembers the nodes that each obstacle excludes, and those that the arm alone excludes. A
    node that the tool or another obstacle excludes is examined only once it is free.

    Attributes:
        slack: number of the multiple of the slack with which the last curve was found.
    """

    def __init__(self) -> None:
        self.slack = 0
        self._state: tuple[object, ...] = ()
        self._reached: BoolArray = np.zeros(0, dtype=np.bool_)
        self._line_starts: BoolArray = np.zeros(0, dtype=np.bool_)
        # by identity, as to hash thousands takes long: what is known at each node, (n,)
        self._known: dict[int, ByteArray] = {}
        self._obstacles: dict[int, Obstacle] = {}
        self._touched: IntArray = np.zeros(
            0, dtype=np.int32
        )  # how many obstacles each node touches
        self._complete = self._reached  # whether all are asked about it

    def exclude(self, free: FreeMesh, branch: ArmBranch, obstacles: ObstacleSet) -> FreeMesh:
        """The mesh without the nodes at which the arm is out of reach, past a limit or too near.

        Args:
            free: the mesh without those that the tool excludes.
            branch: the arm, among these obstacles.
            obstacles: the solids.
        """
        mesh = free.mesh
        state = (mesh, *branch.key)
        if len(state) != len(self._state) or any(
            a is not b and (isinstance(a, TetMesh) or a != b)
            for a, b in zip(state, self._state, strict=True)
        ):
            self._state, self._known, self._obstacles = state, {}, {}
            self._touched = np.zeros(len(mesh.points), dtype=np.int32)
            self._complete = np.ones(len(mesh.points), dtype=np.bool_)
            self._reached = branch.reached(mesh.points)
            self._line_starts = _line_starts(mesh)
        self._forget_others(obstacles)
        numbered = dict(enumerate(obstacles))
        moved = {number: one for number, one in numbered.items() if id(one) not in self._known}
        reached = self._reached & ~free.excluded
        self._ask(mesh, branch, moved, reached & (self._touched == 0))
        for one in moved.values():
            self._complete &= self._known[id(one)] > 0
        left = reached & (self._touched == 0) & ~self._complete
        if left.any():
            self._complete |= self._ask(mesh, branch, numbered, left)
        open_ = reached & (self._touched == 0)
        return apply(free, [_nodes(~(open_ | free.excluded), self._line_starts)])

    def _forget_others(self, obstacles: ObstacleSet) -> None:
        """Forget obstacles that are gone; what is known of an equal one is kept."""
        asked = {id(one) for one in obstacles}
        gone = {key: one for key, one in self._obstacles.items() if key not in asked}
        equal = {one: key for key, one in gone.items()}
        for obstacle in obstacles if gone else ():
            if id(obstacle) not in self._known and obstacle in equal:
                self._known[id(obstacle)] = self._known.pop(equal.pop(obstacle))
                self._obstacles[id(obstacle)] = obstacle
        for key in gone:
            del self._obstacles[key]
            if key in self._known:
                self._touched -= self._known.pop(key) == _TOUCHES

    def _ask(
        self, mesh: TetMesh, branch: ArmBranch, obstacles: dict[int, Obstacle], left: BoolArray
    ) -> BoolArray:
        """Test what is not known of nodes ``left`` (n,); flags of those without a contact, (n,)."""
        for number, obstacle in obstacles.items():
            known = self._known.get(id(obstacle), _NOT_ASKED)
            new = left & (known == 0)
            if new.any():
                at_once = isinstance(obstacle, MeshShape) and len(mesh.points) > _MANY
                tree = mesh.node_tree if at_once else None
                touching = branch.touching(mesh.points, number, new, tree)
                known = known + new + touching
                if touching.any():
                    self._touched += touching
                    left = left & ~touching
            self._known[id(obstacle)], self._obstacles[id(obstacle)] = known, obstacle
        return left


def _line_starts(mesh: TetMesh) -> BoolArray:
    """Flags (n,) of nodes that are not in a line along z with the one before."""
    across = mesh.points[:, :2]
    return np.concatenate([[True], (across[1:] != across[:-1]).any(axis=1)])


def _nodes(excluded: BoolArray, line_starts: BoolArray) -> Exclusion:
    """Exclusion of nodes only, in runs along z."""
    begins, ends = excluded & line_starts, excluded.copy()
    begins[1:] |= excluded[1:] & ~excluded[:-1]
    ends[:-1] &= ~excluded[1:] | line_starts[1:]
    firsts = np.flatnonzero(begins).astype(np.int32)
    lasts = np.flatnonzero(ends).astype(np.int32)
    return Exclusion(read_only(firsts), read_only(lasts - firsts + 1), _NO_IDS, _NO_IDS)
