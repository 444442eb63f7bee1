"""Obstacles as rows of convex primitives, of which only those that moved are rebuilt."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abi.arm_planning.world.mesh_boxes import boxes_of, write_boxes
from abi.arrays import BoolArray, FloatArray, IntArray, read_only
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.primitive_kernels import WIDTH

FLOOR = -1
"""Number of the floor, beside those of obstacles."""

_SPARE = 4
"""Fraction of a table that is left free for obstacles that move."""


class Own(NamedTuple):
    """Parts other than obstacles that an arm keeps clear of.

    Attributes:
        rows: primitives, flat (k ``WIDTH``,).
        numbers: of each of them, last ``FLOOR``, (k + 1,).
        asked: whether a capsule is to keep clear of it, (c, k + 1).
    """

    rows: FloatArray
    numbers: IntArray
    asked: BoolArray


class SolidRows(NamedTuple):
    """Rows of obstacles and the arm's own parts; some may be out of use.

    Attributes:
        rows: flat (k ``WIDTH``,).
        inside: first and last but one of the boxes inside each, 0 and 0 without, flat (2 k,).
        numbers: obstacle of each, or number of the arm's own, last ``FLOOR``, (k + 1,).
        meshes: the same of the rows of triangle meshes, -1 of others, (k + 1,).
        outer: rows that are in no other: of primitives, of meshes, of the arm's own, the floor.
        in_use: rows in use and the floor.
    """

    rows: FloatArray
    inside: IntArray
    numbers: IntArray
    meshes: IntArray
    outer: IntArray
    in_use: int


class _Block(NamedTuple):
    """Rows of one obstacle, or of the arm's own part."""

    whose: object
    number: int
    first: int
    size: int


class RowTable:
    """Rows of an arm's collision world, which keep their place until their obstacle moves.

    New rows are added behind the others, so that what was handed out never changes. Only when there
    is no more room, or another number of obstacles, are the rows in use copied to a new table.
    """

    def __init__(self) -> None:
        self._begin(0)
        self._blocks: dict[int, _Block] = {}

    def __call__(self, obstacles: ObstacleSet, own: Own) -> SolidRows:
        """Rows of the obstacles: primitives as they are, meshes as trees of boxes."""
        solids = (*obstacles.primitives, *obstacles.meshes, own)
        numbers = [*obstacles.rows.tolist(), FLOOR]
        known = [self._blocks.get(id(one)) for one in solids]
        sizes = [
            _size(one) if block is None else block.size
            for one, block in zip(solids, known, strict=True)
        ]
        stays = [
            block is not None and block.number == number
            for block, number in zip(known, numbers, strict=True)
        ]
        before = self._rows
        added = sum(size for size, stay in zip(sizes, stays, strict=True) if not stay)
        if len(solids) != len(self._blocks) or self._used + added >= len(self._numbers):
            stays = [False] * len(solids)
            self._begin(sum(sizes) + 1)
        packed = obstacles.packed.reshape(-1, WIDTH)
        blocks = []
        for k, (one, block, stay) in enumerate(zip(solids, known, stays, strict=True)):
            if block is None or not stay:
                made = None if block is None else before[block.first : block.first + block.size]
                made = packed[k : k + 1] if k < len(packed) else made
                block = self._added(_Block(one, numbers[k], self._used, sizes[k]), made)
            blocks.append(block)
        self._blocks = {id(block.whose): block for block in blocks}
        # the floor has no row, but a place behind them
        self._numbers[self._used], self._meshes[self._used] = FLOOR, -1
        self._used += 1
        outer = [block.first for block in blocks[:-1]]
        outer += range(blocks[-1].first, blocks[-1].first + blocks[-1].size)
        last = self._used - 1
        return SolidRows(
            read_only(self._rows[:last].reshape(-1)),
            read_only(self._inside[:last].reshape(-1)),
            read_only(self._numbers[: self._used]),
            read_only(self._meshes[: self._used]),
            read_only(np.array([*outer, last], dtype=np.int32)),
            in_use=sum(sizes) + 1,
        )

    def _begin(self, count: int) -> None:
        """Begin a new table with room for that many rows and some more."""
        size = count + count // _SPARE + 1
        self._used = 0
        self._rows = np.zeros((size, WIDTH))
        self._inside = np.zeros((size, 2), dtype=np.int32)
        self._numbers, self._meshes = np.empty((2, size), dtype=np.int32)

    def _added(self, block: _Block, made: FloatArray | None) -> _Block:
        """Write the rows of a block, or copy those that are made already, (n, ``WIDTH``)."""
        part = slice(block.first, block.first + block.size)
        self._used = part.stop
        self._numbers[part], self._meshes[part] = block.number, -1
        if isinstance(block.whose, Own):
            self._rows[part] = block.whose.rows.reshape(-1, WIDTH)
            self._numbers[part] = block.whose.numbers[:-1]
        elif made is not None:
            self._rows[part] = made
        if isinstance(block.whose, MeshShape):
            if made is None:
                write_boxes(block.whose, self._rows[part].reshape(-1))
            tree = boxes_of(block.whose.surface).inside
            self._inside[part] = np.where(tree[:, 1:] > 0, tree + np.int32(block.first), 0)
            self._meshes[part] = block.number
        return block


def _size(one: object) -> int:
    """Rows of an obstacle, or of the arm's own."""
    if isinstance(one, Own):
        return len(one.numbers) - 1
    return len(boxes_of(one.surface).inside) if isinstance(one, MeshShape) else 1
