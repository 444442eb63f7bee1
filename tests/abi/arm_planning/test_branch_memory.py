"""An arm's exclusion from a mesh, by runs of nodes: the same as node by node."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest

from abi.arm_planning.branch.arm_branch import ArmBranch
from abi.arm_planning.branch.branch_memory import BranchMemory
from abi.arrays import BoolArray, FloatArray, read_only
from abi.obstacles.obstacle_set import ObstacleSet
from abi.scene.lattices import LATTICES, Lattice
from abi.scene.settings import MeshSettings, Workspace
from abi.tet_mesh.exclusion import Exclusion, FreeMesh, apply
from abi.tet_mesh.node_tree import NodeTree
from abi.tet_mesh.tet_mesh import tetrahedralise

_NONE = read_only(np.zeros(0, dtype=np.int32))


class _Reach:
    """An arm that reaches some of the nodes and touches nothing."""

    def __init__(self, flags: BoolArray) -> None:
        self.flags = flags

    @property
    def key(self) -> tuple[object, ...]:
        return (self.flags.tobytes(),)

    def reached(self, points: FloatArray) -> BoolArray:
        assert len(points) == len(self.flags)
        return self.flags

    def touching(
        self, points: FloatArray, number: int, reached: BoolArray, tree: NodeTree | None = None
    ) -> BoolArray:
        raise AssertionError("there is no obstacle")


@pytest.mark.parametrize("lattice", LATTICES)
@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 1.0])
def test_runs_of_excluded_nodes_leave_what_single_nodes_leave(
    lattice: Lattice, share: float
) -> None:
    workspace = Workspace(min=(0.0, 0.0, 0.0), max=(3.0, 4.0, 5.0))
    mesh = tetrahedralise(workspace, MeshSettings(lattice=lattice, pitch=0.8))
    random = np.random.default_rng(int(10 * share))
    count = len(mesh.points)
    by_tool, reached = random.random(count) < 0.2, random.random(count) >= share
    free = apply(FreeMesh.of(mesh), [_singly(by_tool)])
    found = BranchMemory().exclude(free, cast(ArmBranch, _Reach(reached)), ObstacleSet())
    expected = apply(free, [_singly(by_tool | ~reached)])
    np.testing.assert_array_equal(found.excluded, by_tool | ~reached)
    assert found.nodes == expected.nodes == int((~found.excluded).sum())
    kept = ~found.excluded
    np.testing.assert_array_equal(
        found.open_directions[kept], expected.open_directions[kept], strict=True
    )


def _singly(excluded: BoolArray) -> Exclusion:
    """An exclusion of nodes, each a run of its own."""
    ids = np.flatnonzero(excluded).astype(np.int32)
    return Exclusion(read_only(ids), read_only(np.ones_like(ids)), _NONE, _NONE)
