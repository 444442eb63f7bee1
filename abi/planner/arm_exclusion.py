"""Cache of the nodes that an arm excludes from a mesh, obstacle by obstacle, on one branch."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abi.arm.arm_model import Places
from abi.arrays import BoolArray, read_only
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.tet_mesh.exclusion import Exclusion, FreeMesh, apply
from abi.tet_mesh.tet_mesh import TetMesh

_NO_IDS = read_only(np.zeros(0, dtype=np.int32))


class _Asked(NamedTuple):
    """Nodes (n,) of which it is known whether the arm touches an obstacle there, and where it does.

    Of nothing known both are one flag.
    """

    nodes: BoolArray
    touching: BoolArray


_NOTHING = _Asked(*2 * (read_only(np.zeros(1, dtype=np.bool_)),))


class ArmExclusionCache:
    """Excludes from a mesh the nodes at which an arm is out of reach, past a limit or too near.

    It remembers the nodes that each obstacle excludes, and those that the arm alone excludes. A
    node that the tool or another obstacle excludes is examined only once it is free.
    """

    def __init__(self) -> None:
        self._state: tuple[object, ...] = ()
        self._reached: BoolArray = np.zeros(0, dtype=np.bool_)
        self._line_starts: BoolArray = np.zeros(0, dtype=np.bool_)
        self._asked: dict[Obstacle, _Asked] = {}

    def __call__(self, free: FreeMesh, sight: Places, obstacles: ObstacleSet) -> FreeMesh:
        """The mesh without the nodes that the arm excludes, too.

        Args:
            free: the mesh without those that the tool excludes.
            sight: the arm, among these obstacles.
            obstacles: the solids.
        """
        mesh = free.mesh
        state = (mesh, *sight.key)
        if len(state) != len(self._state) or any(
            a is not b and (isinstance(a, TetMesh) or a != b)
            for a, b in zip(state, self._state, strict=True)
        ):
            self._state, self._asked = state, {}
            self._reached = sight.reached(mesh.points)
            self._line_starts = _line_starts(mesh)
        asked: dict[Obstacle, _Asked] = {}
        open_ = self._reached & ~free.excluded
        for number, obstacle in enumerate(obstacles):
            known = self._asked.get(obstacle, _NOTHING)
            new = open_ & ~known.nodes
            if new.any():
                touching = sight.touching(mesh.points, number, new)
                known = _Asked(known.nodes | new, known.touching | touching)
            asked[obstacle] = known
            open_ &= ~known.touching
        self._asked = asked
        return apply(free, [_nodes(~(open_ | free.excluded), self._line_starts)])


def _line_starts(mesh: TetMesh) -> BoolArray:
    """Nodes (n,) that are not in a line along z with the one before."""
    across = mesh.points[:, :2]
    return np.concatenate([[True], (across[1:] != across[:-1]).any(axis=1)])


def _nodes(excluded: BoolArray, line_starts: BoolArray) -> Exclusion:
    """Exclusion of nodes alone, by runs in a line along z."""
    begins, ends = excluded & line_starts, excluded.copy()
    begins[1:] |= excluded[1:] & ~excluded[:-1]
    ends[:-1] &= ~excluded[1:] | line_starts[1:]
    firsts = np.flatnonzero(begins).astype(np.int32)
    lasts = np.flatnonzero(ends).astype(np.int32)
    return Exclusion(read_only(firsts), read_only(lasts - firsts + 1), _NO_IDS, _NO_IDS)
