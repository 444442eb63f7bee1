"""The collision world of each kind of arm."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache

import numpy as np

from abi.arm_planning.world.collision_world import FLOOR, OWN, CollisionWorld
from abi.arm_planning.world.mount import mounts
from abi.arm_planning.world.row_table import RowTable, own_world
from abi.arrays import BoolArray, flat, read_only
from abi.obstacles.capsule import Capsule
from abi.obstacles.convex_shape import row
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.primitive_kernels import WIDTH
from abi.obstacles.primitive_tree_kernels import TREE
from abi.robot.bodies.allowed_contacts import AllowedContact, Reason
from abi.robot.paper_arm.link_capsules import COLUMN
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.robot.urdf_arm import UrdfArm


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
    return (table or RowTable())(obstacles, _own(arm, min(float(arm.base[2]), lowest)))


def chain_world(
    arm: UrdfArm, obstacles: ObstacleSet, lowest: float, table: RowTable | None = None
) -> CollisionWorld:
    """Build the collision world of a URDF arm, without the arm itself.

    Links that stand still may touch the floor, and so may those that the first joint moves where it
    brings them no nearer to it. Those that stand still may touch what the arm stands on, too, and
    whatever the scene says may touch.
    """
    floor = min(float(arm.base[2]), lowest)
    standing = arm.on_floor(floor)
    moves = np.array([link not in standing for link in arm.capsule_links])[:, None]
    size = float(np.abs(arm.base).max()) + 2 * arm.reach
    own = own_world(np.zeros(0), np.array([FLOOR], dtype=np.int32), moves, floor, size)
    found = (table or RowTable())(obstacles, own)
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
    count = len(world.numbers) - 1
    inside = np.where(world.inside > 0, world.inside + np.int32(count), world.inside)
    outer, last = world.outer[:-1], np.int32(2 * count)
    asked, floor = world.asked[:, :-1], world.asked[:, -1:]
    both = asked & ~touchable[:, None], asked & touchable[:, None], floor
    return replace(
        world,
        rows=read_only(np.concatenate([world.rows, world.rows])),
        inside=read_only(np.concatenate([world.inside, inside])),
        numbers=read_only(np.concatenate([world.numbers[:-1], world.numbers])),
        meshes=read_only(np.concatenate([world.meshes[:-1], world.meshes])),
        outer=read_only(np.concatenate([outer, outer + np.int32(count), [last]]).astype(np.int32)),
        in_use=2 * world.in_use - 1,
        asked=read_only(np.concatenate(both, axis=1)),
        touched=read_only(np.arange(2 * count + 1) >= count),
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


@lru_cache(maxsize=16)
def _own(arm: PaperArm, floor: float) -> CollisionWorld:
    """The column and the floor, at a height, [unit]."""
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
    reach = arm.a1 + arm.a2 + arm.a3 + 2 * arm.a4 + arm.a5
    size = float(np.abs(arm.base).max()) + reach
    return own_world(flat(rows), numbers, asked, floor, size)
