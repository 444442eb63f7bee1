"""Links that held joints carry: no proof compares them with what they never move beside.

That is what else stands still, as they do, or moves with them. What they reach where they are held
is told, by their exact shapes.
"""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Collection, Mapping, Sequence
from functools import lru_cache

import numpy as np

from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import Obstacle
from abi.robot.bodies import body_store, link_poses, link_solids, solid_contact
from abi.robot.bodies.floor_contacts import SUNK
from abi.robot.bodies.link_poses import placed_beside
from abi.robot.bodies.link_solids import LinkSolids
from abi.robot.bodies.link_solids import link_solids as solids_of
from abi.robot.bodies.solid_contact import compile_kernels, depth, touch
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.link import Link, LinkShape

_MOST = 6
"""Sentences of one kind."""
_SHALLOW = 2e-4
"""Depth from which on links are told to touch, [m]: fingers that are shut just meet."""
_POSITIONS = 8
"""Random positions of joints between two links at which it is tried whether they always touch."""


@lru_cache(maxsize=16)
def held_notes(
    chain: Chain, floor: float, allowed: frozenset[tuple[str, str | int]] = frozenset()
) -> tuple[str, ...]:
    """Sentences on links that held joints carry, below the floor or touching others.

    Not told are links that touch wherever the joints between them are, and pairs of the SRDF.

    Args:
        chain: the chain.
        floor: its height, [m].
        allowed: pairs that the scene lets touch.
    """
    groups, links, frames = _groups(chain), chain.robot.links, chain.frames
    attached = chain.robot.attached
    shaped = [name for name in frames if links[name].shapes]
    bounds = {name: _bounds(links[name], chain.places[name]) for name in shaped}
    sunken = {
        name: floor - low[2]
        for name, (low, _) in bounds.items()
        if frames[name] < 0 and len(groups[name]) > 1
    }
    sunk = [
        f"{name} reaches {deep:.3g} m below the floor, where it is held, which is not compared."
        for name, deep in sunken.items()
        if deep > SUNK
    ]
    may_touch = {*chain.robot.may_touch, *map(frozenset, allowed)}
    may_touch |= {frozenset(one.ends) for one in chain.robot.couplings}
    pairs = list[tuple[str, str]]()
    for first, second in itertools.combinations(shaped, 2):
        moved = {*groups[first]} ^ {*groups[second]}
        is_let = not moved or frozenset((first, second)) in may_touch
        if frames[first] != frames[second] or is_let:
            continue
        if attached in (first, second):
            other = first if second == attached else second
            if groups[other][1:] == groups[attached]:
                continue  # as fingers, which what holds the object carries by one joint
        (low, high), (others_low, others_high) = bounds[first], bounds[second]
        if not (low > others_high).any() and not (others_low > high).any():
            pairs.append((first, second))
    touching = []
    for pair in itertools.compress(pairs, _touch_as_held(chain, pairs)):
        deeper, other = sorted(pair, key=lambda name: -len(groups[name]))
        touching.append(f"{deeper} touches {other}, where it is held, which is not compared.")
    return (*_some(sunk), *_some(touching))


def mount_notes(
    chain: Chain,
    under: Mapping[int, Obstacle],
    metres: float,
    allowed: Collection[Collection[str | int]] = (),
) -> list[str]:
    """Sentences on links that held joints put into what the robot stands on.

    They are tried a little above where they are, so that what stands on it is apart.

    Args:
        chain: the chain.
        under: what is beneath the base, by its number from 0, [unit].
        metres: one [unit] in metres.
        allowed: pairs that the scene lets touch.
    """
    groups, found = _groups(chain), []
    up = chain.places[chain.robot.root][:3, 2]
    for number, obstacle in under.items():
        solid = LinkSolids((obstacle,))
        others_low, others_high = (metres * end for end in solid.bounds)
        for name, frame in chain.frames.items():
            link, pose = chain.robot.links[name], chain.places[name]
            stands = frame >= 0 or len(groups[name]) == 1 or not link.shapes
            if stands or (name, number) in allowed:
                continue
            low, high = _bounds(link, pose)
            if (low > others_high).any() or (others_low > high).any():
                continue
            compile_kernels()
            raised = (pose[:3, 3] + SUNK * up) / metres
            if touch(solid, solids_of(link, 1 / metres), pose[:3, :3].copy(), raised):
                found.append(
                    f"{name} is in obstacle {number + 1}, on which the robot stands, where it "
                    "is held, which is not compared."
                )
    return _some(found)


def _groups(chain: Chain) -> dict[str, tuple[str, ...]]:
    """First link of what is fixed together with each, then of what carries that, to the root."""
    found: dict[str, tuple[str, ...]] = {chain.robot.root: (chain.robot.root,)}
    for joint in chain.robot.joints:
        above = found[joint.parent]
        found[joint.child] = above if joint.kind == "fixed" else (joint.child, *above)
    return found


def _touch_as_held(chain: Chain, pairs: Sequence[tuple[str, str]]) -> list[bool]:
    """Which links touch where they are held, and not wherever the joints between are.

    What is found is kept from one start to the next, of all pairs in one.
    """
    if not pairs:
        return []
    robot, groups = chain.robot, _groups(chain)
    above = {joint.child: joint for joint in robot.joints if joint.kind != "fixed"}
    free = tuple(joint.name for joint in above.values() if joint.follows is None)
    anywhere = Chain.moved_by(robot, free)
    low, high = anywhere.usual_range().T
    # at random, as what is alike on four sides touches at each quarter of a turn
    poses = anywhere.poses(np.random.default_rng(0).uniform(low, high, (_POSITIONS, len(low))))
    code = (__file__, link_poses.__file__, link_solids.__file__, solid_contact.__file__)
    links = dict.fromkeys(itertools.chain(*pairs))
    shapes = {name: body_store.key_of(robot.links[name].shapes, code) for name in links}
    digest, tables = hashlib.sha256(), list[FloatArray]()
    for first, second in pairs:
        table = (np.linalg.inv(chain.places[first]) @ chain.places[second])[None, :3]
        between = {*groups[first]} ^ {*groups[second]}
        if not {above[child].coordinate for child in between} & {*chain.names}:
            turned, moved = placed_beside(anywhere, first, second, poses)
            table = np.concatenate([table, np.concatenate([turned, moved[..., None]], axis=2)])
        tables.append(np.round(table, 9))
        digest.update(f"{shapes[first]} {shapes[second]} {table.shape}".encode())
        digest.update(tables[-1].tobytes())
    kept = body_store.find(digest.hexdigest())
    if kept is None:
        compile_kernels()
        both = [(robot.links[first], robot.links[second]) for first, second in pairs]
        found = [_touch_at_first(*two, table) for two, table in zip(both, tables, strict=True)]
        kept = [np.array(found, dtype=float)]
        body_store.keep(digest.hexdigest(), kept)
    return [bool(one) for one in kept[0].tolist()]


def _touch_at_first(one: Link, other: Link, poses: FloatArray) -> bool:
    """Check whether links touch in the first of some poses (k, 3, 4), and not in all others."""
    solids = solids_of(one, 1.0), solids_of(other, 1.0)
    first, *others = ((pose[:, :3].copy(), pose[:, 3].copy()) for pose in poses)
    if not touch(*solids, *first) or depth(*solids, *first) < _SHALLOW:
        return False
    return not others or not all(touch(*solids, *pose) for pose in others)


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
