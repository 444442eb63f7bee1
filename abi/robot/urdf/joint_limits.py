"""Limits of a URDF's joints; implausible numbers mean no limit.

The formats: http://wiki.ros.org/urdf/XML/joint and http://wiki.ros.org/pr2_controller_manager/safety_limits.
"""

from __future__ import annotations

import math

from abi.robot.urdf.strict_xml import XmlElement

TURN = 2 * math.pi
_SLIDE = 10.0
"""Limit of a sliding joint without one, [m]."""
_MOST = 1e3
"""Largest plausible limit of a position, [rad] or [m]; greater ones mean none."""
_MOST_RATE = 1e9
"""Largest plausible limit of a speed, a torque or a force."""
_RATES = ("velocity", "effort")


def read_rates(joint: XmlElement) -> tuple[float, float]:
    """Largest speed, [rad/s] or [m/s], and effort, [N·m] or [N], of a joint; inf for none.

    Raises:
        SceneError: one is NaN or no number.
    """
    limit = joint.child("limit")
    rates = [None if limit is None else limit.bound(name, _MOST_RATE) for name in _RATES]
    for name, rate in zip(_RATES, rates, strict=True):
        if rate is not None and (rate < 0 or math.isinf(rate)):
            joint.tell(f"Without limit of {name}, as that is negative or beyond sense:")
        elif rate == 0:  # many files have that where they mean no limit
            joint.tell(f"Without limit of {name}, as that is 0:")
    speed, effort = (rate if rate and rate > 0 else math.inf for rate in rates)
    return speed, effort


def read_range(joint: XmlElement, kind: str) -> tuple[float, float]:
    """Lowest and highest position of a joint that moves, [rad] or [m].

    There is a note if they differ from its ``<limit>``.

    Args:
        joint: its element.
        kind: ``revolute``, ``continuous`` or ``prismatic``.

    Raises:
        SceneError: one is NaN or no number.
    """
    if kind == "continuous":
        return -TURN, TURN
    limit = joint.child("limit")
    sides = [None if limit is None else limit.bound(name, _MOST) for name in ("lower", "upper")]
    if sides == [None, None] and joint.child("mimic") is None:
        joint.tell("Stands still, as its <limit> has no lower and upper:")
    elif sides[0] == sides[1] and None not in sides and joint.child("mimic") is None:
        joint.tell("Stands still, as its lower limit is the upper:")
    low, high = (side or 0.0 for side in sides)
    if math.isinf(low) or math.isinf(high):
        most = TURN if kind == "revolute" else _SLIDE
        unit = "rad" if kind == "revolute" else "m"
        joint.tell(f"Without limit, so taken to go as far as {most:.3g} {unit}:")
        low = min(-most, high - most) if low == -math.inf else low
        high = max(most, low + most) if high == math.inf else high
    if not low <= high or math.isinf(low) or math.isinf(high):
        joint.tell("Stands still at 0, as its lower limit is above the upper:")
        return 0.0, 0.0
    return _softened(joint, low, high)


def _softened(joint: XmlElement, low: float, high: float) -> tuple[float, float]:
    """Limits tightened by a joint's safety controller."""
    soft = _soft(joint)
    if soft is None:
        return low, high
    inner = max(low, soft[0]), min(high, soft[1])
    if inner[0] > inner[1]:
        joint.tell("Soft limits are not used, as they are outside the others:")
        return low, high
    if inner != (low, high):
        joint.tell("Planned within the soft limits of the <safety_controller>:")
    return inner


def _soft(joint: XmlElement) -> tuple[float, float] | None:
    """Soft limits of a joint's safety controller; None without any."""
    safety = joint.child("safety_controller")
    if safety is None:
        return None
    low, high = (safety.bound(f"soft_{side}_limit", _MOST) for side in ("lower", "upper"))
    # each is 0 by default, and both are where only speeds are limited
    low, high = low or 0.0, high or 0.0
    return (low, high) if low < high else None
