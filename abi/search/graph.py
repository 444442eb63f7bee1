"""Stage 2: the graph of the free mesh, with start and goal joined to it (paper, section III).

The paper takes the edges of the mesh as they are; an edge between two free nodes can still cross
a corner or a thin obstacle, so here each edge is tested along its whole length.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from abi.arrays import BoolArray, FloatArray, IntArray, read_only
from abi.errors import PointBlocked, StageError
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import Vec3
from abi.search import graph_kernels as kernels
from abi.tet_mesh import adjacency
from abi.tet_mesh.adjacency import NO_IDS, NO_NUMBERS
from abi.tet_mesh.adjacency_kernels import LINKED_BIT
from abi.tet_mesh.exclusion import FreeMesh, within
from abi.tet_mesh.tet_mesh import TetMesh

if TYPE_CHECKING:
    import networkx

_ROUNDING = 1e-9
"""Distances, [unit], and parts of the pitch below this count as nothing."""

REACH = 1.6
"""Start and goal are joined to the nodes within this many longest edges."""

_DIRECTIONS = (1 << LINKED_BIT) - 1

_NO_PLACES = read_only(np.zeros((0, 3)))


@dataclass(frozen=True, eq=False)
class Graph:
    """Nodes and the edges between them that keep clear of the obstacles.

    Node ids are those of the mesh, excluded nodes included (they have no edges); start and goal
    follow where they are no mesh node. What the searches need is kept as the kernels take it
    (``abi.tet_mesh.adjacency_kernels``); tables of edges are made when they are first asked for.

    Attributes:
        mesh: the mesh.
        excluded: (n,) mesh nodes without edges.
        open_directions: (n,) open directions of each mesh node that is not excluded, as bits.
        weights: lengths of the directions, or of the edges of the rows, inf where shut, [unit].
        tails, heads: (m,) ends of the links, which are the edges of start and goal where these are
            no mesh nodes, and the one between them.
        link_lengths: (m,) [unit].
        own: (k, 3) places of start and goal where they are no mesh nodes, [unit], world.
        start: node id.
        goal: node id.
        free_nodes: number of nodes that are not excluded, start and goal included.
        pitch: pitch of the mesh, [unit].
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
    pitch: float

    @cached_property
    def points(self) -> FloatArray:
        """Places (n, 3) of all nodes, [unit], world."""
        points = self.mesh.points
        return read_only(np.concatenate([points, self.own])) if len(self.own) else points

    @cached_property
    def edges(self) -> IntArray:
        """Node ids of the edges (e, 2), lower id first, each edge once."""
        links = np.stack([self.tails, self.heads], axis=1)
        return read_only(np.concatenate([self.mesh.edges[self._kept], links]))

    @property
    def indptr(self) -> IntArray:
        """Places in ``indices`` at which the neighbours of each node begin (n + 1,)."""
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
        """The mesh edges (k, 2) left out although both ends are free."""
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
        """Number of mesh edges left out, for an excluded end or a crossing."""
        return self.mesh.edge_count - self.edge_count + len(self.tails)

    @property
    def longest_edge(self) -> float:
        """An upper bound of the edges' lengths, [unit]."""
        longest = self.mesh.longest_edge
        return max(longest, float(self.link_lengths.max())) if len(self.tails) else longest

    def places(self, nodes: IntArray) -> FloatArray:
        """Places (m, 3) of nodes (m,), [unit], world."""
        mesh = self.mesh.points
        if not len(self.own):
            return mesh[nodes]
        return np.where(
            (nodes < len(mesh))[:, None],
            mesh[np.minimum(nodes, len(mesh) - 1)],
            self.own[np.clip(nodes - len(mesh), 0, len(self.own) - 1)],
        )

    def to_networkx(self) -> networkx.Graph:
        """The same graph for networkx: node attribute ``pos`` (tuple), edge attribute ``length``.

        Holds start, goal and the nodes that have an edge.
        """
        import networkx

        tail = np.repeat(np.arange(len(self.points)), np.diff(self.indptr))
        once = tail < self.indices
        nodes = np.union1d(tail, [self.start, self.goal])
        graph = networkx.Graph()
        graph.add_nodes_from(
            (node, {"pos": tuple(pos)})
            for node, pos in zip(nodes.tolist(), self.points[nodes].tolist(), strict=True)
        )
        columns = (tail[once], self.indices[once], self.lengths[once])
        graph.add_weighted_edges_from(
            zip(*(column.tolist() for column in columns), strict=True), weight="length"
        )
        return graph

    @property
    def _free_ends(self) -> BoolArray:
        """Which of the mesh's edges have no excluded end (e,)."""
        tail, head = self.mesh.edges.T  # numpy takes ten times as long to reduce rows of two
        return np.asarray(~(self.excluded[tail] | self.excluded[head]))

    @cached_property
    def _kept(self) -> BoolArray:
        """Which of the mesh's edges there are (e,)."""
        mesh = self.mesh
        if mesh.stencil is None:
            indptr, indices = mesh.adjacency.indptr, mesh.adjacency.indices
            tail = np.repeat(np.arange(len(mesh.points)), np.diff(indptr))
            kept = np.isfinite(self.weights[tail < indices])
        else:
            kept = (self.open_directions[mesh.edges[:, 0]] >> mesh.edge_numbers) & 1 == 1
        return read_only(kept & self._free_ends)

    @cached_property
    def _rows(self) -> tuple[IntArray, IntArray, FloatArray]:
        lengths = np.concatenate([self.mesh.lengths[self._kept], self.link_lengths])
        return adjacency.rows(self.edges, lengths, len(self.points))


def build(
    free: FreeMesh,
    obstacles: ObstacleSet,
    margin: float,
    start: Vec3,
    goal: Vec3,
    clearance: float,
) -> Graph:
    """Join start and goal to the free mesh, whose edges stay ``margin`` away from the obstacles.

    Start and goal become nodes of their own unless they are a free mesh node. They may be nearer
    to an obstacle than the margin: the edges from there keep the distance that the point has.

    Args:
        free: the mesh without its excluded nodes, by the same obstacles and margin.
        obstacles: the solids to keep clear of.
        margin: distance that edges keep from the obstacles, [unit], at least ``clearance``.
        start: start, [unit], world, in the workspace.
        goal: goal, [unit], world, in the workspace.
        clearance: distance that start and goal must have, [unit].

    Raises:
        StageError: start and goal are the same point (``start_is_goal``).
        PointBlocked: start or goal is in an obstacle or nearer to it than ``clearance``.
    """
    mesh = free.mesh
    ends = (start, goal)
    gap = math.dist(start, goal)
    if gap <= _ROUNDING * max(1.0, 2 * mesh.pitch):
        raise StageError(
            "graph", "start_is_goal", "Start and goal are the same point.", "Move one of them."
        )
    reach = REACH * mesh.longest_edge
    at = [_node_at(free, end) for end in ends]
    if min(at) >= 0 and gap > reach:
        # free nodes keep the margin, and nothing needs to be joined
        return _graph(free, free.open_directions, [], [], at)
    room = [min(own - _ROUNDING, margin) for own in _room(free, obstacles, ends, clearance, margin)]
    open_directions, weights = free.open_directions.copy(), free.weights
    nodes = len(mesh.points)
    ids: list[int] = []
    own: list[Vec3] = []
    links: list[tuple[IntArray, IntArray, FloatArray]] = []
    for end, node, least in zip(ends, at, room, strict=True):
        if node < 0:
            node = nodes + len(own)
            own.append(end)
            seen, away = _seen_from(end, free, obstacles, least, reach)
            links.append((seen, np.full_like(seen, node), away))
            open_directions[seen] |= np.int32(1 << LINKED_BIT)
        ids.append(node)
    if gap <= reach and not _joined(mesh, open_directions, weights, links, ids):
        p, q = np.array([start]), np.array([goal])
        if not obstacles.blocked(p, q, min(room)).any():
            pair = np.array(sorted(ids), dtype=np.int32)
            links.append((pair[:1], pair[1:], np.array([gap])))
            of_mesh = pair[pair < nodes]
            open_directions[of_mesh] |= np.int32(1 << LINKED_BIT)
    return _graph(free, read_only(open_directions), own, links, ids)


def _graph(
    free: FreeMesh,
    open_directions: IntArray,
    own: list[Vec3],
    links: list[tuple[IntArray, IntArray, FloatArray]],
    ids: list[int],
) -> Graph:
    """The graph of the free mesh, with these open directions, places of start and goal, links."""
    tails, heads, lengths = NO_IDS, NO_IDS, NO_NUMBERS
    if links:
        tails = read_only(np.concatenate([link[0] for link in links]))
        heads = read_only(np.concatenate([link[1] for link in links]))
        lengths = read_only(np.concatenate([link[2] for link in links]))
    return Graph(
        mesh=free.mesh,
        excluded=free.excluded,
        open_directions=open_directions,
        weights=free.weights,
        tails=tails,
        heads=heads,
        link_lengths=lengths,
        own=read_only(np.array(own).reshape(-1, 3)) if own else _NO_PLACES,
        start=ids[0],
        goal=ids[1],
        free_nodes=free.nodes + len(own),
        pitch=free.mesh.pitch,
    )


def _room(
    free: FreeMesh,
    obstacles: ObstacleSet,
    ends: tuple[Vec3, Vec3],
    clearance: float,
    margin: float,
) -> list[float]:
    """Signed distances of start and goal, [unit], or more than the margin; raises PointBlocked."""
    points, enough = np.array(ends, dtype=float), margin + 2 * _ROUNDING
    distances: list[float] = obstacles.signed_distance(points, enough).tolist()
    for which, end, distance in zip(("start", "goal"), ends, distances, strict=True):
        if distance < clearance - _ROUNDING:
            index = int(obstacles.nearest(np.array([end]))[1][0])
            candidates = free.mesh.points[~free.excluded]
            squares = ((candidates - end) ** 2).sum(axis=1)
            place = candidates[squares.argmin()] if len(candidates) else None
            raise PointBlocked(which, index, distance, clearance, place)
    return distances


def _node_at(free: FreeMesh, point: Vec3) -> int:
    """The free mesh node at ``point``, or -1."""
    mesh = free.mesh
    slack = _ROUNDING * mesh.pitch
    if mesh.stencil is None:
        place = np.array(point)
        ids = within(mesh.points, place - slack, place + slack)
        ids = ids[~free.excluded[ids]]
        return int(ids[0]) if len(ids) else -1
    node = mesh.stencil.node_at(point)
    if node < 0 or free.excluded[node]:
        return -1
    x, y, z = mesh.points[node].tolist()
    away = max(abs(x - point[0]), abs(y - point[1]), abs(z - point[2]))
    return node if away <= slack else -1


def _seen_from(
    point: Vec3,
    free: FreeMesh,
    obstacles: ObstacleSet,
    margin: float,
    reach: float,
) -> tuple[IntArray, FloatArray]:
    """Free mesh nodes that ``point`` sees, and their distances, [unit].

    Looks within ``reach``, [unit], and twice and four times as far while it sees none.
    """
    margins = read_only(np.full(len(obstacles.primitives), margin))
    mesh, x, y, z = free.mesh, *map(float, point)
    for radius in (reach, 2 * reach, 4 * reach):
        ids, away = kernels.visible_nodes(
            mesh.adjacency, obstacles.packed, margins, free.excluded, (x, y, z), radius
        )
        if obstacles.meshes:
            nodes = free.mesh.points[ids]
            from_point = np.broadcast_to(np.array(point), nodes.shape)
            clear = ~obstacles.meshes_alone.blocked(from_point, nodes, margin)
            ids, away = ids[clear], away[clear]
        if len(ids):
            break
    return ids, away


def _joined(
    mesh: TetMesh,
    open_directions: IntArray,
    weights: FloatArray,
    links: list[tuple[IntArray, IntArray, FloatArray]],
    ids: list[int],
) -> bool:
    """Whether there is an edge between start and goal already."""
    a, b = ids
    if any(
        ((tails == a) & (heads == b) | (tails == b) & (heads == a)).any()
        for tails, heads, _ in links
    ):
        return True
    if max(ids) >= len(mesh.points):
        return False
    if mesh.stencil is None:
        row = slice(mesh.adjacency.indptr[a], mesh.adjacency.indptr[a + 1])
        return bool((np.isfinite(weights[row]) & (mesh.adjacency.indices[row] == b)).any())
    heads = mesh.stencil.heads(np.array([a], dtype=np.int32))[0]
    is_open = (int(open_directions[a]) >> np.arange(len(heads))) & 1 == 1
    return bool((is_open & (heads == b)).any())
