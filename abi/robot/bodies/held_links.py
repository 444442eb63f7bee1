"""Links that held joints carry: they stand still, so no proof compares them with what stands too.

What they reach where they are held is told, by their exact shapes.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence

import numpy as np

from abi.arrays import FloatArray
from abi.robot.bodies.floor_contacts import SUNK
from abi.robot.bodies.link_solids import link_solids as solids_of
from abi.robot.bodies.solid_contact import compile_kernels, touch
from abi.robot.kinematics.chain import Carried, Chain
from abi.robot.urdf.link import Link, LinkShape

_MOST = 6
"""Sentences of one kind."""
_TRIANGLES = 20_000
"""Most triangles of a link that is compared with others."""


def held_notes(
    chain: Chain, floor: float, allowed: Collection[Collection[str | int]] = ()
) -> list[str]:
    """Sentences on links that held joints carry, below the floor or in other links that stand.

    Args:
        chain: the chain.
        floor: its height, [m].
        allowed: pairs that the scene lets touch.
    """
    groups = _groups(chain)
    still = [one for one in chain.carried if one.frame < 0 and chain.robot.links[one.link].shapes]
    bounds = {one.link: _bounds(chain.robot.links[one.link], one.pose) for one in still}
    depths = {name: floor - low[2] for name, (low, _) in bounds.items() if len(groups[name]) > 1}
    sunk = [
        f"{name} reaches {depth:.3g} m below the floor, where it is held, which is not compared."
        for name, depth in depths.items()
        if depth > SUNK
    ]
    shaped = {groups[one.link][0] for one in still}
    may_touch = {*chain.robot.may_touch, *map(frozenset, allowed)}
    may_touch |= {frozenset(one.ends) for one in chain.robot.couplings}
    touching = []
    for first, second in itertools.combinations(still, 2):
        links = first.link, second.link
        between = {*groups[links[0]]} ^ {*groups[links[1]]}
        if len(between & shaped) < 2 or frozenset(links) in may_touch:
            continue
        (low, high), (others_low, others_high) = (bounds[name] for name in links)
        if (low > others_high).any() or (others_low > high).any():
            continue
        if _touch(chain, first, second):
            touching.append(
                f"{links[1]} is in {links[0]}, where it is held, which is not compared."
            )
    return [*_some(sunk), *_some(touching)]


def _groups(chain: Chain) -> dict[str, tuple[str, ...]]:
    """First link of what is fixed together with each, then of what carries that, to the root."""
    found: dict[str, tuple[str, ...]] = {chain.robot.root: (chain.robot.root,)}
    for joint in chain.robot.joints:
        above = found[joint.parent]
        found[joint.child] = above if joint.kind == "fixed" else (joint.child, *above)
    return found


def _touch(chain: Chain, first: Carried, second: Carried) -> bool:
    """Check whether the shapes of two links that stand still touch; not of too many triangles."""
    links = [chain.robot.links[one.link] for one in (first, second)]
    if any(sum(len(shape.faces) for shape in link.shapes) > _TRIANGLES for link in links):
        return False
    compile_kernels()
    beside = np.linalg.inv(first.pose) @ second.pose
    pose = beside[:3, :3].copy(), beside[:3, 3].copy()
    return touch(solids_of(links[0], 1.0), solids_of(links[1], 1.0), *pose)


def _bounds(link: Link, pose: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Low and high corner, (3,) each, of the least box around a link, world, [m]."""
    parts = [_extent(shape, pose @ shape.pose) for shape in link.shapes]
    return np.min([low for low, _ in parts], axis=0), np.max([high for _, high in parts], axis=0)


def _extent(shape: LinkShape, pose: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Low and high corner, (3,) each, of the least box around a shape, [m]."""
    turn, origin = pose[:3, :3], pose[:3, 3]
    if shape.kind == "mesh":
        used = np.zeros(len(shape.vertices), dtype=np.bool_)
        used[shape.faces] = True
        points = shape.vertices[used] @ turn.T + origin
        return points.min(axis=0), points.max(axis=0)
    radius, length, _ = shape.size
    reach = np.full(3, radius)
    if shape.kind == "box":
        reach = abs(turn) @ np.array(shape.size) / 2
    elif shape.kind == "cylinder":
        axis = turn[:, 2]
        reach = radius * np.sqrt(np.maximum(1 - axis**2, 0)) + length / 2 * abs(axis)
    return origin - reach, origin + reach


def _some(sentences: Sequence[str]) -> list[str]:
    """The first sentences, and how many more there are."""
    left = len(sentences) - _MOST
    return [*sentences[:_MOST], *([f"So it is with {left} more."] if left > 0 else [])]
