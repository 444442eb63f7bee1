"""Check of a motion's samples: the joints of their columns, and their times.

Where the tool is, how fast the joints are, and that limits hold is told beside them, and checked.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from abi.arrays import FloatArray
from abi.verify.exact.solids import Vec3, sub
from abi.verify.fault import Fault
from abi.verify.plan_fields import finite, list_of, numbers_of, vector_of

_SAME = 1e-9
"""Accepted error of a time, over the duration and 1 s; of a speed, over the largest."""


def check_samples(section: dict[str, Any], timing: dict[str, Any], joints: Sequence[str]) -> None:
    """Check that a motion's samples name its joints in order, and are evenly spaced in time.

    Args:
        section: the plan's ``arm``.
        timing: the plan's ``timing``, with the motion's duration.
        joints: names of the joints, in the order of the columns.

    Raises:
        Fault: they are not.
        SceneError: a field has the wrong form.
    """
    if list(list_of("arm.joints", section.get("joints"))) != list(joints):
        raise Fault("its joints have other names, or another order")
    times = numbers_of("arm.time", section.get("time"))
    if len(times) < 2 or len(times) != len(list_of("arm.positions", section.get("positions"))):
        raise Fault("its samples have not one time each")
    duration = finite("timing.duration", timing.get("duration"))
    even = np.linspace(0.0, duration, len(times))
    if duration < 0 or np.abs(np.subtract(times, even)).max() > _SAME * max(1.0, duration):
        raise Fault("its times do not go evenly from 0 to the motion's duration")
    _check_speeds(section, np.diff(times))
    if section.get("within_limits") is bool(section.get("limits_passed")):
        raise Fault("it both keeps its limits and passes some, or neither")


def check_tool_points(
    section: dict[str, Any], placed: Callable[[Sequence[Fraction]], Vec3], allowed: Fraction
) -> None:
    """Check that the stated tool positions follow from the joints at every sample.

    Args:
        section: the plan's ``arm``.
        placed: the tool at joint positions, [unit], world.
        allowed: error along each axis that is let pass, [unit].

    Raises:
        Fault: it is not.
        SceneError: a field has the wrong form.
    """
    rows, points = (list_of(f"arm.{name}", section.get(name)) for name in ("positions", "tool"))
    if len(rows) != len(points):
        raise Fault("its samples have not one place of the tool tip each")
    for number, (row, point) in enumerate(zip(rows, points, strict=True)):
        at = placed([Fraction(one) for one in numbers_of("arm.positions", row)])
        if max(map(abs, sub(at, vector_of("arm.tool", point)))) > allowed:
            raise Fault(
                f"at sample {number} the tool tip is told to be where the joints do not take it"
            )


def _check_speeds(section: dict[str, Any], steps: FloatArray) -> None:
    """Raise if a joint's mean speed between two samples exceeds its stated peak."""
    peaks = numbers_of("arm.peak_joint_speed", section.get("peak_joint_speed"))
    rows = [numbers_of("arm.positions", row) for row in section["positions"]]
    if any(len(row) != len(peaks) for row in rows):
        raise Fault("its joints have not one peak speed each")
    ways = np.abs(np.diff(rows, axis=0))
    largest = np.array(peaks) * (1 + _SAME) + _SAME
    if (ways > largest * steps[:, None] + _SAME).any():
        raise Fault("a joint is faster between two samples than its peak speed")
