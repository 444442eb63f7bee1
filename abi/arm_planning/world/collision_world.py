"""Collision world of an arm: the obstacles, the floor and its own column."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from abi import arguments
from abi.arm_planning.world.collision_world_kernels import Obstacles
from abi.arrays import BoolArray, FloatArray, IntArray, read_only
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.robot.bodies.allowed_contacts import AllowedContact

FLOOR = -1
"""Number of the floor, beside those of obstacles."""
OWN = -2
"""Number of the arm's first capsule among those of obstacles; -3 is its second, and so on."""


@dataclass(frozen=True, eq=False)
class CollisionWorld:
    """Obstacles, floor and column in the format of the kernels.

    A triangle mesh is a tree of boxes, the smallest of which fit its triangles closely. Of what no
    capsule is asked, more rows may be there.

    Attributes:
        obstacles: the obstacles.
        rows: obstacles and column as k primitives, flat (k ``WIDTH``,).
        inside: first and last but one of the boxes inside each, 0 and 0 without, flat (2 k,).
        numbers: obstacle of each row, ``OWN`` minus a capsule's number, last ``FLOOR``, (k + 1,).
        meshes: obstacle of each row of a triangle mesh, -1 of others, (k + 1,).
        outer: rows that are in no other: of primitives, of meshes, of the arm's own, the floor.
        in_use: number of rows in use, and the floor.
        asked: whether a capsule must keep clear of it, False for boxes inside others, (c, k + 1).
        floor: height of the floor, [unit].
        size: largest coordinate of arm and obstacles, [unit].
        allowed: what of it which link may touch.
        touched: which rows, (k + 1,), no distance is kept from: they are there once more, for the
            capsules that need only not touch them. None where there are no such capsules.
    """

    obstacles: ObstacleSet
    rows: FloatArray
    inside: IntArray
    numbers: IntArray
    meshes: IntArray
    outer: IntArray
    in_use: int
    asked: BoolArray
    floor: float
    size: float
    allowed: tuple[AllowedContact, ...] = ()
    touched: BoolArray | None = None

    def __post_init__(self) -> None:
        # not copied: one is made for each obstacle of a plan
        arguments.flags("asked", self.asked, (-1, len(self.numbers)))

    @property
    def ground(self) -> tuple[float, tuple[AllowedContact, ...]]:
        """Floor and what may touch: as long as these stay, only obstacles can have changed."""
        return self.floor, self.allowed

    def beyond(self, margin: float) -> Obstacles:
        """A copy with an additional distance from obstacles, [unit]; floor and column keep 0."""
        if margin not in self._beyond:
            kept = self.numbers >= 0
            margins = np.where(kept if self.touched is None else kept & ~self.touched, margin, 0.0)
            self._beyond[margin] = Obstacles(
                *(self.rows, self.inside, self.meshes, read_only(margins)),
                *(self.asked.reshape(-1), self.outer, self.floor, self.size),
            )
        return self._beyond[margin]

    @cached_property
    def _beyond(self) -> dict[float, Obstacles]:
        """Cache of these copies by margin, as a path's search asks for them often."""
        return {}

    def first_row(self, number: int) -> int:
        """Row of an obstacle; of a mesh that of the box around it."""
        return int(self._first_rows[number])

    @cached_property
    def _first_rows(self) -> IntArray:
        """Row of each obstacle, in the order of their numbers; then what is left over."""
        outer = self.outer[::-1]  # of rows that are there twice the first ones count
        numbers, rows = self.numbers[outer], np.empty_like(outer)
        rows[numbers[numbers >= 0]] = outer[numbers >= 0]
        return rows

    def only(self, kept: BoolArray) -> CollisionWorld:
        """A copy with only the rows flagged in ``kept``."""
        kept = arguments.flags("kept", kept, self.numbers.shape)
        return replace(self, asked=read_only(self.asked & kept))

    def changed_since(self, before: Sequence[Obstacle]) -> tuple[frozenset[int], CollisionWorld]:
        """Numbers of the obstacles that stay where they were, and a copy with only the others.

        Args:
            before: the obstacles as they were, in the order of their numbers.
        """
        pairs = enumerate(zip(before, self.obstacles, strict=False))
        stays = frozenset(number for number, (a, b) in pairs if a is b or a == b)
        return stays, self.only((self.numbers >= 0) & ~np.isin(self.numbers, [*stays]))
