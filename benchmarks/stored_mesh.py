"""A mesh with its edges stored, as graph libraries have it, and which are open among obstacles.

An exact and compiled test of every node and edge, as ours is. It leaves an edge alone as soon as
both its ends lie on one side of the obstacle's bounds, and keeps what obstacles that stand still
leave open.
"""

from __future__ import annotations

from operator import is_not
from typing import TypeAlias

import numba
import numpy as np
from numba.extending import register_jitable

from abi.arrays import BoolArray, ByteArray, FloatArray, IntArray
from abi.compilation.helpers import declare_helpers
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, Obstacles
from abi.obstacles.packing import pack
from abi.obstacles.primitive_kernels import (
    Axes,
    Core,
    axes_of,
    core_of,
    in_body,
    segment_within,
    signed_distance,
)
from abi.obstacles.vector_kernels import sub
from abi.tet_mesh import adjacency
from abi.tet_mesh.tet_mesh import TetMesh

declare_helpers()

Rows: TypeAlias = tuple[IntArray, IntArray, FloatArray]
"""indptr (n + 1,), heads and lengths of compressed rows."""

Columns: TypeAlias = tuple[FloatArray, FloatArray, FloatArray]
"""x, y and z of points (n,) each, which compiled loops read faster than rows."""

_EXCLUDED = 64


class StoredMesh:
    """Edges of a mesh in both directions as compressed rows."""

    def __init__(self, mesh: TetMesh) -> None:
        self.points = mesh.points
        x, y, z = (np.ascontiguousarray(column) for column in mesh.points.T)
        self._columns = x, y, z
        self.rows: Rows = adjacency.rows(mesh.edges, mesh.lengths, len(mesh.points))
        self.tails = np.repeat(np.arange(len(mesh.points)), np.diff(self.rows[0]))
        self._sides = np.empty(len(mesh.points), np.uint8)
        self._still_rows = self.rows
        self._still_shut = np.zeros(len(self.tails), np.bool_)
        self._buffer = _copy(self.rows)
        self._last: Obstacles = ()
        self._still: Obstacles = ()

    def open_rows(self, obstacles: Obstacles, margin: float) -> Rows:
        """Rows of the open edges, which last until the next call.

        Obstacles of the last call stand still.
        """
        moving = self._moving(obstacles, margin)
        rows = self._still_rows
        for obstacle in moving:
            rows = self._open(rows, obstacle, margin, self._buffer)
        return rows

    def shut_edges(self, obstacles: Obstacles, margin: float) -> BoolArray:
        """Flags of the shut edges of all rows (2e,). Obstacles of the last call stand still."""
        moving = self._moving(obstacles, margin)
        shut = self._still_shut.copy()
        for obstacle in moving:
            self._mark(obstacle, margin, shut)
        return shut

    def _moving(self, obstacles: Obstacles, margin: float) -> Obstacles:
        """Obstacles that were not in the last call, once those that were are applied."""
        last = set(map(id, self._last))
        still = tuple(obstacle for obstacle in obstacles if id(obstacle) in last)
        if len(still) != len(self._still) or any(map(is_not, still, self._still)):
            self._still_rows = self.rows
            self._still_shut = np.zeros(len(self.tails), np.bool_)
            buffer = _copy(self.rows)
            for obstacle in still:
                self._still_rows = self._open(self._still_rows, obstacle, margin, buffer)
                self._mark(obstacle, margin, self._still_shut)
            self._still = still
        self._last = obstacles
        return tuple(obstacle for obstacle in obstacles if id(obstacle) not in last)

    def _open(self, rows: Rows, obstacle: Obstacle, margin: float, buffer: Rows) -> Rows:
        """Rows without the edges that an obstacle shuts, in the buffer."""
        count = _open(rows, self._columns, _row(obstacle), margin, self._sides, buffer)
        return buffer[0], buffer[1][:count], buffer[2][:count]

    def _mark(self, obstacle: Obstacle, margin: float, shut: BoolArray) -> None:
        """Mark the edges (2e,) that an obstacle shuts."""
        indptr, heads, _ = self.rows
        _mark(indptr, heads, self._columns, _row(obstacle), margin, self._sides, shut)


def _copy(rows: Rows) -> Rows:
    indptr, heads, lengths = rows
    return indptr.copy(), heads.copy(), lengths.copy()


def _row(obstacle: Obstacle) -> FloatArray:
    assert not isinstance(obstacle, MeshShape)
    return pack((obstacle,))


@register_jitable
def _find_sides(
    axes: Axes, core: Core, row: FloatArray, margin: float, columns: Columns, sides: ByteArray
) -> None:
    """Set each node's bits for the sides of the bounds beyond which it lies, or ``_EXCLUDED``."""
    for node in range(len(sides)):
        x, y, z = columns[0][node], columns[1][node], columns[2][node]
        side = (
            (1 if x <= row[17] - margin else 0)
            | (2 if x >= row[20] + margin else 0)
            | (4 if y <= row[18] - margin else 0)
            | (8 if y >= row[21] + margin else 0)
            | (16 if z <= row[19] - margin else 0)
            | (32 if z >= row[22] + margin else 0)
        )
        if side == 0:
            p = in_body(axes, (x - row[0], y - row[1], z - row[2]))
            side = _EXCLUDED if signed_distance(core, p) < margin else 0
        sides[node] = side


@register_jitable
def _is_shut(
    axes: Axes,
    core: Core,
    row: FloatArray,
    margin: float,
    columns: Columns,
    sides: ByteArray,
    tail: int,
    head: int,
) -> bool:
    """Check whether an end is excluded or the edge comes nearer to the obstacle than the margin."""
    side, other = sides[tail], sides[head]
    if side == _EXCLUDED or other == _EXCLUDED:
        return True
    if side & other:
        return False
    # from the same end in both directions, for the same rounding
    i, j = min(tail, head), max(tail, head)
    a = columns[0][i], columns[1][i], columns[2][i]
    b = columns[0][j], columns[1][j], columns[2][j]
    p = in_body(axes, sub(a, (row[0], row[1], row[2])))
    return segment_within(core, margin, p, in_body(axes, sub(b, a)))


@numba.njit(cache=True, error_model="numpy")
def _open(
    rows: Rows,
    columns: Columns,
    row: FloatArray,
    margin: float,
    sides: ByteArray,
    buffer: Rows,
) -> int:
    """Write the rows without shut edges into the buffer, which may be ``rows``; their count."""
    axes, core = axes_of(row, 0), core_of(row, 0)
    _find_sides(axes, core, row, margin, columns, sides)
    indptr, heads, lengths = rows
    new_indptr, new_heads, new_lengths = buffer
    count, k = 0, indptr[0]
    for tail in range(len(sides)):
        end = indptr[tail + 1]
        new_indptr[tail] = count
        while k < end:
            head = heads[k]
            new_heads[count] = head
            new_lengths[count] = lengths[k]
            k += 1
            count += not _is_shut(axes, core, row, margin, columns, sides, tail, head)
    new_indptr[len(sides)] = count
    return count


@numba.njit(cache=True, error_model="numpy")
def _mark(
    indptr: IntArray,
    heads: IntArray,
    columns: Columns,
    row: FloatArray,
    margin: float,
    sides: ByteArray,
    shut: BoolArray,
) -> None:
    """Mark the edges of rows that an obstacle shuts (2e,)."""
    axes, core = axes_of(row, 0), core_of(row, 0)
    _find_sides(axes, core, row, margin, columns, sides)
    for tail in range(len(sides)):
        for k in range(indptr[tail], indptr[tail + 1]):
            shut[k] |= _is_shut(axes, core, row, margin, columns, sides, tail, heads[k])
