"""What one obstacle takes away from a mesh: nodes, and edges between the nodes that are left."""

from __future__ import annotations

from dataclasses import dataclass
from operator import is_not
from typing import TYPE_CHECKING

import numpy as np

from abi.arrays import BoolArray, FloatArray, IntArray, read_only
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.packing import pack
from abi.obstacles.primitives import MeshShape, Obstacle
from abi.tet_mesh import exclusion_kernels as kernels

if TYPE_CHECKING:
    from abi.tet_mesh.tet_mesh import TetMesh


@dataclass(frozen=True, eq=False)
class Taken:
    """What one obstacle takes; that of several is the union.

    The edges of excluded nodes are lost, too.

    Attributes:
        starts: (r,) first nodes of runs of excluded nodes.
        lengths: (r,) numbers of nodes in the runs.
        losers: (m,) nodes that lose edges to nodes that are left; of ``delaunay`` places of all
            edges lost in the rows.
        losses: (m,) bits of the edges lost; of ``delaunay`` 0.
    """

    starts: IntArray
    lengths: IntArray
    losers: IntArray
    losses: IntArray


@dataclass(frozen=True, eq=False)
class Left:
    """What obstacles leave of a mesh.

    Attributes:
        excluded: (n,) True where a node is excluded.
        nodes: number of nodes left.
        exits: (n,) open directions of the nodes that are left, as bits.
        weights: lengths of the directions, or of the edges of the rows, inf where shut, [unit].
    """

    excluded: BoolArray
    nodes: int
    exits: IntArray
    weights: FloatArray


@dataclass(frozen=True, eq=False)
class Known:
    """What is worth knowing when the obstacles move on.

    Attributes:
        taken: what each obstacle took, by obstacle and margin.
        still: of these, what the obstacles took that did not move.
        left: what they left.
    """

    taken: dict[tuple[Obstacle, float], Taken]
    still: tuple[Taken, ...]
    left: Left | None


NOTHING_KNOWN = Known({}, (), None)


def leave(mesh: TetMesh, obstacles: ObstacleSet, margin: float, known: Known) -> tuple[Left, Known]:
    """What obstacles leave of a mesh, and what to know of it the next time."""
    used: dict[tuple[Obstacle, float], Taken] = {}
    still, moved = [], []
    for obstacle in obstacles:
        key = (obstacle, margin)
        one = known.taken.get(key)
        if one is None:
            moved.append(used.setdefault(key, take(mesh, obstacle, margin)))
        else:
            still.append(used.setdefault(key, one))
    left = known.left
    if left is None or len(still) != len(known.still) or any(map(is_not, still, known.still)):
        count = len(mesh.points)
        left = Left(read_only(np.zeros(count, np.bool_)), count, mesh.exits, mesh.weights)
        left = _without(mesh, left, still)
    return _without(mesh, left, moved), Known(used, tuple(still), left)


def _without(mesh: TetMesh, left: Left, taken: list[Taken]) -> Left:
    """What is left when more is taken."""
    if not taken:
        return left
    excluded, nodes = left.excluded.copy(), left.nodes
    exits, weights = left.exits, left.weights
    rows = mesh.stencil is None
    if rows:
        weights = weights.copy()
    else:
        exits = exits.copy()
    for one in taken:
        nodes -= kernels.mark(one.starts, one.lengths, excluded)
        if rows:
            weights[one.losers] = np.inf
        else:
            lost = (one.starts, one.lengths, one.losers, one.losses)
            kernels.shut(*mesh.net[:3], *lost, exits)
    return Left(read_only(excluded), nodes, read_only(exits), read_only(weights))


def take(mesh: TetMesh, obstacle: Obstacle, margin: float) -> Taken:
    """The nodes and edges of a mesh that are nearer to an obstacle than ``margin``, [unit].

    An edge is lost if an end of it is excluded, or if it comes too near between its ends.
    """
    if isinstance(obstacle, MeshShape):
        parts = _taken_by_surface(mesh, obstacle, margin)
    else:
        row, reach = pack((obstacle,)), mesh.longest_edge
        parts = kernels.take(*mesh.net, mesh.exits, row, margin, reach)
    return Taken(*(read_only(part) for part in parts))


def _taken_by_surface(
    mesh: TetMesh, surface: MeshShape, margin: float
) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    reach = margin + mesh.longest_edge
    low, high = surface.bounds()
    near = within(mesh.points, low - reach, high + reach)
    near = near[surface.distance_bounds(mesh.points[near])[0] < reach]
    gone = surface.closer(mesh.points[near], margin)
    is_near = np.zeros(len(mesh.points), dtype=np.bool_)
    is_gone = is_near.copy()
    is_near[near], is_gone[near[gone]] = True, True
    left = near[~gone]
    if mesh.stencil is None:
        indptr, indices = mesh.net.indptr, mesh.net.indices
        counts = np.diff(indptr)[left]
        begin = np.cumsum(counts) - counts
        place = np.arange(counts.sum()) + np.repeat(indptr[left] - begin, counts)
        tail, head = np.repeat(left, counts), indices[place]
    else:
        directions = np.arange(len(mesh.stencil.lengths))
        exist = ((mesh.exits[left, None] >> directions) & 1 == 1).ravel()
        place = np.tile(directions, len(left))[exist]
        tail = np.repeat(left, len(directions))[exist]
        head = mesh.stencil.heads(left).ravel()[exist]
    lost = is_gone[head]
    # an edge in the way has both ends near; from the same end both times, for rounding
    open_ = np.flatnonzero(~lost & is_near[head])
    first, second = np.minimum(tail[open_], head[open_]), np.maximum(tail[open_], head[open_])
    alone = ObstacleSet((surface,))
    lost[open_] = alone.blocked(mesh.points[first], mesh.points[second], margin)
    losers, losses = tail[lost], (1 << place[lost]).astype(np.int32)
    if mesh.stencil is None:
        losers, losses = place[lost].astype(np.int32), np.zeros(np.count_nonzero(lost), np.int32)
    starts = near[gone]
    return starts, np.ones_like(starts), losers, losses


def within(points: FloatArray, low: FloatArray, high: FloatArray) -> IntArray:
    """Ids of the points (n, 3) in the closed box ``low``..``high``, [unit], ascending."""
    ids = np.flatnonzero((points[:, 0] >= low[0]) & (points[:, 0] <= high[0]))
    for axis in (1, 2):
        values = points[ids, axis]
        ids = ids[(values >= low[axis]) & (values <= high[axis])]
    return ids.astype(np.int32)
