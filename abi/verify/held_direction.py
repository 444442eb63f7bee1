"""Check of the direction that a tool keeps for a part of its motion, in exact numbers.

While the joints turn by w in all, the tip's z axis turns by w at most. So where it is off by less
than the tolerance at one pose, by w, it is all along a stretch in which no joint gets farther from
that pose.

Or: if the joints turn by w' in all in the time of a stretch, and their second derivatives are w" in
all, that of the axis is w'² + w" at most, so that it leaves the chord between its ends by an eighth
of that at most. The chord is within every cone up to a right angle that both ends are in, and the
axis is off it by the arc sine of that distance at most.

Where neither tells, the stretch is halved.
"""

from __future__ import annotations

import bisect
import itertools
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, cast

from abi.scene.held_axis import HeldAxis
from abi.scene.scene import Scene
from abi.verify.exact.chain import ExactChain
from abi.verify.exact.frame import nearly_sine_and_cosine
from abi.verify.exact.solids import Vec3, dot, sqrt_bounds, sub, vector
from abi.verify.exact_path import ExactPath, Row, positions_at, rows_around
from abi.verify.fault import Fault
from abi.verify.plan_fields import finite, mapping, numbers_of

_SLACK = Fraction(1, 10**9)
"""Angle by which the tolerance may be exceeded, [rad], as URDF files are rounded."""
_SHORTEST = Fraction(1, 1 << 12)
"""Shortest stretch that is tried, over the interval between two samples."""
_MOST_STRETCHES = 20_000
"""Stretches that are tried at most, in seconds to half a minute."""
_ARC = Fraction(21, 20)
"""Arc sine of up to 1/2, over its argument, at most."""
_UNIFORM = 1e-9
"""Largest difference between steps of time, over the motion's duration."""


def check_held_at_samples(
    axis: HeldAxis,
    chain: ExactChain,
    tip: str,
    rows: Sequence[Sequence[Fraction]],
    section: dict[str, Any],
) -> str:
    """Check that the tip keeps a direction, and return what is proven as the end of a sentence.

    Args:
        axis: the direction, and the part of the motion that keeps it.
        chain: the arm.
        tip: the link.
        rows: positions between which the joints go straight, at uniform times.
        section: the plan's, with the times of some of the rows.

    Raises:
        Fault: it is not proven to.
    """
    _check_uniform(section, rows)
    last = len(rows) - 1
    path = [*itertools.pairwise([*row] for row in rows)]
    check_held(axis, chain, tip, path, (Fraction(axis.begin) * last, Fraction(axis.end) * last))
    return (
        f", the gripper within {axis.tolerance:g} rad of its direction from {axis.begin:g} to "
        f"{axis.end:g} of the time"
    )


def check_span(section: dict[str, Any], scene: Scene, duration: float) -> None:
    """Check when a plan says that it keeps a direction, and how well, against what is asked for.

    Args:
        section: the plan's ``arm``.
        scene: its scene.
        duration: of the motion, [s].

    Raises:
        Fault: the scene asks for another part of the motion or tolerance, or for no direction.
        SceneError: a field has the wrong form.
    """
    asked, exact = scene.arm.held_axis, scene.arm.exact_axis
    told = section.get("axis")
    if asked is None and exact is None:
        if told is not None:
            raise Fault("it says that it keeps a direction, and its scene asks for none")
        return
    if told is None:
        raise Fault("it does not say how far the gripper turns from the direction that is held")
    span = mapping("arm.axis", told)
    begin, end = (0.0, 1.0) if asked is None else (asked.begin, asked.end)
    for name, share in (("first", begin), ("last", end)):
        at = finite(f"arm.axis.{name}", span.get(name))
        if abs(at - share * duration) > _UNIFORM * duration:
            raise Fault("it says that it keeps a direction at other times than its scene asks for")
    if asked is not None and span.get("tolerance") != asked.tolerance:
        raise Fault("it says that it keeps a direction within another angle than is asked for")


def check_held_in_motion(
    data: dict[str, Any], scene: Scene, chain: ExactChain, path: ExactPath
) -> str:
    """Check what a verdict says of the tool's direction; what is proven, as part of a sentence.

    Args:
        data: the verdict on a motion from elsewhere.
        scene: its scene, which may ask for the direction.
        chain: the robot.
        path: the joints' motion.

    Raises:
        Fault: the direction is said to be kept, and is not proven to be.
    """
    told, axis, exact = data.get("direction"), scene.arm.held_axis, scene.arm.exact_axis
    if told is None and axis is None and exact is None:
        return ""
    told = {} if told is None else mapping("direction", told)
    if told.get("state") != "kept":
        return ", its tool's direction not said to be kept"
    if exact is not None:
        tolerance = finite("direction.tolerance", told.get("tolerance"))
        axis = HeldAxis(direction=exact, tolerance=tolerance)
    if axis is None or told.get("tolerance") != axis.tolerance or len(scene.tasks) > 1:
        raise Fault("the direction that it keeps is not the scene's")
    times = [Fraction(one) for one in numbers_of("motion.times", data["motion"]["times"])]
    if (axis.begin, axis.end) != (0.0, 1.0) and data["motion"].get("timed", True) is not True:
        raise Fault("it keeps a direction for a part of its time, and has no times")
    duration = times[-1] - times[0]
    begin, end = (times[0] + Fraction(one) * duration for one in (axis.begin, axis.end))
    for name, at in (("first", begin), ("last", end)):
        if abs(Fraction(finite(f"direction.{name}", told.get(name))) - at) > _UNIFORM * duration:
            raise Fault("the direction is kept at other times than the scene asks for")
    check_held(
        axis, chain, scene.arm.tool, path, (_parameter(times, begin), _parameter(times, end))
    )
    return f", its tool within {axis.tolerance:g} rad of its direction"


def _parameter(times: Sequence[Fraction], at: Fraction) -> Fraction:
    """Parameter of a time between the first and the last waypoint."""
    k = min(bisect.bisect_right(times, at), len(times) - 1) - 1
    return k + (at - times[k]) / (times[k + 1] - times[k])


def check_held(
    axis: HeldAxis,
    chain: ExactChain,
    tip: str,
    path: ExactPath,
    part: tuple[Fraction, Fraction],
) -> None:
    """Raise a Fault unless the tip is proven to keep a direction.

    Args:
        axis: the direction.
        chain: the arm.
        tip: the link whose z axis keeps it.
        path: the joints' motion.
        part: first and last parameter between which it is kept.
    """
    waiting, axes = [part], dict[Fraction, tuple[Vec3, Fraction]]()
    tolerance = Fraction(axis.tolerance) + _SLACK
    for count in itertools.count(1):
        if not waiting:
            return
        if count > _MOST_STRETCHES:
            raise Fault("the direction that it keeps has too little room to be checked")
        start, end = waiting.pop()
        middle = _cut(start, end)
        here = positions_at(path, middle)
        left = tolerance - _turn(chain, tip, here, rows_around(path, start, end))
        if left > 0 and _within(_z_axis(chain, tip, here), axis, left):
            continue
        bow = _bow(chain, tip, path, start, end)
        if bow is not None and bow < tolerance:
            for at in (start, end):
                if at not in axes:
                    axes[at] = _z_axis(chain, tip, positions_at(path, at))
            if all(_within(axes[at], axis, tolerance - bow) for at in (start, end)):
                continue
        if end - start < _SHORTEST:
            share = float(middle / len(path))
            within = f"within {axis.tolerance:g} rad at {share:.3f} of its time"
            raise Fault(f"the gripper does not keep its direction {within}")
        waiting += [(middle, end), (start, middle)]


def _bow(
    chain: ExactChain, tip: str, path: ExactPath, start: Fraction, end: Fraction
) -> Fraction | None:
    """Bound of the angle of the tip's axis off those between its ends; None over several pieces."""
    if end > min(int(start), len(path) - 1) + 1:
        return None
    rows = rows_around(path, start, end)
    degree, turn, growth = len(rows) - 1, Fraction(0), Fraction(0)
    for joint in (chain.joints[k] for k in chain.above(chain.frames[tip])):
        if joint.kind != "prismatic":
            values = [chain.value(joint, row) for row in rows]
            ways = [after - before for before, after in itertools.pairwise(values)]
            turn += degree * max(map(abs, ways))
            bends = (abs(after - before) for before, after in itertools.pairwise(ways))
            growth += degree * (degree - 1) * max(bends, default=Fraction(0))
    away = (turn * turn + growth) / 8
    return away * _ARC if 2 * away <= 1 else None


def _cut(start: Fraction, end: Fraction) -> Fraction:
    """Where a stretch is cut: between two pieces of the path if it is of several, else halfway."""
    middle = (start + end) / 2
    first, last = int(start) + 1, -int(-end // 1) - 1
    return Fraction(min(max(round(middle), first), last)) if first <= last else middle


def _check_uniform(section: dict[str, Any], rows: Sequence[Sequence[Fraction]]) -> None:
    """Raise unless what is written is every k-th row, at uniform times."""
    times = numbers_of("arm.time", section.get("time"))
    written = [numbers_of("arm.positions", row) for row in section["positions"]]
    steps, rest = divmod(len(rows) - 1, max(len(times) - 1, 1))
    if rest or [[*map(Fraction, row)] for row in written] != [*map(list, rows[::steps])]:
        raise Fault("its times are not those of its positions")
    duration = times[-1] - times[0]
    uniform = [times[0] + k * duration / (len(times) - 1) for k in range(len(times))]
    far = max(abs(one - other) for one, other in zip(times, uniform, strict=True))
    if far > _UNIFORM * duration or len(times) != len(written):
        raise Fault("its times are not uniform")


def _turn(chain: ExactChain, tip: str, here: Row, others: Sequence[Row]) -> Fraction:
    """Bound of the turn of the tip from a pose while the coordinates stay among others, [rad]."""
    total = Fraction(0)
    for k in chain.above(chain.frames[tip]):
        joint = chain.joints[k]
        if joint.kind != "prismatic":
            at = chain.value(joint, here)
            values = [chain.value(joint, one) for one in others]
            total += max(max(values) - at, at - min(values))
    return total


def _z_axis(chain: ExactChain, tip: str, here: Row) -> tuple[Vec3, Fraction]:
    """The z axis of a link at a pose, and a bound of its error along each axis."""
    frame, pose = chain.frames[tip], chain.places[tip]
    turn, origin = pose[:3, :3], pose[:3, 3]
    ends = [cast(Vec3, tuple(one)) for one in (origin, origin + turn[:, 2])]
    if frame < 0:
        return sub(ends[1], ends[0]), Fraction(0)
    (first, error), (last, other) = (chain.place(here)[frame].place(one) for one in ends)
    return sub(last, first), error + other


def _within(z: tuple[Vec3, Fraction], axis: HeldAxis, angle: Fraction) -> bool:
    """Check whether an axis is at most ``angle``, up to π / 2, off a direction."""
    (along, error), direction = z, vector(axis.direction)
    least = dot(along, direction) - error * sum(map(abs, direction))
    length = sqrt_bounds(dot(along, along) * dot(direction, direction))[1]
    return least >= nearly_sine_and_cosine(angle)[1] * length
