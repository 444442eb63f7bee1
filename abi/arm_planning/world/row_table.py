"""Collision worlds whose rows stay as they are, but for those of obstacles that have moved."""

from __future__ import annotations

import numpy as np

from abi.arm_planning.world.collision_world import FLOOR, CollisionWorld
from abi.arm_planning.world.mesh_boxes import boxes_of, write_boxes
from abi.arrays import BoolArray, FloatArray, IntArray, read_only
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.obstacles.primitive_kernels import BOUNDS, WIDTH
from abi.obstacles.primitive_tree_kernels import TREE

_SPARE = 4
"""Fraction of a table that is left free for obstacles that move."""


def own_world(
    rows: FloatArray, numbers: IntArray, asked: BoolArray, floor: float, size: float
) -> CollisionWorld:
    """The world of an arm without obstacles: what else it keeps clear of.

    Args:
        rows: primitives, flat (k ``WIDTH``,).
        numbers: of each of them, last ``FLOOR``, (k + 1,).
        asked: whether a capsule is to keep clear of it, (c, k + 1).
        floor: height of the floor, [unit].
        size: largest coordinate of the arm, [unit].
    """
    count = len(numbers)
    return CollisionWorld(
        ObstacleSet(()),
        rows=rows,
        inside=read_only(np.zeros(2 * (count - 1), dtype=np.int32)),
        numbers=read_only(numbers),
        meshes=read_only(np.full(count, -1, dtype=np.int32)),
        outer=read_only(np.arange(count, dtype=np.int32)),
        in_use=count,
        asked=read_only(asked),
        floor=floor,
        size=size,
    )


class RowTable:
    """Rows of an arm's collision world, which keep their place until their obstacle moves.

    New rows are added behind the others, so that what was handed out never changes. Only when there
    is no more room, or another number of obstacles, are the rows in use copied to a new table.
    """

    def __init__(self) -> None:
        self._begin(0)
        self._solids: tuple[object, ...] = ()
        self._places: dict[int, slice] = {}  # rows of each of these, by identity

    def __call__(self, obstacles: ObstacleSet, own: CollisionWorld) -> CollisionWorld:
        """The world with these obstacles: primitives as they are, meshes as trees of boxes.

        Args:
            obstacles: the obstacles, of which every capsule is asked.
            own: the arm's world without them.
        """
        solids = (*obstacles.primitives, *obstacles.meshes, own)
        numbers = [*obstacles.rows.tolist(), FLOOR]
        known = [self._places.get(id(one)) for one in solids]
        sizes = [
            _size(one) if place is None else place.stop - place.start
            for one, place in zip(solids, known, strict=True)
        ]
        stays = [
            place is not None and (one is own or self._numbers[place.start] == number)
            for one, place, number in zip(solids, known, numbers, strict=True)
        ]
        before = self._rows
        added = sum(size for size, stay in zip(sizes, stays, strict=True) if not stay)
        if len(solids) != len(self._places) or self._used + added >= len(self._numbers):
            stays = [False] * len(solids)
            self._begin(sum(sizes) + 1)
        packed = obstacles.packed.reshape(-1, WIDTH)
        places = []
        for k, (one, place, stay) in enumerate(zip(solids, known, stays, strict=True)):
            if place is None or not stay:
                made = None if place is None else before[place]
                made = packed[k : k + 1] if k < len(packed) else made
                place = self._added(one, numbers[k], sizes[k], made)
            places.append(place)
        self._solids = solids
        self._places = {id(one): place for one, place in zip(solids, places, strict=True)}
        # the floor has no row, but a place behind them
        self._numbers[self._used], self._meshes[self._used] = FLOOR, -1
        self._used += 1
        last = self._used - 1
        outer = [place.start for place in places[:-1]]
        outer += [*range(places[-1].start, places[-1].stop), last]
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
            floor=own.floor,
            size=own.size + float(np.abs(corners).max(initial=0.0)),
        )

    def _begin(self, count: int) -> None:
        """Begin a new table with room for that many rows and some more."""
        size = count + count // _SPARE + 1
        self._used = 0
        self._rows = np.zeros((size, WIDTH))
        self._inside = np.zeros((size, 2), dtype=np.int32)
        self._numbers, self._meshes = np.empty((2, size), dtype=np.int32)

    def _added(
        self, one: Obstacle | CollisionWorld, number: int, size: int, made: FloatArray | None
    ) -> slice:
        """Write so many rows of an obstacle, or copy those made already, (n, ``WIDTH``)."""
        part = slice(self._used, self._used + size)
        self._used = part.stop
        self._numbers[part], self._meshes[part] = number, -1
        if isinstance(one, CollisionWorld):
            self._rows[part] = one.rows.reshape(-1, WIDTH)
            self._numbers[part] = one.numbers[:-1]
        elif made is not None:
            self._rows[part] = made
        if isinstance(one, MeshShape):
            if made is None:
                write_boxes(one, self._rows[part].reshape(-1))
            *_, tree = boxes_of(one.surface)
            self._inside[part] = np.where(tree[:, 1:] > 0, tree + np.int32(part.start), 0)
            self._meshes[part] = number
        return part


def _size(one: Obstacle | CollisionWorld) -> int:
    """Rows of an obstacle, or of the arm's own."""
    if isinstance(one, CollisionWorld):
        return len(one.numbers) - 1
    return len(boxes_of(one.surface)[0]) if isinstance(one, MeshShape) else 1
