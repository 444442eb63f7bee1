"""Stage 2: the graph of the free mesh, with start and goal joined to it (paper, section III).

The paper takes the edges of the mesh as they are; an edge between two free nodes can still cross
a corner or a thin obstacle, so here each edge is tested along its whole length.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_array

from abi.arrays import BoolArray, FloatArray, IntArray, read_only
from abi.errors import PointBlocked, StageError
from abi.mesh import FreeMesh, within
from abi.shapes import Obstacles, Vec3, nearest, segments_blocked

if TYPE_CHECKING:
    import networkx

_ROUNDING = 1e-9
"""Distances, [unit], and parts of the pitch below this count as nothing."""

_REACH = 1.6
"""Start and goal are joined to the nodes within this many longest edges."""


@dataclass(frozen=True, eq=False)
class Graph:
    """Nodes and the edges between them that keep clear of the obstacles.

    Node ids are those of the mesh, excluded nodes included (they have no edges); start and goal
    follow where they are no mesh node. The neighbours of node i are
    ``indices[indptr[i]:indptr[i + 1]]``, with the ``lengths`` at the same places.

    Attributes:
        points: (n, 3) [unit], world.
        edges: (e, 2) node ids, lower id first, each edge once.
        indptr: (n + 1,) where each node's neighbours begin.
        indices: (2e,) neighbours.
        lengths: (2e,) lengths of the edges to them, [unit].
        start: node id.
        goal: node id.
        free_nodes: number of nodes that are not excluded, start and goal included.
        removed_edges: number of mesh edges left out, for an excluded end or a crossing.
        crossing: (k, 2) mesh edges left out although both ends are free.
        pitch: pitch of the mesh, [unit].
    """

    points: FloatArray
    edges: IntArray
    indptr: IntArray
    indices: IntArray
    lengths: FloatArray
    start: int
    goal: int
    free_nodes: int
    removed_edges: int
    crossing: IntArray
    pitch: float

    @property
    def edge_count(self) -> int:
        """Number of edges, each counted once."""
        return len(self.edges)

    @cached_property
    def longest_edge(self) -> float:
        """Length of the longest edge, [unit]; 0 without edges."""
        return float(self.lengths.max(initial=0.0))

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


def build(
    free: FreeMesh,
    obstacles: Obstacles,
    margin: float,
    start: Vec3,
    goal: Vec3,
    clearance: float,
) -> Graph:
    """Keep the mesh edges that stay ``margin`` away from the obstacles; join start and goal.

    Start and goal become nodes of their own unless they are a free mesh node. They may be nearer
    to an obstacle than the margin: the edges from there keep the distance that the point has.

    Args:
        free: the mesh without its excluded nodes.
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
    ends = np.array([start, goal])
    gap = float(np.linalg.norm(ends[1] - ends[0]))
    if gap <= _ROUNDING * max(1.0, 2 * mesh.pitch):
        raise StageError(
            "graph", "start_is_goal", "Start and goal are the same point.", "Move one of them."
        )
    own_margin = np.minimum(_room(free, obstacles, ends, clearance) - _ROUNDING, margin)
    keep, crossing = _clear_edges(free, obstacles, margin)

    reach = _REACH * float(mesh.lengths.max())
    points, edges, lengths = mesh.points, [mesh.edges[keep]], [mesh.lengths[keep]]
    ids = [_node_at(free, end) for end in ends]
    for k in (0, 1):
        if ids[k] < 0:
            ids[k] = len(points)
            seen, distance = _seen_from(ends[k], free, obstacles, own_margin[k], reach)
            edges.append(_edges_to(seen, ids[k]))
            lengths.append(distance)
            points = np.concatenate([points, ends[k : k + 1]])
    if gap <= reach and not any((part == sorted(ids)).all(axis=1).any() for part in edges):
        hidden = segments_blocked(obstacles, ends[:1], ends[1:], float(own_margin.min()))
        edges.append(np.array([sorted(ids)], dtype=np.int32)[~hidden])
        lengths.append(np.array([gap])[~hidden])

    all_edges, all_lengths = np.concatenate(edges), np.concatenate(lengths)
    indptr, indices, both_ways = _rows(all_edges, all_lengths, len(points))
    return Graph(
        points=read_only(points),
        edges=read_only(all_edges),
        indptr=read_only(indptr),
        indices=read_only(indices),
        lengths=read_only(both_ways),
        start=ids[0],
        goal=ids[1],
        free_nodes=free.nodes + len(points) - len(mesh.points),
        removed_edges=len(mesh.edges) - len(edges[0]),
        crossing=read_only(crossing),
        pitch=mesh.pitch,
    )


def _room(free: FreeMesh, obstacles: Obstacles, ends: FloatArray, clearance: float) -> FloatArray:
    """Signed distances (2,) of start and goal, [unit]; raises PointBlocked."""
    distances, obstacle = nearest(obstacles, ends)
    for which, end, distance, index in zip(
        ("start", "goal"), ends, distances.tolist(), obstacle.tolist(), strict=True
    ):
        if distance < clearance - _ROUNDING:
            candidates = free.mesh.points[~free.excluded]
            squares = ((candidates - end) ** 2).sum(axis=1)
            place = candidates[squares.argmin()] if len(candidates) else None
            raise PointBlocked(which, index, distance, clearance, place)
    return distances


def _clear_edges(free: FreeMesh, obstacles: Obstacles, margin: float) -> tuple[BoolArray, IntArray]:
    """Which mesh edges stay clear (e,), and the edges (k, 2) that cross between free nodes."""
    mesh = free.mesh
    tail, head = mesh.edges.T
    keep = ~(free.excluded[tail] | free.excluded[head])
    # an edge that comes nearer than the margin has both ends in the obstacle's widened bounds
    near = np.zeros(len(mesh.points), dtype=np.bool_)
    widened = margin + float(mesh.lengths.max())
    for obstacle in obstacles:
        low, high = obstacle.bounds()
        near[within(mesh.points, low - widened, high + widened)] = True
    open_ = np.flatnonzero(keep & near[tail] & near[head])
    p, q = mesh.points[tail[open_]], mesh.points[head[open_]]
    blocked = open_[segments_blocked(obstacles, p, q, margin)]
    keep[blocked] = False
    return keep, mesh.edges[blocked]


def _node_at(free: FreeMesh, point: FloatArray) -> int:
    """The free mesh node at ``point``, or -1."""
    slack = _ROUNDING * free.mesh.pitch
    ids = within(free.mesh.points, point - slack, point + slack)
    ids = ids[~free.excluded[ids]]
    return int(ids[0]) if len(ids) else -1


def _seen_from(
    point: FloatArray, free: FreeMesh, obstacles: Obstacles, margin: float, reach: float
) -> tuple[IntArray, FloatArray]:
    """Free mesh nodes that ``point`` sees, and their distances, [unit].

    Looks within ``reach``, [unit], and twice and four times as far while it sees none.
    """
    for radius in (reach, 2 * reach, 4 * reach):
        ids = within(free.mesh.points, point - radius, point + radius)
        ids = ids[~free.excluded[ids]]
        distance = np.linalg.norm(free.mesh.points[ids] - point, axis=1)
        ids, distance = ids[distance <= radius], distance[distance <= radius]
        nodes = free.mesh.points[ids]
        hidden = segments_blocked(obstacles, np.broadcast_to(point, nodes.shape), nodes, margin)
        if not hidden.all():
            break
    return ids[~hidden], distance[~hidden]


def _edges_to(nodes: IntArray, node: int) -> IntArray:
    return np.stack([nodes, np.full_like(nodes, node)], axis=1)


def _rows(
    edges: IntArray, lengths: FloatArray, nodes: int
) -> tuple[IntArray, IntArray, FloatArray]:
    """Compressed rows of the undirected graph: indptr (n + 1,), indices (2e,), lengths (2e,)."""
    tail = np.concatenate([edges[:, 1], edges[:, 0]])
    head = np.concatenate([edges[:, 0], edges[:, 1]])
    entries = coo_array((np.concatenate([lengths, lengths]), (tail, head)), shape=(nodes, nodes))
    entries.has_canonical_format = True  # no edge occurs twice: spares a search for duplicates
    rows = entries.tocsr()
    indptr, indices = (part.astype(np.int32, copy=False) for part in (rows.indptr, rows.indices))
    return indptr, indices, rows.data
