"""Diagnosis of a scene in which no motion keeps the direction of the tool: changes that work."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from abi.arm_planning.arm_errors import NoJointMotion
from abi.arrays import read_only
from abi.explain.reason import Reason
from abi.explain.what_if import WhatIf
from abi.scene.held_axis import HeldAxis

_LEFT_OUT = (0.1, 0.25, 0.5)
"""Shares of the part at whose end it may point elsewhere."""
_WIDER = (2.0, 4.0)
"""Multiples of the tolerance."""


def held_direction_reason(axis: HeldAxis, error: NoJointMotion, what_if: WhatIf) -> Reason:
    """Find a change that helps: a later begin, an earlier end, or a larger tolerance.

    Args:
        axis: the direction that is asked for.
        error: why no motion keeps it.
        what_if: plans the changed scenes.

    Raises:
        CancelledError: the caller has cancelled the trials.
    """
    nowhere = read_only(np.zeros((0, 3)))
    for remedy, changed in _remedies(axis, error.where):
        change = {"arm": {"axis": {**axis.model_dump(), **changed}}}
        if what_if.plan_past("arm", **change):
            return Reason(error.message, f"{remedy} works (tested).", change, nowhere)
    hint = "Neither a shorter part nor a larger tolerance that was tried helps."
    return Reason(error.message, hint, None, nowhere)


def _remedies(axis: HeldAxis, where: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Changes of the axis to try, and the beginnings of sentences about them."""
    length = axis.end - axis.begin
    if where == "path":
        for times in _WIDER:
            wider = float(f"{min(times * axis.tolerance, math.pi / 2):.3g}")
            yield f"A tolerance of {math.degrees(wider):.3g}°", {"tolerance": wider}
    for share in _LEFT_OUT:
        if where != "goal":
            begin = round(axis.begin + share * length, 3)
            yield f"To keep it from {100 * begin:.3g} % of the time on", {"from": begin}
        if where != "start":
            end = round(axis.end - share * length, 3)
            yield f"To keep it up to {100 * end:.3g} % of the time", {"to": end}
