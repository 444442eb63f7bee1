"""Changes of an arm's collision world from one plan to the next."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from abi.arm_planning.world.collision_world import CollisionWorld
from abi.obstacles.obstacle_set import Obstacle
from abi.robot.bodies.allowed_contacts import AllowedContact


class World(NamedTuple):
    """A collision world to compare with."""

    obstacles: Sequence[Obstacle]
    floor: float
    allowed: tuple[AllowedContact, ...]

    @classmethod
    def of(cls, obstacles: Sequence[Obstacle], around: CollisionWorld) -> World:
        """The world with these obstacles, in the order of their numbers."""
        return cls(obstacles, around.floor, around.allowed)


class Change(NamedTuple):
    """Difference between two collision worlds.

    Attributes:
        stays: numbers of the obstacles that are where they were.
        around: the surroundings with nothing but the others.
        moved: whether there are others.
    """

    stays: frozenset[int]
    around: CollisionWorld
    moved: bool


def world_change(then: World, now: World, around: CollisionWorld) -> Change | None:
    """The difference from ``then`` to ``now``; None if more than obstacles has changed.

    Args:
        then, now: the surroundings.
        around: those of now, in the format of the kernels.
    """
    if (then.floor, then.allowed) != (now.floor, now.allowed):
        return None
    pairs = enumerate(zip(then.obstacles, now.obstacles, strict=False))
    stays = frozenset(number for number, (a, b) in pairs if a is b or a == b)
    moved = (around.numbers >= 0) & ~np.isin(around.numbers, [*stays])
    return Change(stays, around.only(moved), bool(moved.any()))
