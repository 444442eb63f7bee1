"""Sentences of a verdict besides its first: what was assumed, limits, and links that may touch."""

from __future__ import annotations

from collections.abc import Sequence

from abi.certification.joint_limits import LimitPassed
from abi.certification.verdict import MotionVerdict

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
    unknown = [name for name, peak in verdict.limits.peaks.items() if peak is None]
    judged = [name for name, peak in verdict.limits.peaks.items() if peak is not None]
    if not passed:
        passed.append(f"The joints keep their limits of {_listed(judged)}.")
    if unknown:
        passed.append(f"Not judged, as motion or robot do not say enough: {_listed(unknown)}.")
    return passed


def remarks(verdict: MotionVerdict) -> list[str]:
    """Sentences on what was assumed, how the file was read, limits, and links that may touch."""
    others = [one for one in verdict.problem.bodies.allowed if one.reason in ("srdf", "always")]
    return [
        f"Assumed: {verdict.assumed}.",
        *verdict.problem.motion.notes,
        *limit_sentences(verdict),
        *(f"{one.link} and {one.other} may touch ({one.reason})." for one in others),
    ]


def _limit_sentence(one: LimitPassed, verdict: MotionVerdict) -> str:
    """Sentence on a limit that a joint passes."""
    chain = verdict.problem.motion.chain
    unit = _UNITS[one.quantity][chain.slides[chain.names.index(one.joint)]]
    return (
        f"{one.joint} passes its limit of {one.quantity}: {one.value:.4g} {unit} at "
        f"{verdict.at(one.time)}, limit {one.limit:.4g} {unit}."
    )


def _listed(names: Sequence[str]) -> str:
    """Names with an ``and`` before the last."""
    return " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
