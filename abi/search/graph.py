"""Stage 2: the graph of the free mesh, with start and goal joined to it (paper, section III).

The paper keeps all edges between free nodes. Such an edge can still cross a corner or a thin
obstacle, so here each edge is tested along its whole length.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import scipy

from abi import arguments, progress
from abi.arrays import BoolArray, FloatArray, IntArray, ShortRepr, read_only
from abi.errors import AbiError
from abi.tet_mesh import adjacency
from abi.tet_mesh.adjacency_kernels import LINKED_BIT
from abi.tet_mesh.tet_mesh import TetMesh

if TYPE_CHECKING:
    import networkx

_DIRECTIONS = (1 << LINKED_BIT) - 1


@dataclass(frozen=True, eq=False, repr=False)
class Graph(ShortRepr):
    """Nodes and the edges between them that keep clear of the obstacles.

    Node ids are those of the mesh, including excluded nodes, which have no edges; start and goal
    follow if they are no mesh nodes. What the searches need is stored in the format of the kernels
    (``abi.tet_mesh.adjacency_kernels``); tables of edges are made at their first use.

    Attributes:
        mesh: the mesh.
        excluded: (n,) mesh nodes without edges.
        open_directions: (n,) open directions of each mesh node that is not excluded, as bits.
        weights: lengths of the directions, or of the edges of the rows, inf where shut, [unit].
        tails, heads: (m,) ends of the links, which are the edges of start and goal if these are no
            mesh nodes, and the edge between them.
        link_lengths: (m,) [unit].
        own: (k, 3) positions of start and goal if they are no mesh nodes, [unit], world.
        start: node id.
        goal: node id.
        free_nodes: number of nodes that are not excluded, start and goal included.
    """

    mesh: TetMesh
    excluded: BoolArray
    open_directions: IntArray
    weights: FloatArray
    tails: IntArray
    heads: IntArray
    link_lengths: FloatArray
    own: FloatArray
    start: int
    goal: int
    free_nodes: int

    def __post_init__(self) -> None:
        nodes, weights = len(self.mesh.points), self.mesh.weights.shape
        own = arguments.points("own", self.own)
        every = nodes + len(own)
        tails = arguments.ids("tails", self.tails, (-1,), every)
        arguments.keep(
            self,
            excluded=arguments.flags("excluded", self.excluded, (nodes,)),
            open_directions=arguments.bits("open_directions", self.open_directions, (nodes,)),
            weights=arguments.numbers("weights", self.weights, weights, infinite=True),
            tails=tails,
            heads=arguments.ids("heads", self.heads, tails.shape, every),
            link_lengths=arguments.numbers("link_lengths", self.link_lengths, tails.shape),
            own=own,
            start=arguments.integer("start", self.start, 0, every - 1),
            goal=arguments.integer("goal", self.goal, 0, every - 1),
        )

    @cached_property
    def points(self) -> FloatArray:
        """Positions (n, 3) of all nodes, [unit], world."""
        points = self.mesh.points
        return read_only(np.concatenate([points, self.own])) if len(self.own) else points

    @cached_property
    def edges(self) -> IntArray:
        """Node ids of the edges (e, 2), lower id first, each edge once."""
        links = np.stack([self.tails, self.heads], axis=1)
        return read_only(np.concatenate([self.mesh.edges[self._kept], links]))

    def edges_among(self, nodes: BoolArray) -> IntArray:
        """Those of the edges (m, 2) that join two of the flagged ``nodes`` (n,).

        No table of all edges is made, which in a large mesh would be most of a plan's memory.
        """
        nodes = arguments.flags("nodes", nodes, (len(self.points),))
        tail, head = self.mesh.edges.T  # numpy takes ten times as long to reduce rows of two
        kept = self._kept
        progress.check()
        among = kept & nodes[tail] & nodes[head]
        linked = nodes[self.tails] & nodes[self.heads]
        links = np.stack([self.tails[linked], self.heads[linked]], axis=1)
        return np.concatenate([self.mesh.edges[among], links])

    @property
    def indptr(self) -> IntArray:
        """Positions in ``indices`` at which the neighbours of each node begin (n + 1,)."""
        return self._rows[0]

    @property
    def indices(self) -> IntArray:
        """The neighbours (2e,): of node i ``indices[indptr[i]:indptr[i + 1]]``."""
        return self._rows[1]

    @property
    def lengths(self) -> FloatArray:
        """Lengths (2e,) of the edges to the neighbours, [unit]."""
        return self._rows[2]

    @cached_property
    def crossing(self) -> IntArray:
        """Mesh edges (k, 2) that are left out although both ends are free."""
        return read_only(self.mesh.edges[~self._kept & self._free_ends])

    @cached_property
    def edge_count(self) -> int:
        """Number of edges, each counted once."""
        if self.mesh.stencil is None:
            return int(np.count_nonzero(self._kept)) + len(self.tails)
        bits = np.bitwise_count(self.open_directions & _DIRECTIONS)
        return int(bits.sum(dtype=np.int64, where=~self.excluded)) // 2 + len(self.tails)

    @property
    def removed_edges(self) -> int:
        """Number of mesh edges left out because an end is excluded or an obstacle is too near."""
        return self.mesh.edge_count - self.edge_count + len(self.tails)

    @property
    def longest_edge(self) -> float:
        """An upper bound of the edges' lengths, [unit]."""
        longest = self.mesh.longest_edge
        return max(longest, float(self.link_lengths.max())) if len(self.tails) else longest

    def places(self, nodes: IntArray) -> FloatArray:
        """Positions (m, 3) of nodes (m,), [unit], world."""
        mesh = self.mesh.points
        nodes = arguments.ids("nodes", nodes, (-1,), len(mesh) + len(self.own))
        if not len(self.own):
            return mesh[nodes]
        return np.where(
            (nodes < len(mesh))[:, None],
            mesh[np.minimum(nodes, len(mesh) - 1)],
            self.own[np.clip(nodes - len(mesh), 0, len(self.own) - 1)],
        )

    def to_networkx(self) -> networkx.Graph:
        """Convert to networkx: node attribute ``pos`` (tuple), edge attribute ``length``.

        It contains start, goal and the nodes that have an edge.

        Raises:
            AbiError: networkx is not installed.
        """
        try:
            import networkx
        except ImportError:
            raise AbiError(
                "A graph for networkx needs networkx, which is not installed.",
                "pip install networkx brings it.",
            ) from None
        rows = self.lengths, self.indices, self.indptr
        matrix = scipy.sparse.csr_array(rows, (len(self.points),) * 2)
        graph = networkx.from_scipy_sparse_array(matrix, edge_attribute="length")
        graph.remove_nodes_from({*networkx.isolates(graph)} - {self.start, self.goal})
        places = map(tuple, self.points[list(graph)].tolist())
        networkx.set_node_attributes(graph, dict(zip(graph, places, strict=True)), "pos")
        return graph

    @property
    def _free_ends(self) -> BoolArray:
        """Flags of the mesh's edges that have no excluded end (e,)."""
        tail, head = self.mesh.edges.T  # numpy takes ten times as long to reduce rows of two
        return np.asarray(~(self.excluded[tail] | self.excluded[head]))

    @cached_property
    def _kept(self) -> BoolArray:
        """Flags of the mesh's edges that the graph has (e,)."""
        mesh = self.mesh
        if mesh.stencil is None:
            indptr, indices = mesh.adjacency.indptr, mesh.adjacency.indices
            tail = np.repeat(np.arange(len(mesh.points)), np.diff(indptr))
            kept = np.isfinite(self.weights[tail < indices])
        else:
            kept = (self.open_directions[mesh.edges[:, 0]] >> mesh.edge_numbers) & 1 == 1
        progress.check()
        return read_only(kept & self._free_ends)

    @cached_property
    def _rows(self) -> tuple[IntArray, IntArray, FloatArray]:
        lengths = np.concatenate([self.mesh.lengths[self._kept], self.link_lengths])
        return adjacency.rows(self.edges, lengths, len(self.points))
