"""Check of the samples of a plan's motion: which joints their columns are of, and when each is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from abi.verify.certificate import Fault
from abi.verify.plan_fields import finite, list_of, numbers_of

_SAME = 1e-9
"""Error of a time that is let pass, over the duration and 1 s."""


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
