"""Collision world of an arm: the obstacles, the floor and its own column."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from abi import arguments
from abi.arm_planning.world.collision_world_kernels import Obstacles
from abi.arm_planning.world.mount import mounts
from abi.arm_planning.world.solid_rows import FLOOR, Own, RowTable, SolidRows
from abi.arrays import BoolArray, IntArray, flat, read_only
from abi.obstacles.capsule import Capsule
from abi.obstacles.convex_shape import row
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.primitive_kernels import BOUNDS, WIDTH
from abi.obstacles.primitive_tree_kernels import TREE
from abi.robot.any_arm import AnyArm
from abi.robot.bodies.allowed_contacts import AllowedContact, Reason
from abi.robot.paper_arm.link_capsules import COLUMN
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.robot.urdf_arm import UrdfArm

OWN = -2
"""Number of the arm's first capsule among those of obstacles; -3 is its second, and so on."""


@dataclass(frozen=True, eq=False)
class CollisionWorld:
    """Obstacles, floor and column in the format of the kernels.

    A triangle mesh is a tree of boxes, the smallest of which fit its triangles closely.

    Attributes:
        solids: obstacles and column as rows; of what no capsule is asked, more may be there.
        asked: whether a capsule must keep clear of it, False for boxes inside others, (c, k + 1).
        floor: height of the floor, [unit].
        size: largest coordinate of arm and obstacles, [unit].
        allowed: what of it which link may touch.
        touched: which rows, (k + 1,), no distance is kept from: they are there once more, for the
            capsules that need only not touch them. None where there are no such capsules.
    """

    solids: SolidRows
    asked: BoolArray
    floor: float
    size: float
    allowed: tuple[AllowedContact, ...] = ()
    touched: BoolArray | None = None

    def __post_init__(self) -> None:
        # not copied: one is made for each obstacle of a plan
        arguments.flags("asked", self.asked, (-1, len(self.solids.numbers)))

    @property
    def numbers(self) -> IntArray:
        """Obstacle of each row, ``OWN`` minus a capsule's number, last ``FLOOR``, (k + 1,)."""
        return self.solids.numbers

    def beyond(self, margin: float) -> Obstacles:
        """A copy with an additional distance from obstacles, [unit]; floor and column keep 0."""
        if margin not in self._beyond:
            kept = self.numbers >= 0
            margins = np.where(kept if self.touched is None else kept & ~self.touched, margin, 0.0)
            rows, inside, _, meshes, outer, _ = self.solids
            self._beyond[margin] = Obstacles(
                *(rows, inside, meshes, read_only(margins)),
                *(self.asked.reshape(-1), outer, self.floor, self.size),
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
        outer = self.solids.outer[::-1]  # of rows that are there twice the first ones count
        numbers, rows = self.numbers[outer], np.empty_like(outer)
        rows[numbers[numbers >= 0]] = outer[numbers >= 0]
        return rows

    def only(self, kept: BoolArray) -> CollisionWorld:
        """A copy with only the rows flagged in ``kept``."""
        kept = arguments.flags("kept", kept, self.numbers.shape)
        return replace(self, asked=read_only(self.asked & kept))


def paper_arm_world(
    arm: PaperArm, obstacles: ObstacleSet, lowest: float, table: RowTable | None = None
) -> CollisionWorld:
    """Build the collision world of the paper's arm.

    The floor is level with the base, or with the bottom of the workspace if that is lower. Links
    with a joint at the column may touch it, and the fingers may touch the floor.

    Args:
        arm: the arm.
        obstacles: the solids.
        lowest: height of the workspace's bottom, [unit].
        table: with the rows of obstacles as they were; None to make all anew.
    """
    reach = arm.a1 + arm.a2 + arm.a3 + 2 * arm.a4 + arm.a5
    return _collision_world(arm, reach, _own(arm), obstacles, lowest, table)


def chain_world(
    arm: UrdfArm, obstacles: ObstacleSet, lowest: float, table: RowTable | None = None
) -> CollisionWorld:
    """Build the collision world of a URDF arm, without the arm itself.

    Links that stand still may touch the floor, and so may those that the first joint moves where it
    brings them no nearer to it. Those that stand still may touch what the arm stands on, too, and
    whatever the scene says may touch.
    """
    standing = arm.on_floor(min(float(arm.base[2]), lowest))
    moves = np.array([link not in standing for link in arm.capsule_links])[:, None]
    own = Own(np.zeros(0), np.array([FLOOR], dtype=np.int32), moves)
    found = _collision_world(arm, 2 * arm.reach, own, obstacles, lowest, table)
    allowed = _allowed(arm, obstacles, standing)
    asked, capsules = found.asked.copy(), np.array(arm.capsule_links)
    for link, other, _ in allowed:
        if isinstance(other, int):
            asked[capsules == link, found.first_row(other)] = False
    found = replace(found, asked=read_only(asked), allowed=allowed)
    return _doubled(found, arm.touchable) if arm.touchable.any() else found


def _doubled(world: CollisionWorld, touchable: BoolArray) -> CollisionWorld:
    """Add every obstacle a second time, for capsules that only must not touch it.

    Args:
        world: the surroundings, without parts of the arm.
        touchable: these capsules, (c,).
    """
    solids, count = world.solids, len(world.numbers) - 1
    inside = np.where(solids.inside > 0, solids.inside + np.int32(count), solids.inside)
    outer, last = solids.outer[:-1], np.int32(2 * count)
    twice = SolidRows(
        rows=read_only(np.concatenate([solids.rows, solids.rows])),
        inside=read_only(np.concatenate([solids.inside, inside])),
        numbers=read_only(np.concatenate([solids.numbers[:-1], solids.numbers])),
        meshes=read_only(np.concatenate([solids.meshes[:-1], solids.meshes])),
        outer=read_only(np.concatenate([outer, outer + np.int32(count), [last]]).astype(np.int32)),
        in_use=2 * solids.in_use - 1,
    )
    asked, floor = world.asked[:, :-1], world.asked[:, -1:]
    both = asked & ~touchable[:, None], asked & touchable[:, None], floor
    touched = np.arange(2 * count + 1) >= count
    return replace(
        world,
        solids=twice,
        asked=read_only(np.concatenate(both, axis=1)),
        touched=read_only(touched),
    )


def _allowed(
    arm: UrdfArm, obstacles: ObstacleSet, standing: Iterable[str]
) -> tuple[AllowedContact, ...]:
    """Contacts that a URDF arm's links may have with the world; ``standing``: on the floor."""
    frames = {one.link: one.frame for one in arm.capsules}
    found = [AllowedContact(link, "floor", "mount") for link in standing]
    reasons: dict[tuple[str, int], Reason] = {}
    for number in mounts(arm, obstacles):
        reasons |= {(link, number): "mount" for link, frame in frames.items() if frame < 0}
    for link, other in arm.asked:
        if isinstance(other, int):
            reasons.setdefault((link, other), "asked")
    found += [AllowedContact(link, number, why) for (link, number), why in reasons.items()]
    return tuple(found)


def _collision_world(
    arm: AnyArm,
    reach: float,
    own: Own,
    obstacles: ObstacleSet,
    lowest: float,
    table: RowTable | None,
) -> CollisionWorld:
    """Assemble a collision world.

    Args:
        arm: the arm.
        reach: farthest that it gets from its base, [unit].
        own: what it keeps clear of beside obstacles.
        obstacles: the solids.
        lowest: height of the workspace's bottom, [unit].
        table: with the rows of obstacles as they were; None to make all anew.
    """
    solids = (table or RowTable())(obstacles, own)
    asked = np.zeros((len(own.asked), len(solids.numbers)), dtype=np.bool_)
    asked[:, solids.outer] = True
    asked[:, solids.outer[len(solids.outer) - own.asked.shape[1] :]] = own.asked
    corners = solids.rows.reshape(-1, WIDTH)[solids.outer[:-1], BOUNDS:TREE]
    size = float(np.abs(arm.base).max()) + reach
    return CollisionWorld(
        solids=solids,
        asked=read_only(asked),
        floor=min(float(arm.base[2]), lowest),
        size=size + float(np.abs(corners).max(initial=0.0)),
    )


@lru_cache(maxsize=16)
def _own(arm: PaperArm) -> Own:
    still = [k for k, capsule in enumerate(arm.capsules) if capsule.body == COLUMN]
    x, y, z = arm.base.tolist()
    rows = np.zeros((len(still), WIDTH))
    for place, capsule in zip(rows, (arm.capsules[k] for k in still), strict=True):
        middle = x, y, z + (capsule.low + capsule.high) / 2
        height = capsule.high - capsule.low
        place[:TREE] = row(
            Capsule.model_construct(radius=capsule.radius, height=height, position=middle)
        )
    numbers = np.array([*(OWN - k for k in still), FLOOR], dtype=np.int32)
    moves = np.array([capsule.body != COLUMN for capsule in arm.capsules])[:, None]
    jointed = np.array([capsule.neighbour for capsule in arm.capsules])[:, None]
    grips = np.array([capsule.grips for capsule in arm.capsules])[:, None]
    asked = moves & np.where(numbers == FLOOR, ~grips, ~jointed)
    return Own(flat(rows), read_only(numbers), read_only(asked))
