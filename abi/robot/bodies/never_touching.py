"""Links that never touch by their given shapes, although the bodies that contain them overlap.

Between two links there are one joint or two. In a box of their positions, links are no nearer to
each other than in its middle, less the way of their points: each joint moves one link beside the
other, whose points go no farther than their distance from its axis. Boxes in which that does not
tell are halved.
"""

from __future__ import annotations

import hashlib
import math

import numpy as np

from abi.arrays import FloatArray
from abi.obstacles.primitives import Cylinder
from abi.robot.bodies import body_store, link_poses, link_solids, solid_contact
from abi.robot.bodies.link_poses import relative_poses
from abi.robot.bodies.link_solids import SIDES, LinkSolids
from abi.robot.bodies.link_solids import link_solids as solids_of
from abi.robot.bodies.solid_contact import compile_kernels, touch
from abi.robot.kinematics.chain import Chain

_MOST_JOINTS = 2
_POSES = 48
"""Random poses of which none may touch, before boxes are tried."""
_WORK = 4_000_000
"""Boxes times edges of both links, at most: some seconds."""
_TRIED = 4
"""Boxes of equal size that may be left, of which it is tried whether links touch in the middle."""
_LEAST = 1e-6
"""Least distance that links keep, over the size of both."""


_Between = tuple[list[int], FloatArray, FloatArray]
"""Numbers of the c coordinates between two links, their limits, (c, 2), and the farthest that a
point moves for one unit of each, (c,), [m]."""


def never_touch(chain: Chain, first: str, second: str) -> bool:
    """Prove that the shapes of two links are apart in every pose, if that can be proven.

    What is found is kept from one start to the next.

    Args:
        chain: the joints that move.
        first: name of a link.
        second: name of another.
    """
    one, other = (solids_of(chain.robot.links[name], 1.0) for name in (first, second))
    between = _between(chain, (first, second), (one, other))
    if between is None:
        return False
    coordinates, limits, ways = between
    shapes = (*chain.robot.links[first].shapes, *chain.robot.links[second].shapes)
    code = (__file__, link_poses.__file__, solid_contact.__file__, link_solids.__file__)
    key = f"{body_store.key_of(shapes, code)} {len(chain.robot.links[first].shapes)}"
    low, high = limits.T
    some = np.random.default_rng(1).uniform(low, high, (_POSES, len(low)))
    turned, moved = relative_poses(chain, first, second, _rows(chain, coordinates, some))
    for array in (limits, ways, turned, moved):
        key = hashlib.sha256(key.encode() + np.round(array, 9).tobytes()).hexdigest()
    kept = body_store.find(key)
    if kept is None:
        compile_kernels()
        apart = not any(touch(one, other, *pose) for pose in zip(turned, moved, strict=True))
        apart = apart and _proven(chain, (first, second), (one, other), between)
        kept = [np.array([float(apart)])]
        body_store.keep(key, kept)
    return bool(kept[0][0])


def _between(
    chain: Chain, links: tuple[str, str], solids: tuple[LinkSolids, LinkSolids]
) -> _Between | None:
    """Joints between two links; None of too many, or where a link has no shape."""
    up, down = (chain.behind(chain.frames[link]) for link in links)
    path = [*(k for k in up if k not in down), *(k for k in down[::-1] if k not in up)]
    if not 1 <= len(path) <= _MOST_JOINTS or not all(one.shapes for one in solids):
        return None
    table = chain.table
    coordinates = np.unique(table.source[path]).tolist()
    ways = np.zeros(len(coordinates))
    reaches = _reaches(chain, links, solids, path)
    for k, reach in zip(path, reaches, strict=True):
        way = 1.0 if table.slides[k] else reach
        ways[coordinates.index(int(table.source[k]))] += abs(float(table.factor[k])) * way
    limits = chain.limits[coordinates].copy()
    whole = not table.slides[path].any() and (np.abs(table.factor[path]) == 1).all()
    if whole:  # after a turn all is as before
        limits[:, 1] = np.minimum(limits[:, 1], limits[:, 0] + 2 * math.pi)
    return coordinates, limits, ways


def _reaches(
    chain: Chain, links: tuple[str, str], solids: tuple[LinkSolids, LinkSolids], path: list[int]
) -> list[float]:
    """Farthest that a point of the link that reaches less far gets from each joint's axis, [m].

    A joint in between takes a point around its own axis: its distance from another axis is at most
    that of the middle of its circle and the circle's radius. A slide takes it as far as itself.
    """

    def stroke(k: int) -> float:
        coordinate = int(chain.table.source[k])
        ways = chain.limits[coordinate] - rest[0, coordinate]
        return abs(float(chain.table.factor[k])) * float(np.abs(ways).max())

    rest = np.clip(0.0, *chain.limits.T)[None]
    frames = chain.poses(rest)[0]
    centres = frames[path, :, 3]
    axes = np.stack([frames[k, :, :3] @ chain.joints[k].axis for k in path])
    found = np.full((2, len(path)), np.inf)
    for number, (link, solid) in enumerate(zip(links, solids, strict=True)):
        turns, origins = relative_poses(chain, None, link, rest)
        start, end, radii = solid.edges
        points = np.concatenate([start, end]) @ turns[0].T + origins[0]
        wider = np.tile(radii, 2)
        for k in range(len(path)) if number == 0 else reversed(range(len(path))):
            away = np.linalg.norm(np.cross(points - centres[k], axes[k]), axis=1)
            found[number, k] = float((away + wider).max())
            if chain.table.slides[path[k]]:
                wider = wider + stroke(path[k])
                continue
            points = centres[k] + np.outer((points - centres[k]) @ axes[k], axes[k])
            wider = wider + away
    return [*map(float, found.min(axis=0))]


def _proven(
    chain: Chain,
    links: tuple[str, str],
    solids: tuple[LinkSolids, LinkSolids],
    between: _Between,
) -> bool:
    """Check box by box that two links are apart in all positions of the joints between them."""
    coordinates, limits, of_joints = between
    edges = sum(len(one.edges[0]) for one in solids)
    low, high = limits.T[:, None]
    slack, left = _rounding(solids), _WORK // edges
    while len(low):
        left -= len(low)
        if left < 0:
            return False
        middles, halves = (low + high) / 2, (high - low) / 2
        turned, moved = relative_poses(chain, *links, _rows(chain, coordinates, middles))
        poses = [*zip(turned, moved, strict=True)]
        ways = halves * of_joints
        near = np.array(
            [
                touch(*solids, *pose, within=way + slack)
                for pose, way in zip(poses, ways.sum(axis=1), strict=True)
            ]
        )
        rows = np.flatnonzero(near)
        few = rows[:: len(rows) // _TRIED + 1]
        if any(touch(*solids, *poses[k]) for k in few):
            return False
        low, high, middles, widest = low[near], high[near], middles[near], ways[near].argmax(axis=1)
        rows = np.arange(len(low))
        after, before = low.copy(), high.copy()
        after[rows, widest] = before[rows, widest] = middles[rows, widest]
        low, high = np.concatenate([low, after]), np.concatenate([before, high])
    return True


def _rounding(solids: tuple[LinkSolids, LinkSolids]) -> float:
    """Distance by which edges may be nearer than they are, [m]: those of a rim are within it."""
    corners = np.concatenate([np.stack(one.bounds) for one in solids])
    found = _LEAST * float(np.ptp(corners, axis=0).max())
    radii = [shape.radius for one in solids for shape in one.shapes if isinstance(shape, Cylinder)]
    return found + max(radii, default=0.0) * (1 - math.cos(math.pi / SIDES))


def _rows(chain: Chain, coordinates: list[int], positions: FloatArray) -> FloatArray:
    """Rows (k, n) of all coordinates, with positions (k, c) of those between the links."""
    rows = np.tile(np.clip(0.0, *chain.limits.T), (len(positions), 1))
    rows[:, coordinates] = positions
    return rows
