"""Sentences on what an arm's motion lacks: reach, clearance, limits, a proof."""

from __future__ import annotations

import math
from collections.abc import Sequence

from abi.arm_planning.motion.trajectory import ArmMotion, Violation
from abi.arm_planning.motion_law import LAWS
from abi.length_text import with_minus
from abi.planner.arm_words import clearance_sentence, contact_sentence
from abi.planner.plan import Plan

CONTACTS = 3
"""Most contacts that are listed one by one."""
_CURVES = {"bspline": "B-spline", "quadratic": "quadratic"}


def arm_faults(plan: Plan) -> list[str]:
    """Sentences on what the arm's motion lacks, the worst first.

    Empty where the whole arm is proven clear along a curve that is, and where nothing moves.
    """
    motion, clearance, unit = plan.motion, plan.arm_clearance, plan.scene.unit
    if motion is None or clearance is None:
        return []
    faults = []
    if (error := motion.error) is not None:
        faults.append(error.in_unit(unit).message)
    faults += [f"{contact_sentence(one, unit)}." for one in clearance.contacts[:CONTACTS]]
    if len(clearance.contacts) > CONTACTS:
        faults.append(f"There are {len(clearance.contacts)} contacts in all.")
    if plan.followed_curve is not None and not plan.followed_curve.holds:
        name = _CURVES[plan.followed or ""]
        faults.append(f"The {name}, which the arm follows, is too near an obstacle.")
    faults += [limit_sentence(one, motion, unit) for one in motion.limit_violations]
    if motion.reachable and not clearance.certified and not clearance.contacts:
        faults.append(clearance_sentence(plan))
    return faults


def arm_warning(plan: Plan) -> str:
    """The worst of these faults as one sentence for the operator; empty for none."""
    contacts = () if plan.arm_clearance is None else plan.arm_clearance.contacts
    if plan.motion is None or not contacts or not plan.motion.reachable:
        return next(iter(arm_faults(plan)), "")
    others = f", the deepest of {len(contacts)} contacts" if len(contacts) > 1 else ""
    return f"{contact_sentence(contacts[0], plan.scene.unit)}{others}."


def limits_warning(plan: Plan) -> str:
    """The worst speed, acceleration or torque beyond its limit, and its remedy; or empty."""
    passed = [one for one in plan.limits_passed if one.quantity != "position"]
    if plan.motion is None or not passed:
        return ""
    worst = _worst(passed)
    others = f" {len(passed)} limits are passed in all." if len(passed) > 1 else ""
    hint = "Lower motion.joint_acceleration or motion.speed."
    if not LAWS[plan.scene.motion.law].keeps_limits:
        hint = "motion.law: slowed keeps the joints' speeds and accelerations."
    return f"{limit_sentence(worst, plan.motion, plan.scene.unit)}{others} {hint}"


def worst_limit(plan: Plan) -> Violation | None:
    """The worst limit that is exceeded, positions before all others; None for none."""
    passed = plan.limits_passed
    positions = [one for one in passed if one.quantity == "position"]
    return positions[0] if positions else _worst(passed) if passed else None


def _worst(passed: Sequence[Violation]) -> Violation:
    """The limit exceeded most: the drives' own limits before the requested acceleration."""
    return max(passed, key=lambda one: (one.quantity != "acceleration", one.value / one.limit))


def limit_sentence(violation: Violation, motion: ArmMotion, unit: str) -> str:
    """Sentence on the time and the worst value of a joint beyond its limit."""
    slides = motion.slides[motion.joints.index(violation.joint)]
    value, limit = (
        _quantity(number, violation.quantity, unit if slides else "")
        for number in (violation.value, violation.limit)
    )
    kind = "" if violation.quantity == "position" else f"{violation.quantity} "
    return (
        f"{violation.joint} passes its {kind}limit of {limit} at {violation.since:.2f} s: "
        f"{value} at {violation.time:.2f} s."
    )


def _quantity(number: float, quantity: str, unit: str) -> str:
    """A joint's value; ``unit`` is that of lengths if the joint slides, else empty."""
    if quantity == "position":
        return with_minus(f"{number:.2f} {unit}" if unit else f"{math.degrees(number):.0f}°")
    text = with_minus(f"{number:.3g}" if abs(number) < 1000 else f"{number:.0f}")
    if quantity == "torque":
        return f"{text} {'N' if unit else 'N·m'}"
    return f"{text} {unit or 'rad'}/s{'²' if quantity == 'acceleration' else ''}"
