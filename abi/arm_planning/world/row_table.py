"""Collision worlds whose rows stay as they are, but for those of obstacles that have moved."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abi.arm_planning.world.collision_world import FLOOR, CollisionWorld
from abi.arm_planning.world.mesh_boxes import boxes_of, write_boxes
from abi.arrays import BoolArray, FloatArray, IntArray, read_only
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.primitive_kernels import BOUNDS, WIDTH
from abi.obstacles.primitive_tree_kernels import TREE

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

    def __call__(
        self, obstacles: ObstacleSet, own: Own, floor: float, size: float
    ) -> CollisionWorld:
        """The world with these obstacles: primitives as they are, meshes as trees of boxes.

        Args:
            obstacles: the obstacles, of which every capsule is asked.
            own: what else there is.
            floor: height of the floor, [unit].
            size: largest coordinate of the arm, [unit].
        """
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
        last = self._used - 1
        outer = [block.first for block in blocks[:-1]]
        outer += [*range(blocks[-1].first, blocks[-1].first + blocks[-1].size), last]
        asked = np.zeros((len(own.asked), self._used), dtype=np.bool_)
        asked[:, outer] = True
        asked[:, outer[len(outer) - own.asked.shape[1] :]] = own.asked
        corners = self._rows[outer[:-1], BOUNDS:TREE]
        return CollisionWorld(
            obstacles,
            rows=read_only(self._rows[:last].reshape(-1)),
            inside=read_only(self._inside[:last].reshape(-1)),
            numbers=read_only(self._numbers[: self._used]),
            meshes=read_only(self._meshes[: self._used]),
            outer=read_only(np.array(outer, dtype=np.int32)),
            in_use=sum(sizes) + 1,
            asked=read_only(asked),
            floor=floor,
            size=size + float(np.abs(corners).max(initial=0.0)),
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
