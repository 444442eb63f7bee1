"""Solids with which the paper's arm is drawn, sized by its link lengths.

A pedestal carries a turret with a fork; the upper arm tapers from the shoulder to the elbow; a
second fork carries the sleeve of the forearm, in which a rod slides with a wrist and a gripper.
Each link's frame is that of its joint, z along the link, x along the axes of q2 and q3.
"""

from __future__ import annotations

import math

from abi.obstacles.pose import Vec3
from abi.robot.bodies.link_solid import LinkSolid

COLOURS: dict[str, Vec3] = {
    "shell": (0.87, 0.88, 0.90),
    "joint": (0.27, 0.29, 0.33),
    "steel": (0.60, 0.63, 0.67),
    "accent": (0.05, 0.60, 0.66),
}
"""Colours by use; each is visible on white and on near-black."""

_ALONG_X: Vec3 = (0.0, math.pi / 2, 0.0)

_WRIST = 0.4
"""Height of the wrist's roll, q6, above the end of the sleeve at q5 = 0, as a share of a5."""


def links(
    a1: float, a2: float, a3: float, a4: float, a5: float
) -> dict[str, tuple[LinkSolid, ...]]:
    """Solids of each link, from the floor to the tool.

    Args:
        a1: height of q1 above the floor, [m].
        a2: height of the shoulder above q1, [m].
        a3: length of the upper arm, [m].
        a4: length of the forearm's sleeve, [m].
        a5: length from the sleeve's end to the tool at q5 = 0, [m].

    Returns:
        base_link, turret, upper_arm, elbow, forearm, rod, gripper and the frame tool.
    """
    shoulder, elbow = radii(a1, a2, a3, a4, a5)
    roll = _roll(elbow, a4)
    grip = min(0.6 * elbow, 0.3 * a5)  # half of the gripper's width
    return {
        "base_link": _base(shoulder, a1),
        "turret": _turret(shoulder, elbow, a2),
        "upper_arm": _upper_arm(shoulder, elbow, a3),
        "elbow": _elbow(elbow, roll),
        "forearm": _forearm(elbow, a4 - roll),
        "rod": _rod(elbow, grip, a4, a5),
        "gripper": _gripper(grip, a5),
        "tool": (),
    }


def joint_heights(a1: float, a2: float, a3: float, a4: float, a5: float) -> tuple[float, ...]:
    """Height of each joint, q1 to q6, and of the tool in the frame of the joint before it, [m]."""
    roll, wrist = _roll(radii(a1, a2, a3, a4, a5)[1], a4), _WRIST * a5
    return a1, a2, a3, roll, a4 - roll, wrist, a5 - wrist


def radii(a1: float, a2: float, a3: float, a4: float, a5: float) -> tuple[float, float]:
    """Radii of the shoulder, q2, and of the elbow, q3, so that neighbours fit each other.

    The widths of all links are multiples of these, whatever the link lengths (all > 0).
    """
    hub = min(0.062 * (a3 + a4 + a5), 0.27 * (a1 + a2), 0.3 * a3)
    elbow = min(0.8 * hub, 0.24 * (a4 + a5))
    return min(hub, 1.8 * elbow), elbow


def _roll(elbow: float, a4: float) -> float:
    """Height of the forearm's roll, q4, above the elbow."""
    return min(1.75 * elbow, 0.7 * a4)


def _base(shoulder: float, a1: float) -> tuple[LinkSolid, ...]:
    s = shoulder
    plate = min(0.22 * s, 0.25 * a1)
    step = plate + 0.45 * (a1 - plate)
    bolts = tuple(
        _column(
            0.1 * s,
            plate,
            1.3 * plate,
            "steel",
            (1.63 * s * math.cos(angle), 1.63 * s * math.sin(angle)),
            body=False,
        )
        for angle in (math.pi / 6 + k * math.pi / 3 for k in range(6))
    )
    return (
        _column(1.8 * s, 0.0, plate, "joint"),
        _column(1.5 * s, plate, step, "shell"),
        _column(1.42 * s, step, a1 - 0.12 * plate, "shell"),
        _column(1.3 * s, a1 - 0.12 * plate, a1 + 0.3 * plate, "joint", body=False),
        *bolts,
    )


def _turret(shoulder: float, elbow: float, a2: float) -> tuple[LinkSolid, ...]:
    s = shoulder
    seam = min(0.06 * s, 0.05 * a2)
    top = max(a2 - 1.15 * s, 0.3 * a2)
    ring = min(0.12 * s, 0.2 * top)
    inner, outer = _fork(elbow)
    cheeks = tuple(
        _block((outer - inner, 1.88 * s), 0.5 * top, a2, side * (inner + outer) / 2, "shell")
        for side in (-1, 1)
    )
    return (
        _column(1.42 * s, seam, top - 1.6 * ring, "shell"),
        _column(1.37 * s, top - 1.6 * ring, top - ring, "accent", body=False),
        _column(1.42 * s, top - ring, top, "shell"),
        *cheeks,
        *_hinge(elbow, 0.94 * s, a2),
    )


def _upper_arm(shoulder: float, elbow: float, a3: float) -> tuple[LinkSolid, ...]:
    lower, upper = 0.88 * shoulder, 0.9 * elbow
    half = 0.55 * elbow
    length = a3 - 1.25 * shoulder - 1.5 * elbow
    middle = 1.25 * shoulder + length / 2
    sides = tuple(
        LinkSolid(
            "box",
            (0.08 * half, 0.62 * elbow, length),
            "joint",
            (side * half, 0.0, middle),
            body=False,
        )
        for side in (-1, 1)
    )
    return (
        _disc(lower, -1.04 * half, 1.04 * half, 0.0, "joint"),
        _disc(upper, -1.04 * half, 1.04 * half, a3, "joint"),
        *_belt(lower, upper, a3, -half, half, "shell"),
        *sides,
    )


def _elbow(elbow: float, roll: float) -> tuple[LinkSolid, ...]:
    e, top = elbow, roll
    inner, outer = _fork(e)
    floor = 0.62 * top
    seam = min(0.07 * e, 0.1 * top)
    narrow = max(0.72 * e, 0.94 * e - 0.5 * floor)
    return (
        *_belt(0.94 * e, narrow, floor, inner, outer, "shell"),
        *_belt(0.94 * e, narrow, floor, -outer, -inner, "shell"),
        *_hinge(e, 0.94 * e, 0.0),
        _column(1.2 * e, floor, top - seam, "shell"),
        _column(1.04 * e, top - seam, top + seam, "joint", body=False),
    )


def _forearm(elbow: float, length: float) -> tuple[LinkSolid, ...]:
    e = elbow
    collar = min(0.34 * e, 0.3 * length)
    ring = 0.3 * collar
    foot = min(0.07 * e, 0.1 * length)
    step = 0.42 * (length - collar)
    return (
        _column(1.06 * e, foot, step, "shell"),
        _column(0.9 * e, step, length - collar - ring, "shell"),
        _column(0.84 * e, length - collar - ring, length - collar, "accent", body=False),
        _column(0.95 * e, length - collar, length, "joint"),
    )


def _rod(elbow: float, grip: float, a4: float, a5: float) -> tuple[LinkSolid, ...]:
    # The rod's tail stays in the sleeve at the largest extension, 0.8·a4.
    e, wrist = elbow, _WRIST * a5
    ring = 0.16 * wrist
    return (
        _column(0.46 * e, -0.88 * a4, 0.2 * wrist, "steel"),
        _column(0.82 * grip, 0.2 * wrist, wrist - ring, "shell"),
        _column(0.74 * grip, wrist - ring, wrist, "joint", body=False),
    )


def _gripper(grip: float, a5: float) -> tuple[LinkSolid, ...]:
    g, length = grip, a5 - _WRIST * a5
    plate, palm, knuckle = 0.1 * length, 0.32 * length, 0.62 * length
    bend = knuckle + 0.06 * length
    # slender at the tool, which may pass an obstacle at little more than the clearance
    fingers = tuple(
        solid
        for side in (-1, 1)
        for solid in (
            _block((0.26 * g, 0.5 * g), palm, knuckle, side * 0.55 * g, "accent"),
            _block(
                (0.6 * g, 0.42 * g),
                0.94 * knuckle,
                bend,
                side * 0.38 * g,
                "joint",
            ),
            _block((0.16 * g, 0.3 * g), knuckle, length, side * 0.14 * g, "accent"),
        )
    )
    return (
        _column(0.86 * g, 0.02 * length, plate, "shell"),
        _block((2.1 * g, 0.95 * g), plate, palm, 0.0, "joint"),
        *fingers,
    )


def _fork(elbow: float) -> tuple[float, float]:
    """Inner and outer distance of a fork's cheeks from the plane of the arm."""
    return 0.62 * elbow, 0.98 * elbow


def _hinge(elbow: float, radius: float, z: float) -> tuple[LinkSolid, ...]:
    """A fork's rounded ends about the x axis at height ``z``, an accent ring and a dark cap."""
    inner, outer = _fork(elbow)
    boss, ring, cap = outer + 0.05 * radius, outer + 0.1 * radius, outer + 0.22 * radius
    return (
        _disc(radius, inner, boss, z, "shell"),
        _disc(radius, -boss, -inner, z, "shell"),
        _disc(0.74 * radius, -ring, ring, z, "accent", body=False),
        _disc(0.62 * radius, -cap, cap, z, "joint", body=False),
    )


def _belt(
    lower: float, upper: float, length: float, left: float, right: float, material: str
) -> tuple[LinkSolid, ...]:
    """A plate between discs at z = 0 and z = length, bounded by their common tangents.

    Each box has one edge on a tangent; together with the discs they fill the hull exactly.
    ``upper`` <= ``lower`` <= 2·``upper``.
    """
    lean = math.asin((lower - upper) / length)
    run = length * math.cos(lean)
    # Wide enough to pass the middle at the wide end, narrow enough to stay in the narrow disc.
    width = min(max(lower, upper), 2 * upper)
    boxes = []
    for side in (-1, 1):
        along = (side * -math.sin(lean), math.cos(lean))
        normal = (side * math.cos(lean), math.sin(lean))
        y = lower * normal[0] + run / 2 * along[0] - width / 2 * normal[0]
        z = lower * normal[1] + run / 2 * along[1] - width / 2 * normal[1]
        boxes.append(
            LinkSolid(
                "box",
                (right - left, width, run),
                material,
                ((left + right) / 2, y, z),
                (side * lean, 0.0, 0.0),
            )
        )
    return tuple(boxes)


def _disc(
    radius: float, left: float, right: float, z: float, material: str, *, body: bool = True
) -> LinkSolid:
    """A cylinder about the x axis at height ``z``, from x = left to right."""
    size = (radius, radius, right - left)
    return LinkSolid("cylinder", size, material, ((left + right) / 2, 0.0, z), _ALONG_X, body)


def _column(
    radius: float,
    low: float,
    high: float,
    material: str,
    centre: tuple[float, float] = (0.0, 0.0),
    *,
    body: bool = True,
) -> LinkSolid:
    """An upright cylinder from z = low to high."""
    size = (radius, radius, high - low)
    return LinkSolid("cylinder", size, material, (*centre, (low + high) / 2), body=body)


def _block(
    size: tuple[float, float], low: float, high: float, x: float, material: str
) -> LinkSolid:
    """A box of that size in x and y, about (x, 0), from z = low to high."""
    return LinkSolid("box", (*size, high - low), material, (x, 0.0, (low + high) / 2))
