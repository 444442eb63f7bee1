"""Construction of the graph: start and goal are joined to the free mesh (paper, section III)."""

from __future__ import annotations

import math

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, IntArray, read_only
from abi.errors import StageError, point_blocked
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import Vec3
from abi.search import search_kernels as kernels
from abi.search.graph import Graph
from abi.tet_mesh.adjacency import NO_IDS, NO_NUMBERS
from abi.tet_mesh.adjacency_kernels import LINKED_BIT
from abi.tet_mesh.exclusion import FreeMesh, within
from abi.tet_mesh.tet_mesh import TetMesh

_ROUNDING = 1e-9
"""Distances, [unit], and parts of the pitch below this count as nothing."""

REACH = 1.6
"""Radius, in longest edges, within which start and goal are joined to nodes."""

_NO_PLACES = read_only(np.zeros((0, 3)))


def build_graph(
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
        StageError: start or goal is inside an obstacle or nearer to it than ``clearance``.
    """
    margin = arguments.number("margin", margin)
    clearance = arguments.number("clearance", clearance)
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
    distances = _end_distances(free, obstacles, ends, clearance, margin)
    room = [min(distance - _ROUNDING, margin) for distance in distances]
    open_directions, weights = free.open_directions.copy(), free.weights
    nodes = len(mesh.points)
    ids: list[int] = []
    places: list[Vec3] = []
    links: list[tuple[IntArray, IntArray, FloatArray]] = []
    for end, node, least in zip(ends, at, room, strict=True):
        if node < 0:
            node = nodes + len(places)
            places.append(end)
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
    return _graph(free, read_only(open_directions), places, links, ids)


def _graph(
    free: FreeMesh,
    open_directions: IntArray,
    own: list[Vec3],
    links: list[tuple[IntArray, IntArray, FloatArray]],
    ids: list[int],
) -> Graph:
    """Assemble the graph from the free mesh, open directions, start and goal, and links."""
    tails, heads, lengths = NO_IDS, NO_IDS, NO_NUMBERS
    if links:  # in most frames there are none
        tails, heads, lengths = map(read_only, map(np.concatenate, zip(*links, strict=True)))
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
    )


def _end_distances(
    free: FreeMesh,
    obstacles: ObstacleSet,
    ends: tuple[Vec3, Vec3],
    clearance: float,
    margin: float,
) -> list[float]:
    """Signed distances of start and goal, [unit], or bounds beyond the margin if those suffice.

    Raises:
        StageError: one is less than ``clearance``.
    """
    points, enough = np.array(ends, dtype=float), margin + 2 * _ROUNDING
    distances: list[float] = obstacles.signed_distance(points, enough).tolist()
    for which, end, distance in zip(("start", "goal"), ends, distances, strict=True):
        if distance < clearance - _ROUNDING:
            index = int(obstacles.nearest(np.array([end]))[1][0])
            candidates = free.mesh.points[~free.excluded]
            squares = ((candidates - end) ** 2).sum(axis=1)
            place = candidates[squares.argmin()] if len(candidates) else None
            raise point_blocked(which, index, distance, clearance, place)
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
    """Nodes of the free mesh visible from ``point``, and their distances, [unit].

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
    """Check whether an edge between start and goal exists already."""
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
