"""Links into which others slide, as in a telescope: cut beside these, so that their way is open.

Convex pieces of a tube close it. So a link into which another one slides is cut at planes beside
that one, which contain the direction of the slide: no piece reaches across them, wherever the other
link is on its way. As all cuts contain one direction, a line along it that passes through the solid
leaves every part through triangles, so that the parts' hulls hold what is inside, too. What is left
between the planes, such as the bottom of a tube, is before or behind the way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import scipy

from abi.arrays import FloatArray, IntArray, read_only
from abi.robot.bodies.bounding_capsules import principal_axes
from abi.robot.bodies.link_bodies import Body, OpenWay, bodies_beside, link_bodies, triangles_of
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.robot import Robot

_SIDES = 16
"""Planes beside a link that slides, a power of two."""
_PARALLEL = 1e-6
"""Largest difference of directions that count as one."""
_HALVINGS, _WIDEST = 10, 0.1
"""Halvings of the distance from a link that slides, and its largest, over the size of that link."""


def open_bodies(chain: Chain) -> dict[str, tuple[Body, ...]]:
    """Bodies of the links into which others slide, by their names."""
    return _open_bodies(chain.robot, chain.names, tuple(chain.held.items()))


@lru_cache(maxsize=32)
def _open_bodies(
    robot: Robot, names: tuple[str, ...], held: tuple[tuple[str, float], ...]
) -> dict[str, tuple[Body, ...]]:
    followers = {one.name for one in robot.joints if one.follows is not None}
    still = {name: at for name, at in held if name not in followers}
    chain, found = Chain.moved_by(robot, names, held=still), dict[str, tuple[Body, ...]]()
    if np.count_nonzero(chain.table.slides) < 2:
        return found
    for outer in chain.frames:
        link, (direction, pieces) = robot.links[outer], _sliding_beside(chain, outer)
        if not link.shapes or not pieces:
            continue
        way = _way_into(triangles_of(link), direction, pieces)
        if way is not None:
            found[outer] = bodies_beside(link, way)
    return found


def _sliding_beside(chain: Chain, outer: str) -> tuple[FloatArray, list[FloatArray]]:
    """Pieces of links that two slides or more, all in one direction, move beside another.

    Returns:
        That direction (3,), and the corners (2, k, 3) of each piece at both ends of its slide, [m],
        in the frame of the other; of pieces that slide in several directions, those of the first.
    """
    table, direction, found = chain.table, np.zeros(3), list[FloatArray]()
    frames = chain.poses(np.zeros((1, len(chain.names))))[0]
    (turn, origin), behind = _placed(chain, frames, outer), {*chain.behind(chain.frames[outer])}
    for inner, frame in chain.frames.items():
        between = sorted(behind ^ {*chain.behind(frame)})
        slides = len(between) >= 2 and all(table.slides[between].tolist())
        if not slides or frozenset((outer, inner)) in chain.robot.may_touch:
            continue
        axes = np.stack([frames[k, :, :3] @ chain.joints[k].axis for k in between])
        along = axes[0] * np.sign(axes[0, np.abs(axes[0]).argmax()])
        if np.abs(np.cross(along, axes)).max() > _PARALLEL:
            continue
        rates = np.zeros(len(chain.names))
        for k, rate in zip(between, axes @ along * table.factor[between], strict=True):
            rates[table.source[k]] += -rate if k in behind else rate
        way = turn.T @ along
        if found and np.abs(way - direction).max() > _PARALLEL:
            continue
        direction, ends = direction if found else way, rates[:, None] * chain.limits
        turned, moved = _placed(chain, frames, inner)
        low, high = ends.min(axis=1).sum(), ends.max(axis=1).sum()
        for piece in link_bodies(chain.robot.links[inner]):
            points = (piece.points @ turned.T + moved - origin) @ turn
            found.append(np.stack([points + low * way, points + high * way]))
    return direction, found


def _placed(chain: Chain, frames: FloatArray, link: str) -> tuple[FloatArray, FloatArray]:
    """Rotation (3, 3) and place (3,) of a link that frames (m, 3, 4) carry."""
    turn, place = chain.places[link][:3, :3], chain.places[link][:3, 3]
    if chain.frames[link] < 0:
        return turn, place
    frame = frames[chain.frames[link]]
    return frame[:, :3] @ turn, frame[:, :3] @ place + frame[:, 3]


def _way_into(
    triangles: FloatArray, direction: FloatArray, pieces: Sequence[FloatArray]
) -> OpenWay | None:
    """The way of as many pieces as slide into triangles (n, 3, 3); None where none does.

    Args:
        triangles: corners.
        direction: of the slide, (3,).
        pieces: corners (2, k, 3) of each at both ends of its slide.
    """
    inside = [
        one
        for one in pieces
        if _gets_into(triangles, direction, one)
        and _open_way(triangles, direction, [one]) is not None
    ]
    across = _across(direction).T
    chosen, found = list[FloatArray](), None
    for one in sorted(inside, key=lambda one: -float(np.ptp(one @ across, axis=(0, 1)).max())):
        way = _open_way(triangles, direction, [*chosen, one])
        if way is not None:
            chosen, found = [*chosen, one], way
    return found


def _gets_into(triangles: FloatArray, direction: FloatArray, piece: FloatArray) -> bool:
    """Check whether a piece gets between triangles (n, 3, 3), whose section is around its own."""
    own, along = piece @ direction, triangles @ direction
    if own.min() > along.max() or own.max() < along.min():
        return False
    across = _across(direction).T
    sides = scipy.spatial.ConvexHull(triangles.reshape(-1, 3) @ across).equations
    return bool((piece @ across @ sides[:, :2].T + sides[:, 2]).max() <= 0)


def _across(direction: FloatArray) -> FloatArray:
    """Two directions (2, 3) across one."""
    return np.linalg.svd(direction[None])[2][1:]


def _open_way(
    triangles: FloatArray, direction: FloatArray, pieces: Sequence[FloatArray]
) -> OpenWay | None:
    """The way of pieces, halfway to the triangles (n, 3, 3) around it; None if it is not open."""
    points = np.concatenate([one.reshape(-1, 3) for one in pieces])
    size = float(np.ptp(np.concatenate([first for first, _ in pieces]), axis=0).max())
    across = _across(direction)
    # the first four in the directions of a rectangle around the section
    first = principal_axes(points @ across.T @ across)[0]
    angles = 2 * math.pi * _in_turns(_SIDES) / _SIDES
    turns = np.stack([first, np.cross(direction, first)])
    normals = np.column_stack([np.cos(angles), np.sin(angles)]) @ turns
    heights = (points @ normals.T).max(axis=0)
    along = points @ direction
    tight = OpenWay(
        read_only(np.column_stack([normals, heights])),
        read_only(direction.copy()),
        *(float(along.min()), float(along.max())),
    )
    low, high = 0.0, _WIDEST * size
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        if tight.wider(middle).is_open(triangles):
            low = middle
        else:
            high = middle
    return tight.wider(low / 2) if low > 0 else None


def _in_turns(count: int) -> IntArray:
    """Numbers from 0 to a power of two, so that those come first that part a circle evenly."""
    numbers = np.arange(count, dtype=np.int32)
    return numbers[np.argsort(-np.gcd(numbers, count), kind="stable")]
