"""Links that are said never to touch by their own shapes, tested in all of their positions.

Between them there are one joint or two. Their positions are divided into boxes: if the links are
farther apart in the middle of one than their points move beside each other in it, they are apart in
all of it. Only surfaces are compared: what is inside of what it never meets would touch it always.
Computed in floating point, with no code that plans.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.distance import cdist
from scipy.spatial.transform import Rotation

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.robot.urdf.robot import Robot
from abi.verify.exact.chain import ExactChain
from abi.verify.exact.frame import ExactFrame
from abi.verify.link_contact import (
    LinkTriangles,
    TrianglePairs,
    link_triangles,
    meet,
    near_triangles,
)

_MOST_JOINTS = 2
_WORK = 5_000_000
"""Boxes times triangles of both links, at most: some ten seconds."""
_POSES = 64
"""Random positions in which none may touch, before boxes are tried."""
_TRIED = 4
"""Boxes of equal size that are left, of which it is tried whether links meet in the middle."""
_MANY = 8192
"""Pairs of triangles that are compared together."""
_RIM = 2e-4
"""What a cylinder's rim may be beyond its triangles, over its radius."""


class _Axis(NamedTuple):
    """A joint between two links, as it stands in the middle of its range, [unit].

    Attributes:
        place: of a point on it, (3,).
        direction: of it, (3,), or its way for one unit of its coordinate if it slides.
        slides: whether it does.
        rate: how far it turns for one unit of its coordinate, the second link beside the first.
        coordinate: its number.
        most: how far that gets from the middle.
    """

    place: FloatArray
    direction: FloatArray
    slides: bool
    rate: float
    coordinate: int
    most: float

    def moved(self, points: FloatArray, way: float) -> FloatArray:
        """Points (..., 3) once its coordinate has gone a ``way`` further."""
        if self.slides:
            return points + self.rate * way * self.direction
        turn = Rotation.from_rotvec(self.rate * way * self.direction).as_matrix()
        return np.asarray((points - self.place) @ turn.T + self.place)

    def feet(self, points: FloatArray) -> FloatArray:
        """The points of the axis that are nearest to points (n, 3)."""
        along = (points - self.place) @ self.direction
        return np.asarray(self.place + np.outer(along, self.direction))


def never_touch(robot: Robot, chain: ExactChain, first: str, second: str) -> bool:
    """Check whether two links are apart in all positions within the chain's limits.

    Args:
        robot: the robot.
        chain: its chain.
        first: name of a link.
        second: name of another.
    """
    if not all(robot.links[name].shapes for name in (first, second)):
        return False
    middle = [(low + high) / 2 for low, high in chain.limits]
    frames = chain.place(middle)
    axes = _axes(chain, frames, first, second)
    if not 1 <= len(axes) <= _MOST_JOINTS:
        return False
    still, moved = (_placed(robot, chain, frames, name) for name in (first, second))
    used = sorted({one.coordinate for one in axes})
    ways = np.zeros(len(used))
    for one, way in zip(axes, _ways(axes, still, moved), strict=True):
        ways[used.index(one.coordinate)] += way
    half = np.array([float(high - low) / 2 for low, high in (chain.limits[k] for k in used)])
    if all(abs(one.rate) == 1 and not one.slides for one in axes):
        half = np.minimum(half, np.pi)  # after a turn all is as before
    slack = sum(_rim(robot, name) for name in (first, second)) * float(chain.units)
    some = np.random.default_rng(0).uniform(-half, half, (_POSES, len(half)))
    if _meeting(still, moved, axes, some, np.zeros(_POSES)).any():
        return False
    low, high = -half[None], half[None]
    left = _WORK // (len(still.corners) + len(moved.corners))
    while len(low):
        left -= len(low)
        if left < 0:
            return False
        middles, reach = (low + high) / 2, ways * (high - low) / 2
        near = _meeting(still, moved, axes, middles, slack + reach.sum(axis=1))
        few = middles[near][:: int(near.sum()) // _TRIED + 1]
        if _meeting(still, moved, axes, few, np.zeros(len(few))).any():
            return False
        low, high, middles, widest = (
            low[near],
            high[near],
            middles[near],
            reach[near].argmax(axis=1),
        )
        rows = np.arange(len(low))
        after, before = low.copy(), high.copy()
        after[rows, widest] = before[rows, widest] = middles[rows, widest]
        low, high = np.concatenate([low, after]), np.concatenate([before, high])
    return True


def _meeting(
    still: LinkTriangles,
    moved: LinkTriangles,
    axes: Sequence[_Axis],
    positions: FloatArray,
    within: FloatArray,
) -> BoolArray:
    """Check where the surfaces of links are nearer than ``within`` (k,).

    ``positions`` (k, c) of the coordinates between them are counted from the middle.
    """
    used = sorted({one.coordinate for one in axes})
    found = np.zeros(len(positions), dtype=np.bool_)
    waiting, count = list[tuple[int, TrianglePairs]](), 0
    corners, points = moved.corners.reshape(-1, 3), np.unique(still.corners.reshape(-1, 3), axis=0)
    once = np.unique(corners, axis=0, return_index=True)[1]
    for number, (at, distance) in enumerate(zip(positions.tolist(), within.tolist(), strict=True)):
        there = corners
        for one in reversed(axes):
            there = one.moved(there, at[used.index(one.coordinate)])
        if cdist(points, there[once]).min() <= distance:  # which is quickly said
            found[number] = True
            continue
        placed = moved._replace(corners=there.reshape(-1, 3, 3))
        for few in near_triangles(still, placed, distance):
            waiting.append((number, few))
            count += len(few[0])
        if count > _MANY:
            found[_hits(waiting)] = True
            waiting, count = [], 0
    found[_hits(waiting)] = True
    return found


def _hits(waiting: Sequence[tuple[int, TrianglePairs]]) -> IntArray:
    """Numbers of those that have triangles which meet."""
    if not waiting:
        return np.zeros(0, dtype=np.int32)
    numbers, all_ = zip(*waiting, strict=True)
    meeting = meet(*(np.concatenate(column) for column in zip(*all_, strict=True)))
    return np.repeat(np.array(numbers, np.int32), [len(reach) for *_, reach in all_])[meeting]


def _axes(chain: ExactChain, frames: Sequence[ExactFrame], first: str, second: str) -> list[_Axis]:
    """Joints between two links, the one next to the first link first."""
    up, down = (chain.above(chain.frames[name]) for name in (first, second))
    found = []
    for k in (
        *(one for one in up if one not in down),
        *(one for one in down[::-1] if one not in up),
    ):
        joint, (turn, origin) = chain.joints[k], _floats(frames[k])
        number = chain.coordinates.index(joint.coordinate)
        slides, units = joint.kind == "prismatic", float(chain.units)
        rate = joint.factor * (units if slides else 1.0) / (units if chain.slides[number] else 1.0)
        # seen from the first link, a joint that moves it moves all others back
        rate *= -1.0 if k in up else 1.0
        low, high = chain.limits[number]
        most = float(high - low) / 2
        found.append(_Axis(origin, turn @ joint.axis, slides, rate, number, most))
    return found


def _ways(axes: Sequence[_Axis], *links: LinkTriangles) -> list[float]:
    """Farthest that links move beside each other for one unit of each joint's coordinate, [unit].

    That is at most as far as the points of either link are from the joint's axis. Another joint
    between takes a point around its axis: it is no farther away than the middle of its circle and
    the circle's radius. A slide takes it as far as itself.
    """
    found = []
    for number, one in enumerate(axes):
        if one.slides:
            found.append(abs(one.rate))
            continue
        reaches = []
        for link, between in zip(links, (axes[:number], axes[number + 1 :][::-1]), strict=True):
            points, wider = link.corners.reshape(-1, 3), np.repeat(link.radii, 3)
            for other in between:
                if other.slides:
                    wider = wider + abs(other.rate) * other.most
                    continue
                feet = other.feet(points)
                wider = wider + np.linalg.norm(points - feet, axis=1)
                points = feet
            away = np.linalg.norm(points - one.feet(points), axis=1)
            reaches.append(float((away + wider).max()))
        found.append(abs(one.rate) * min(reaches))
    return found


def _placed(
    robot: Robot, chain: ExactChain, frames: Sequence[ExactFrame], name: str
) -> LinkTriangles:
    """Triangles of a link where frames are, [unit]."""
    pose = chain.places[name].astype(np.float64)
    turn, origin = pose[:3, :3], pose[:3, 3]
    own = link_triangles(robot.links[name], float(chain.units)).placed(turn, origin)
    return own if chain.frames[name] < 0 else own.placed(*_floats(frames[chain.frames[name]]))


def _floats(frame: ExactFrame) -> tuple[FloatArray, FloatArray]:
    """Rotation (3, 3) and origin (3,) of a frame."""
    turn, origin = (part.astype(float) / 2.0**200 for part in frame[:2])
    return turn, origin


def _rim(robot: Robot, name: str) -> float:
    """What a link's cylinders may be beyond its triangles, [m]."""
    radii = (shape.size[0] for shape in robot.links[name].shapes if shape.kind == "cylinder")
    return _RIM * max(radii, default=0.0)
