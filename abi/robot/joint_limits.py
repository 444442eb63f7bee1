"""Limits of a URDF's joints, in which numbers beyond sense mean none.

The formats: http://wiki.ros.org/urdf/XML/joint and http://wiki.ros.org/pr2_controller_manager/safety_limits.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from abi.robot.strict_xml import Element

TURN = 2 * math.pi
_SLIDE = 10.0
"""Limit of a sliding joint that has none, [m]."""
_MOST = 1e3
"""Largest limit of a position that is meant, [rad] or [m]; greater ones mean none."""
_MOST_RATE = 1e9
"""The same of a speed, a torque or a force."""
_RATES = ("velocity", "effort")


class Limits(NamedTuple):
    """Limits of a joint.

    Attributes:
        low, high: of its position, [rad] or [m].
        speed: largest, [rad/s] or [m/s]; inf for none.
        effort: largest torque or force, [N·m] or [N]; inf for none.
        notes: why it is limited otherwise than its ``<limit>`` says, as the beginnings of
            sentences that end in names of joints.
    """

    low: float
    high: float
    speed: float
    effort: float
    notes: tuple[str, ...] = ()


def read_limits(joint: Element, kind: str) -> Limits:
    """Limits of a joint that moves.

    Args:
        joint: its element.
        kind: ``revolute``, ``continuous`` or ``prismatic``.

    Raises:
        SceneError: one is NaN or no number, or lower is above upper.
    """
    limit = joint.child("limit")
    notes: list[str] = []
    rates = [0.0 if limit is None else limit.bound(name, _MOST_RATE) or 0.0 for name in _RATES]
    # many files have 0 where they mean no limit, and nothing is made of that
    speed, effort = (rate if rate > 0 else math.inf for rate in rates)
    for name, rate in zip(_RATES, rates, strict=True):
        if rate < 0 or math.isinf(rate):
            notes.append(f"Without limit, as their {name} is negative or beyond sense")
    if kind == "continuous":
        return Limits(-TURN, TURN, speed, effort, tuple(notes))
    sides = [None if limit is None else limit.bound(name, _MOST) for name in ("lower", "upper")]
    if sides == [None, None] and joint.child("mimic") is None:
        notes.append("Joints that stand still, as their <limit> has no lower and upper")
    low, high = (side or 0.0 for side in sides)
    if math.isinf(low) or math.isinf(high):
        most = TURN if kind == "revolute" else _SLIDE
        unit = "rad" if kind == "revolute" else "m"
        notes.append(f"Without limit, so taken to go as far as {most:.3g} {unit}")
        low = min(-most, high - most) if low == -math.inf else low
        high = max(most, low + most) if high == math.inf else high
    if not low <= high or math.isinf(low) or math.isinf(high):
        raise joint.refuse("limit", (low, high), "lower at most upper")
    soft = _soft(joint)
    if soft is not None:
        inner = max(low, soft[0]), min(high, soft[1])
        if inner[0] > inner[1]:
            notes.append("Soft limits outside the others are not used of")
        elif inner != (low, high):
            notes.append("Planned within the soft limits of their <safety_controller>")
            low, high = inner
    return Limits(low, high, speed, effort, tuple(notes))


def _soft(joint: Element) -> tuple[float, float] | None:
    """Soft limits of a joint's safety controller; None if it gives none."""
    safety = joint.child("safety_controller")
    if safety is None:
        return None
    low, high = (safety.bound(f"soft_{side}_limit", _MOST) for side in ("lower", "upper"))
    # each is 0 by default, and both are where only speeds are limited
    low, high = low or 0.0, high or 0.0
    return (low, high) if low < high else None
