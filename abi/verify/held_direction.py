"""Check of the direction that a tool keeps for a part of its motion, in exact numbers.

While the joints turn by w in all, the tip's z axis turns by w at most. So where it is off by less
than the tolerance at one pose, by w, it is all along a stretch in which no joint gets farther from
that pose; otherwise the stretch is halved.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from abi.scene.held_axis import HeldAxis
from abi.verify.exact.chain import ExactChain, ExactFrame, nearly_sine_and_cosine
from abi.verify.exact.solids import dot, sqrt_bounds, sub, vector
from abi.verify.fault import Fault
from abi.verify.plan_fields import numbers_of

_SLACK = Fraction(1, 10**9)
"""Angle by which the tolerance may be exceeded, [rad], as URDF files are rounded."""
_SHORTEST = Fraction(1, 1 << 12)
"""Shortest stretch that is tried, over the interval between two samples."""
_UNIFORM = 1e-9
"""Largest difference between steps of time, over the motion's duration."""


def check_held(
    axis: HeldAxis, chain: ExactChain, rows: Sequence[Sequence[Fraction]], section: dict[str, Any]
) -> str:
    """Check that the tip keeps a direction, and return what is proven as the end of a sentence.

    Args:
        axis: the direction, and the part of the motion that keeps it.
        chain: the arm.
        rows: positions between which the joints go straight, at uniform times.
        section: the plan's, with the times of some of the rows.

    Raises:
        Fault: it is not proven to.
    """
    _check_uniform(section, rows)
    last = len(rows) - 1
    waiting = [(Fraction(axis.begin) * last, Fraction(axis.end) * last)]
    tolerance = Fraction(axis.tolerance) + _SLACK
    while waiting:
        start, end = waiting.pop()
        middle = (start + end) / 2
        here = _positions(rows, middle)
        left = tolerance - _turn(chain, here, _between(rows, start, end))
        if left > 0 and _within(chain.place(here)[-1], axis, left):
            continue
        if end - start < _SHORTEST:
            within = f"within {axis.tolerance:g} rad at {float(middle / last):.3f} of its time"
            raise Fault(f"the gripper does not keep its direction {within}")
        waiting += [(middle, end), (start, middle)]
    return (
        f", the gripper within {axis.tolerance:g} rad of its direction from {axis.begin:g} to "
        f"{axis.end:g} of the time"
    )


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


def _positions(rows: Sequence[Sequence[Fraction]], at: Fraction) -> list[Fraction]:
    """Coordinates at a parameter."""
    row = min(int(at), len(rows) - 2)
    pairs = zip(rows[row], rows[row + 1], strict=True)
    return [a + (at - row) * (b - a) for a, b in pairs]


def _between(
    rows: Sequence[Sequence[Fraction]], start: Fraction, end: Fraction
) -> list[Sequence[Fraction]]:
    """Coordinates at both ends of a stretch and at the rows in it."""
    inside = rows[int(start) + 1 : -int(-end // 1)]
    return [_positions(rows, start), _positions(rows, end), *inside]


def _turn(
    chain: ExactChain, here: Sequence[Fraction], others: list[Sequence[Fraction]]
) -> Fraction:
    """Bound of the turn of the tip from a pose while the coordinates stay among others, [rad]."""
    total = Fraction(0)
    for k in chain.above(chain.before[-1]):
        joint = chain.joints[k]
        if joint.kind != "prismatic":
            at = chain.value(joint, here)
            total += max(abs(chain.value(joint, one) - at) for one in others)
    return total


def _within(frame: ExactFrame, axis: HeldAxis, angle: Fraction) -> bool:
    """Check whether the z axis of a frame is at most ``angle``, up to π / 2, off a direction."""
    (origin, error), (tip, other) = (frame.place(vector(one)) for one in ((0, 0, 0), (0, 0, 1)))
    z, direction = sub(tip, origin), vector(axis.direction)
    slack = (error + other) * sum(map(abs, direction))
    least = dot(z, direction) - slack
    length = sqrt_bounds(dot(z, z) * dot(direction, direction))[1]
    return least >= nearly_sine_and_cosine(angle)[1] * length
