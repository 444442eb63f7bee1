"""Capsules of the paper's arm as a certificate has them.

Radii are taken as written; a test, not this check, shows that the capsules contain the links as
drawn. But no link may be missing, none may be free to touch what it must not, and along the axis of
each part of the arm there may be no gap, but for a seam before the gripper.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from abi.verify.certificate import ARM
from abi.verify.exact.paper_arm import Body, ExactArm, ExactCapsule
from abi.verify.fault import Fault
from abi.verify.plan_fields import finite, list_of, mapping

_BODIES: dict[str, Body] = {
    "base_link": "column",
    "turret": "column",
    "upper_arm": "upper_arm",
    "elbow": "forearm",
    "forearm": "forearm",
    "rod": "slide",
    "gripper": "slide",
}
"""Body to which each link is fixed."""

_GAP = Fraction(1, 80)
"""Accepted gap before the gripper's capsules, over the forearm's length, as drawn ones have one."""
_BEGINS = Fraction(2, 5)
"""Least height at which the gripper begins, over the length beyond the sleeve."""
_SAME = Fraction(1, 10**9)
"""Gap that counts as none, over a length."""
_BENT, _ROUNDED = 2.9, 1e-6
"""Largest angle of the elbow, however slender its links are, and accepted error, [rad]."""


def capsules_of(certificate: dict[str, Any], arm: ExactArm, sleeve: Fraction) -> list[ExactCapsule]:
    """Capsules of a certificate, in their order.

    Args:
        certificate: as in a plan's JSON.
        arm: whose it is.
        sleeve: distance of the sleeve's end from the elbow, [unit].

    Raises:
        SceneError: a field has the wrong form.
        Fault: the capsules leave out a part of the arm, or what one of them has to keep clear of.
    """
    field = f"{ARM}.capsules"
    capsules = [
        _capsule(mapping(field, one), arm) for one in list_of(field, certificate.get("capsules"))
    ]
    begins = sleeve + _BEGINS * (arm.lower - sleeve)
    if any(one.link == "gripper" and one.low < begins for one in capsules):
        raise Fault("its gripper begins too near to the elbow")
    held = {one.link for one in capsules if not one.neighbour and not one.grips}
    for link in _BODIES:
        if link not in held:
            raise Fault(f"{link} has no capsule")
    parts: tuple[tuple[str, tuple[Body, ...], Fraction], ...] = (
        ("column", ("column",), arm.height),
        ("upper arm", ("upper_arm",), arm.upper),
        ("forearm", ("forearm", "slide"), arm.lower),
    )
    for name, bodies, length in parts:
        if not _cover([one for one in capsules if one.body in bodies], length):
            raise Fault(f"its capsules leave a gap along the {name}")
    return capsules


def _capsule(data: dict[str, Any], arm: ExactArm) -> ExactCapsule:
    link, body = data.get("link"), data.get("body")
    names = ("low", "high", "radius")
    low, high, radius = (Fraction(finite(f"{ARM}.capsules.{one}", data.get(one))) for one in names)
    known = isinstance(link, str) and link in _BODIES and body == _BODIES[link]
    if not isinstance(link, str) or not known or low > high or radius <= 0:
        raise Fault("a capsule has no link, or no extent")
    neighbour, grips = data.get("neighbour") is True, data.get("grips") is True
    # the half of the upper arm at the shoulder; the fingers
    beside = body == "upper_arm" and 2 * high <= arm.upper
    if (neighbour and not beside) or (grips and link != "gripper"):
        raise Fault(f"{link} is said to be free to touch what it must not")
    return ExactCapsule(link, _BODIES[link], low, high, radius, neighbour, grips)


def _cover(capsules: Sequence[ExactCapsule], length: Fraction) -> bool:
    """Check whether capsules cover an axis from 0 to a length, but for the gripper's seam."""
    reached, left = Fraction(0), _GAP * length
    spans = ((one.low - one.radius, one.high + one.radius, one.link) for one in capsules)
    for first, last, link in sorted(spans):
        gap = max(min(first, length) - reached, Fraction(0))
        if link != "gripper" and gap > _SAME * length:
            return False
        left -= gap
        reached = max(reached, last)
    return left >= 0 and reached >= length


def check_bend(
    rows: Sequence[Sequence[float]], capsules: Sequence[ExactCapsule], sleeve: Fraction
) -> None:
    """Raise where the elbow bends so far that a rod beyond its sleeve may touch the upper arm.

    At an angle over 90 degrees a point of the forearm at s from the elbow is s sin q3 away from the
    axis of the upper arm.

    Args:
        rows: joint positions, (m, 6).
        capsules: all of the arm.
        sleeve: distance of the sleeve's end from the elbow, [unit].

    Raises:
        Fault: at a sample it does.
    """
    upper = max(one.radius for one in capsules if one.body == "upper_arm")
    sines = [
        (upper + one.radius) / max(one.low, sleeve)
        for one in capsules
        if one.body in ("forearm", "slide") and (one.high > sleeve or one.link == "forearm")
    ]
    most = min(_BENT, math.pi - math.asin(min(1.0, float(max(sines))))) + _ROUNDED
    if any(abs(row[2]) > most for row in rows):
        raise Fault(
            f"its elbow bends by more than {most:.4g} rad, and forearm and upper arm may touch"
        )
