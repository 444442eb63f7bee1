"""The direction that a scene asks of the tool, along a motion that was planned elsewhere.

While the turning joints before the tip turn by w in all, its z axis turns by w at most. So where it
is off by no more than the tolerance less w at one pose, it keeps the tolerance on a stretch in
which the joints' Bézier points stay that near to the pose; otherwise the stretch is halved.
:mod:`abi.verify.held_direction` checks it in exact arithmetic.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, Literal, NamedTuple

import numpy as np

from abi.arm_planning.joint_search.held_span import EXACTLY
from abi.arrays import FloatArray
from abi.certification.robot_motion import RobotMotion, on_curves
from abi.robot.kinematics.chain import Chain
from abi.scene.held_axis import HeldAxis
from abi.scene.scene import Scene

_SHORTEST = 1 / 4096
"""Shortest stretch that is halved, over the time between two waypoints."""
_MOST = 50_000
"""Stretches that are looked at in one round, at most."""
_NEAR = 1e-9
"""Least angle by which a stretch keeps the tolerance: rounding decides nothing, [rad]."""
_MEASURED = 401
"""Samples at least at which the angle is measured."""

Kept = Literal["kept", "left", "undecided", "not judged"]


class KeptDirection(NamedTuple):
    """Whether the tip's z axis keeps a direction for a part of a motion.

    Attributes:
        state: ``kept``: proven all along; ``left``: not kept somewhere; ``undecided``; or ``not
            judged``: the motion does not say when the part is.
        tolerance: largest angle that is asked for, [rad].
        first, last: times of the part, [s].
        angle: largest angle that was measured, [rad]; None if it is not judged.
        time: of that, [s]; None if it is not judged.
        stretches: times between which it is not kept, or not decided, [s]; elsewhere it is proven.
        why: what kept it from being judged, as the end of a sentence; else empty.
    """

    state: Kept
    tolerance: float
    first: float
    last: float
    angle: float | None = None
    time: float | None = None
    stretches: tuple[tuple[float, float], ...] = ()
    why: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return self._asdict()


def kept_direction(motion: RobotMotion, scene: Scene) -> KeptDirection | None:
    """Prove that a motion keeps its tool's direction, or find where not; None if none is asked for.

    One that is held exactly counts as kept within :data:`EXACTLY`.

    Args:
        motion: the motion.
        scene: with the direction.
    """
    axis = held_axis_of(scene)
    if axis is None:
        return None
    times = motion.motion.times
    start, duration = float(times[0]), float(times[-1] - times[0])
    first, last = start + axis.begin * duration, start + axis.end * duration
    if why := _unknown(motion, scene, axis):
        return KeptDirection("not judged", axis.tolerance, first, last, why=why)
    tool = scene.arm.tool
    angles_at = partial(_angles, motion.chain, tool, np.array(axis.direction))
    begin, end = np.interp((first, last), times, np.arange(float(len(times)))).tolist()
    places = _places(begin, end)
    angles = angles_at(motion.positions_at(places))
    worst = int(angles.argmax())
    peak = float(angles[worst]), motion.time_at(float(places[worst]))
    turns = _turns(motion.chain, motion.chain.frames[tool])
    beyond, unsure = _outside(motion, angles_at, turns, axis.tolerance, (begin, end))
    open_ = np.concatenate([beyond, unsure])
    left = len(beyond) > 0 or peak[0] > axis.tolerance
    state: Kept = "left" if left else "undecided" if len(open_) else "kept"
    shown = [(motion.time_at(low), motion.time_at(high)) for low, high in _merged(open_)]
    return KeptDirection(state, axis.tolerance, first, last, *peak, tuple(shown))


def held_axis_of(scene: Scene) -> HeldAxis | None:
    """The direction that a scene asks for, one that is held exactly within :data:`EXACTLY`."""
    exact = scene.arm.exact_axis
    return scene.arm.held_axis if exact is None else HeldAxis(direction=exact, tolerance=EXACTLY)


def _unknown(motion: RobotMotion, scene: Scene, axis: HeldAxis) -> str:
    """Why it is not known when the direction is to be kept; empty if it is."""
    if len(scene.tasks) > 1:
        return "the scene has several legs, and a motion does not say where each begins"
    if not motion.motion.timed and (axis.begin, axis.end) != (0.0, 1.0):
        return "only a part of the time is asked for, and the motion has no times"
    return ""


def _angles(chain: Chain, link: str, direction: FloatArray, positions: FloatArray) -> FloatArray:
    """Angles (k,) between a link's z axis and a direction at joint positions (k, n), [rad]."""
    z, frame = chain.places[link][:3, 2], chain.frames[link]
    if frame < 0:
        tip = np.tile(z, (len(positions), 1))
    else:
        tip = chain.poses(positions)[:, frame, :, :3] @ z
    direction = direction / np.linalg.norm(direction)
    apart, along = tip - direction, tip + direction  # exact where one is small
    squares = (apart * apart).sum(axis=1), (along * along).sum(axis=1)
    return np.asarray(2 * np.arctan2(*map(np.sqrt, squares)))


def _turns(chain: Chain, frame: int) -> FloatArray:
    """Largest turn of a frame per unit of each coordinate, (n,), [rad]."""
    table, found = chain.table, np.zeros(len(chain.names))
    while frame >= 0:
        if not table.slides[frame]:
            found[table.source[frame]] += abs(float(table.factor[frame]))
        frame = int(table.before[frame])
    return found


def _places(begin: float, end: float) -> FloatArray:
    """Parameters at which the angle is measured: waypoints, and places between."""
    inside = np.arange(np.ceil(begin), np.floor(end) + 1)
    return np.unique(np.concatenate([np.linspace(begin, end, _MEASURED), inside]))


def _outside(
    motion: RobotMotion,
    angles_at: Callable[[FloatArray], FloatArray],
    turns: FloatArray,
    tolerance: float,
    span: tuple[float, float],
) -> tuple[FloatArray, FloatArray]:
    """Stretches (k, 2) on which the direction is not kept, and those (l, 2) not decided.

    Args:
        motion: the motion.
        angles_at: angles (k,) off the direction at joint positions (k, n).
        turns: largest turn of the tool per unit of each coordinate, (n,).
        tolerance: largest angle that is asked for.
        span: parameters between which it is.
    """
    begin, end = span
    pieces = np.arange(int(begin), max(int(np.ceil(end)), int(begin) + 1))
    ends = np.stack([np.maximum(pieces, begin), np.minimum(pieces + 1, end)], axis=1)
    points = motion.points[pieces]
    points = _cut(points, ends - pieces[:, None])
    beyond, unsure = [np.zeros((0, 2))], [np.zeros((0, 2))]
    while len(points):
        halves = np.full(len(points), 0.5)
        middles = on_curves(points, halves)
        angles = angles_at(middles)
        turned = np.abs(points - middles[:, None]).max(axis=1) @ turns
        outside = angles - turned > tolerance
        left = ~outside & (angles + turned > tolerance - _NEAR)
        beyond.append(ends[outside])
        finest = left & ((np.diff(ends)[:, 0] < 2 * _SHORTEST) | (left.sum() > _MOST))
        beyond.append(ends[finest & (angles > tolerance)])
        unsure.append(ends[finest & (angles <= tolerance)])
        halved = left & ~finest
        points, ends = points[halved], ends[halved]
        middle = ends.mean(axis=1)
        sides = np.tile([0.0, 0.5], (len(points), 1)), np.tile([0.5, 1.0], (len(points), 1))
        points = np.concatenate([_cut(points, side) for side in sides])
        ends = np.concatenate(
            [np.stack([ends[:, 0], middle], axis=1), np.stack([middle, ends[:, 1]], axis=1)]
        )
    return np.concatenate(beyond), np.concatenate(unsure)


def _cut(points: FloatArray, shares: FloatArray) -> FloatArray:
    """Bézier points (k, d + 1, n) of the parts of curves between two shares (k, 2) of each."""
    low, high = shares.T[:, :, None, None]
    rows = [points[:, i : i + 1] for i in range(points.shape[1])]
    for level in range(1, len(rows)):
        for i in range(len(rows) - 1, level - 1, -1):
            rows[i] = rows[i - 1] + high * (rows[i] - rows[i - 1])
    inner = low / high
    for level in range(1, len(rows)):
        for i in range(len(rows) - level):
            rows[i] = rows[i] + inner * (rows[i + 1] - rows[i])
    return np.concatenate(rows, axis=1)


def _merged(stretches: FloatArray) -> list[tuple[float, float]]:
    """Stretches in order, those that adjoin as one."""
    found: list[tuple[float, float]] = []
    for low, high in stretches[np.argsort(stretches[:, 0])].tolist():
        if found and low <= found[-1][1]:
            found[-1] = found[-1][0], max(high, found[-1][1])
        else:
            found.append((low, high))
    return found
