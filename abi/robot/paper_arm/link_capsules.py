"""Capsules that contain the links of the paper's arm as it is drawn.

Each lies along the axis of its link, so that the rolls q4 and q6 do not move it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from abi.robot.bodies.link_solid import LinkSolid, corners
from abi.robot.paper_arm import arm_links

COLUMN, UPPER_ARM, FOREARM, SLIDE = range(4)
"""Bodies that capsules are fixed to: the column, and those that q2, q3 and q5 move."""
BODIES = ("column", "upper_arm", "forearm", "slide")
"""Their names."""

_GROWTH = 1.06
"""Radius of a capsule over the least possible; a larger one has flatter caps and is shorter."""

_FINGERS = 2
"""Index of the gripper's first finger among its solids; each finger has three parts."""


@dataclass(frozen=True)
class LinkCapsule:
    """All points within ``radius`` of a segment of its body's z axis.

    Attributes:
        link: name of the link in the URDF.
        body: to which it is fixed: ``COLUMN``, ``UPPER_ARM``, ``FOREARM`` or ``SLIDE``.
        low: where the segment begins, above the floor, the shoulder, or, of the last two, above the
            elbow at q5 = 0, [unit].
        high: where it ends, at least ``low``, [unit].
        radius: [unit].
        neighbour: whether it may touch the column because a joint connects them.
        grips: whether it is at the tool, which may touch the floor.
    """

    link: str
    body: int
    low: float
    high: float
    radius: float
    neighbour: bool = False
    grips: bool = False


@lru_cache(maxsize=64)
def link_capsules(a1: float, a2: float, a3: float, a4: float, a5: float) -> tuple[LinkCapsule, ...]:
    """Capsules of all links, fixed ones first.

    Together the two of the upper arm are one capsule; the first may touch the column.

    Args:
        a1, a2, a3, a4, a5: lengths as for :func:`abi.robot.paper_arm.arm_links.links`, [unit].
    """
    _, _, _, roll, _, above_sleeve, _ = arm_links.joint_heights(a1, a2, a3, a4, a5)
    solids = arm_links.links(a1, a2, a3, a4, a5)
    gripper, wrist = solids["gripper"], a4 + above_sleeve
    fingers = gripper[_FINGERS:]
    low, high, radius = _bounding_capsule(solids["upper_arm"], 0.0)
    middle = (low + high) / 2
    return (
        LinkCapsule("base_link", COLUMN, *_bounding_capsule(solids["base_link"], 0.0)),
        LinkCapsule("turret", COLUMN, *_bounding_capsule(solids["turret"], a1)),
        LinkCapsule("upper_arm", UPPER_ARM, low, middle, radius, neighbour=True),
        LinkCapsule("upper_arm", UPPER_ARM, middle, high, radius),
        LinkCapsule("elbow", FOREARM, *_bounding_capsule(solids["elbow"], 0.0)),
        LinkCapsule("forearm", FOREARM, *_bounding_capsule(solids["forearm"], roll)),
        LinkCapsule("rod", SLIDE, *_bounding_capsule(solids["rod"], a4)),
        LinkCapsule("gripper", SLIDE, *_bounding_capsule(gripper[:_FINGERS], wrist)),
        LinkCapsule("gripper", SLIDE, *_bounding_capsule([*fingers[0::3], *fingers[1::3]], wrist)),
        LinkCapsule("gripper", SLIDE, *_bounding_capsule(fingers[2::3], wrist), grips=True),
    )


def steepest_bend(capsules: Sequence[LinkCapsule], a4: float) -> float:
    """Largest angle q3 at which forearm and upper arm do not touch beyond the elbow, [rad].

    At an angle over 90° a point of the forearm's axis at s from the elbow is s·sin q3 away from the
    axis of the upper arm. What is nearer to the elbow than the sleeve's end may touch.

    Args:
        capsules: all of the arm.
        a4: distance of the sleeve's end from the elbow, [unit].
    """
    upper = max(capsule.radius for capsule in capsules if capsule.body == UPPER_ARM)
    sines = [
        (upper + capsule.radius) / max(capsule.low, a4)
        for capsule in capsules
        if capsule.body in (FOREARM, SLIDE) and capsule.high > a4
    ]
    sleeve = max(capsule.radius for capsule in capsules if capsule.link == "forearm")
    return math.pi - math.asin(min(1.0, max([*sines, (upper + sleeve) / a4])))


def _bounding_capsule(solids: Sequence[LinkSolid], height: float) -> tuple[float, float, float]:
    """Low and high end on the z axis and radius of a capsule around solids, [unit].

    Args:
        solids: at least one, in the link's frame.
        height: of the link's frame in the body's, [unit].
    """
    points = np.concatenate([corners(solid) for solid in solids])
    radial = np.hypot(points[:, 0], points[:, 1])
    radius = _GROWTH * float(radial.max())
    cap = np.sqrt(radius**2 - radial**2)
    low, high = float((points[:, 2] + cap).min()), float((points[:, 2] - cap).max())
    if low > high:  # flat: any centre between them would do
        low = high = (low + high) / 2
    pad = 1e-9 * (radius + abs(low) + abs(high))
    return height + low, height + high, radius + pad
