"""Directions that separate an arm's capsules from its surroundings near a pose, for every arm.

See ``abi.arm.arm_certificate`` for what a direction proves, ``abi.arm.surroundings_kernels`` for
the surroundings, ``abi.clearance.separation_kernels`` for planes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeVar

from numba.extending import register_jitable

from abi.arm.direction_kernels import Direction, is_separated, keep_direction
from abi.arm.surroundings_kernels import Obstacles, between_boxes, is_solid, judged, open_box
from abi.clearance.separation_kernels import CERTIFIED, REFUTED, UNDECIDED, Plane
from abi.obstacles.primitive_kernels import axes_of, centre_of, core_of, in_body, in_world
from abi.obstacles.vector_kernels import Vec3, dot, sub

ALLOWANCE = 2.0**-40
"""Part of the largest coordinate, for each place computed."""
FINEST = 2.0**-26
"""Part of the largest coordinate: pieces with a smaller way are not halved."""

_Arm = TypeVar("_Arm")


class Moving(NamedTuple):
    """A capsule at a pose, and how far from there it may be.

    Attributes:
        number: of the capsule.
        first, last: ends of its segment, [unit], world.
        radius: [unit].
        way: of every point of it, at most, [unit].
    """

    number: int
    first: Vec3
    last: Vec3
    radius: float
    way: float


class Lists(NamedTuple):
    """Lists that a proof fills; a pair is capsule times number of obstacles, plus obstacle.

    Attributes:
        planes: the directions found.
        candidates: pairs, those of every pending piece, a piece's own together.
        work: pairs of the present piece, the next one last.
        latest: directions that may serve for the next pair, too.
    """

    planes: list[Plane]
    candidates: list[int]
    work: list[int]
    latest: list[Direction]


@register_jitable(forceinline=True)
def _separated(
    around: Obstacles, s: int, capsule: Moving, allowance: float
) -> tuple[int, float, Vec3]:
    """Check whether a direction keeps a capsule clear of row s, or of the floor, near a pose.

    Returns:
        CERTIFIED, REFUTED at the pose or UNDECIDED; the distance there; the direction.
    """
    a, b, radius = capsule.first, capsule.last, capsule.radius
    near = radius + around.margins[s] - allowance
    far = around.margins[s] + (radius + allowance + capsule.way)
    if s == len(around.margins) - 1:
        gap, way = min(a[2], b[2]) - around.floor, (0.0, 0.0, 1.0)
        outcome = CERTIFIED if gap > far else REFUTED if gap < near else UNDECIDED
        return outcome, gap - radius, way
    gap, way = between_boxes(around.primitives, s, a, b)
    if gap > far:
        return CERTIFIED, gap - radius, way
    axes = axes_of(around.primitives, s)
    p = in_body(axes, sub(a, centre_of(around.primitives, s)))
    d = in_body(axes, sub(b, a))
    outcome, gap, way = judged(core_of(around.primitives, s), p, d, near, far)
    return outcome, gap - radius, in_world(axes, way)


@register_jitable(forceinline=True)
def separate_pairs(
    around: Obstacles,
    piece: tuple[float, float, float],
    allowance: float,
    bounded: bool,
    lists: Lists,
    capsule_of: Callable[[_Arm, int], Moving],
    arm: _Arm,
) -> tuple[int, int, float, int, float]:
    """Separate the pairs of ``lists.work`` on a piece; those that are left become candidates.

    Args:
        around: what to keep clear of.
        piece: its first and last parameter, and that of the pose.
        allowance: for rounding, [unit].
        bounded: whether the ways are bounded on the piece, and joints keep their limits.
        lists: written.
        capsule_of: a capsule of the arm, by its number.
        arm: the arm near the pose.

    Returns:
        REFUTED or UNDECIDED; the pair and the distance that refute it; how many were tried; the
        largest way of a capsule that is left, [unit].
    """
    count, (start, end, at) = len(around.margins), piece
    planes, candidates, work, latest = lists
    capsule = capsule_of(arm, 0)
    left, tries, farthest = -1, 0, 0.0
    while len(work) > 0:
        pair = work.pop()
        tries += 1
        s = pair % count
        if pair // count != capsule.number:
            capsule = capsule_of(arm, pair // count)
            latest.clear()
            left = -1
        if is_separated(around, s, latest):
            continue
        if left >= 0 and around.meshes[s] == left:
            candidates.append(pair)
            continue
        outcome, away, way = _separated(around, s, capsule, allowance)
        if outcome == REFUTED and is_solid(around, pair):
            return REFUTED, pair, away, tries, farthest
        if bounded and outcome == CERTIFIED:
            planes.append(Plane(start, end, pair, way, at))
            if around.meshes[s] >= 0:
                level = min(dot(way, capsule.first), dot(way, capsule.last))
                level -= capsule.radius + allowance + capsule.way
                keep_direction(latest, way, level, around.meshes[s])
        elif not open_box(around, pair, capsule.way, (capsule.first, capsule.last), work):
            candidates.append(pair)
            farthest = max(farthest, capsule.way)
            # the piece is halved anyhow: the rest of the mesh is as good tried on its halves
            left = around.meshes[s] + 0
    return UNDECIDED, -1, 0.0, tries, farthest
