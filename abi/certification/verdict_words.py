"""Sentences of a verdict besides its first: what was assumed, limits, direction, allowed links."""

from __future__ import annotations

import math
from collections.abc import Sequence

from abi.arm_planning.motion.trajectory import Violation
from abi.certification.verdict import MotionVerdict, words_for
from abi.robot.urdf.urdf_joints import some_of

_UNITS = {
    "position": ("rad", "m"),
    "speed": ("rad/s", "m/s"),
    "acceleration": ("rad/s²", "m/s²"),
    "torque": ("N·m", "N"),
}
"""Unit of a quantity of a turning joint, and of a sliding one."""


def limit_sentences(verdict: MotionVerdict) -> list[str]:
    """A sentence on each limit that the motion passes, or that none is, and on what is not judged.

    Args:
        verdict: on the motion.
    """
    passed = [_limit_sentence(one, verdict) for one in verdict.limits.passed]
    judged = verdict.limits.judged
    unknown = [name for name in verdict.limits.peaks if name not in judged]
    if not passed:
        passed.append(f"The joints keep their limits of {_listed(judged)}.")
    chain = verdict.problem.chain
    for quantity, limits in (("speed", chain.speeds), ("torque", chain.efforts)):
        free = [name for name, most in zip(chain.names, limits, strict=True) if math.isinf(most)]
        if quantity in judged and free:
            passed.append(f"Without a limit of {quantity}: {some_of(free)}.")
    if unknown:
        passed.append(f"Not judged, as motion or robot do not say enough: {_listed(unknown)}.")
    return passed


def direction_sentences(verdict: MotionVerdict) -> list[str]:
    """A sentence on whether the tool keeps its direction; none where the scene asks for none.

    Args:
        verdict: on the motion.
    """
    kept = verdict.direction
    if kept is None:
        return []
    within = f"within {kept.tolerance:g} rad"
    if kept.state == "not judged":
        return [f"Not judged is whether the tool keeps its direction {within}: {kept.why}."]
    assert kept.angle is not None
    assert kept.time is not None
    measured = f"{kept.angle:.3g} rad at {verdict.at(kept.time)}"
    part = f"from {verdict.at(kept.first)} to {verdict.at(kept.last)}"
    if kept.state == "kept":
        return [
            f"The tool keeps its direction {within} {part}, between waypoints, too: measured is at "
            f"most {measured}."
        ]
    where = [f"{verdict.at(first)} to {verdict.at(last)}" for first, last in kept.stretches]
    if kept.state == "left":
        return [
            f"The tool does not keep its direction {within} {part}: it is off by {measured}, and "
            f"by too much from {some_of(where, 3)}."
        ]
    return [
        f"It is not decided whether the tool keeps its direction {within} from "
        f"{some_of(where, 3)}; measured is at most {measured}."
    ]


def remarks(verdict: MotionVerdict) -> list[str]:
    """Sentences on what was assumed, how the file was read, limits, and links that may touch."""
    others = [one for one in verdict.problem.allowed if one.reason in ("srdf", "always", "asked")]
    return [
        f"Assumed: {verdict.assumed}.",
        *verdict.problem.notes,
        *limit_sentences(verdict),
        *direction_sentences(verdict),
        *(f"{one.link} and {words_for(one.other)} may touch ({one.reason})." for one in others),
    ]


def _limit_sentence(one: Violation, verdict: MotionVerdict) -> str:
    """Sentence on a limit that a joint passes."""
    chain = verdict.problem.motion.chain
    unit = _UNITS[one.quantity][chain.slides[chain.names.index(one.joint)]]
    # as many digits as tell the value from its limit
    digits = next((n for n in range(4, 17) if f"{one.value:.{n}g}" != f"{one.limit:.{n}g}"), 17)
    return (
        f"{one.joint} passes its limit of {one.quantity}: {one.value:.{digits}g} {unit} at "
        f"{verdict.at(one.time)}, limit {one.limit:.{digits}g} {unit}."
    )


def _listed(names: Sequence[str]) -> str:
    """Names with an ``and`` before the last."""
    return " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
