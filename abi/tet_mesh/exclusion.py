"""Stage 1, exclusion: the nodes and edges of the mesh that the obstacles exclude.

Removing nodes alone is not enough: an edge between two free nodes can still cross an obstacle. So
each edge is tested along its whole length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from abi import arguments
from abi.arrays import BoolArray, FloatArray, IntArray, ShortRepr, read_only
from abi.errors import ArgumentError
from abi.obstacles.convex_shape import row
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.tet_mesh import exclusion_kernels as kernels
from abi.tet_mesh.lattice import REGULAR
from abi.tet_mesh.mesh_exclusion_kernels import exclusion_near_mesh
from abi.tet_mesh.tet_mesh import TetMesh


@dataclass(frozen=True, eq=False, repr=False)
class Exclusion(ShortRepr):
    """Nodes and edges that one obstacle excludes; several obstacles exclude the union.

    The edges of excluded nodes are excluded, too.

    Attributes:
        starts: (r,) first nodes of runs of excluded nodes, ascending.
        lengths: (r,) numbers of nodes in the runs.
        cut_nodes: (m,) nodes that lose edges to free nodes; for ``delaunay`` positions in the rows
            of all edges lost.
        cut_bits: (m,) bits of the edges lost; 0 for ``delaunay``.
    """

    starts: IntArray
    lengths: IntArray
    cut_nodes: IntArray
    cut_bits: IntArray

    def __post_init__(self) -> None:
        starts, lengths, nodes = (
            arguments.ids(name, getattr(self, name), (-1,), arguments.LARGEST_ID)
            for name in ("starts", "lengths", "cut_nodes")
        )
        arguments.ids("lengths", lengths, starts.shape, arguments.LARGEST_ID)
        bits = arguments.bits("cut_bits", self.cut_bits, nodes.shape)
        arguments.keep(self, starts=starts, lengths=lengths, cut_nodes=nodes, cut_bits=bits)

    @cached_property
    def end(self) -> int:
        """One more than the largest node that it names."""
        runs = self.starts.astype(np.int64) + self.lengths
        return max(int(runs.max(initial=0)), int(self.cut_nodes.max(initial=-1)) + 1)


@dataclass(frozen=True, eq=False, repr=False)
class FreeMesh(ShortRepr):
    """A mesh without the nodes that are in an obstacle or nearer to it than the margin.

    Attributes:
        mesh: the whole mesh.
        excluded: (n,) True where a node is excluded.
        nodes: number of nodes kept.
        open_directions: (n,) those of the nodes that are not excluded, as bits; of rows 0.
        weights: lengths of the directions, or of the edges of the rows, inf where shut, [unit].
    """

    mesh: TetMesh
    excluded: BoolArray
    nodes: int
    open_directions: IntArray
    weights: FloatArray

    def __post_init__(self) -> None:
        count, shape = len(self.mesh.points), self.mesh.weights.shape
        arguments.keep(
            self,
            excluded=arguments.flags("excluded", self.excluded, (count,)),
            open_directions=arguments.bits("open_directions", self.open_directions, (count,)),
            weights=arguments.numbers("weights", self.weights, shape, infinite=True),
        )

    @classmethod
    def of(cls, mesh: TetMesh) -> FreeMesh:
        """The mesh with nothing excluded."""
        count = len(mesh.points)
        return cls(
            mesh, read_only(np.zeros(count, np.bool_)), count, mesh.open_directions, mesh.weights
        )

    @cached_property
    def tetrahedra_kept(self) -> int:
        """Number of tetrahedra without an excluded corner."""
        free = ~self.excluded
        if self.mesh.irregular is not None:
            return int(np.count_nonzero(free[self.mesh.irregular].all(axis=1)))
        families = REGULAR[self.mesh.lattice].tetrahedra(free, self.mesh.cells)
        return sum(int(np.count_nonzero(a & b & c & d)) for a, b, c, d in families)


def exclude(mesh: TetMesh, obstacles: ObstacleSet, margin: float) -> FreeMesh:
    """Exclude the nodes and edges that are nearer to an obstacle than ``margin``, [unit]."""
    return apply(FreeMesh.of(mesh), [exclusion(mesh, one, margin) for one in obstacles])


def apply(free: FreeMesh, exclusions: Sequence[Exclusion]) -> FreeMesh:
    """Exclude further nodes and edges from a free mesh."""
    if not exclusions:
        return free
    mesh, nodes = free.mesh, free.nodes
    excluded, open_directions, weights = free.excluded.copy(), free.open_directions, free.weights
    rows = mesh.stencil is None
    if rows:
        weights = weights.copy()
    else:
        open_directions = open_directions.copy()
    for one in exclusions:
        if one.end > (count := len(weights) if rows else len(excluded)):
            raise ArgumentError("exclusions", one.end - 1, f"nodes of the {count:,} there are")
        nodes -= kernels.mark(one.starts, one.lengths, excluded)
        if rows:
            weights[one.cut_nodes] = np.inf
        else:
            kernels.cut(
                mesh.adjacency,
                one.starts,
                one.lengths,
                one.cut_nodes,
                one.cut_bits,
                open_directions,
            )
    return FreeMesh(
        mesh, read_only(excluded), nodes, read_only(open_directions), read_only(weights)
    )


def exclusion(mesh: TetMesh, obstacle: Obstacle, margin: float) -> Exclusion:
    """The nodes and edges of a mesh that are nearer to an obstacle than ``margin``, [unit].

    An edge is lost if an end of it is excluded, or if it comes too near between its ends.
    """
    margin = arguments.number("margin", margin)
    if isinstance(obstacle, MeshShape):
        parts = exclusion_near_mesh(
            mesh.adjacency, mesh.open_directions, *obstacle.placed, margin, mesh.longest_edge
        )
    else:
        parts = kernels.exclusion(
            mesh.adjacency, mesh.open_directions, row(obstacle), margin, mesh.longest_edge
        )
    return Exclusion(*(read_only(part) for part in parts))


def within(points: FloatArray, low: FloatArray, high: FloatArray) -> IntArray:
    """Ids of the points (n, 3) in the closed box ``low``..``high``, [unit], ascending."""
    points = arguments.points("points", points)
    low, high = arguments.numbers("low", low, (3,)), arguments.numbers("high", high, (3,))
    ids = np.flatnonzero((points[:, 0] >= low[0]) & (points[:, 0] <= high[0]))
    for axis in (1, 2):
        values = points[ids, axis]
        ids = ids[(values >= low[axis]) & (values <= high[axis])]
    return ids.astype(np.int32)
