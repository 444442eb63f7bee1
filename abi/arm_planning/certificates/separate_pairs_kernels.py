"""Directions that separate an arm's capsules from its surroundings near a pose, for every arm.

See ``abi.curves.clearance.certificate.Certificate`` for what a direction proves,
``abi.arm_planning.world.collision_world_kernels`` for the surroundings,
``abi.curves.clearance.separation_kernels`` for planes. A direction from one part of a mesh is tried
for the parts next to it. What decides most pairs is always inlined, because passing arrays costs
reference counting.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeVar

from abi.arm_planning.world.collision_world_kernels import (
    Obstacles,
    between_boxes,
    is_solid,
    judged,
    open_box,
)
from abi.compilation.jitable import jitable
from abi.curves.clearance.separation_kernels import (
    CERTIFIED,
    REFUTED,
    UNDECIDED,
    ProofLists,
    SeparatingPlane,
)
from abi.obstacles.primitive_kernels import axes_of, centre_of, core_of, in_body, in_world, support
from abi.obstacles.vector_kernels import Vec3, dot, sub

_LATEST = 8


@jitable(forceinline=True)
def is_separated(around: Obstacles, s: int, latest: list[SeparatingPlane]) -> bool:
    """Check whether a plane found lately separates a capsule from the part of a mesh in row s.

    Near triangles have one in common with those beside and behind them.
    """
    separated: bool = around.meshes[s] >= 0 and len(latest) > 0 and _is_beyond(around, s, latest)
    return separated


@jitable(forceinline=True)
def _is_beyond(around: Obstacles, s: int, latest: list[SeparatingPlane]) -> bool:
    """Check whether one of the kept planes has the part of a mesh in row s beyond it, too."""
    mesh = around.meshes[s]
    axes, core = axes_of(around.primitives, s), core_of(around.primitives, s)
    centre, margin = centre_of(around.primitives, s), around.margins[s]
    for k in range(len(latest) - 1, -1, -1):
        known = latest[k]
        if known.obstacle == mesh:
            way = known.direction
            reached = dot(way, centre) + support(core, in_body(axes, way))
            if reached < known.level - margin:
                return True
    return False


@jitable(forceinline=True)
def keep_plane(latest: list[SeparatingPlane], plane: SeparatingPlane) -> None:
    """Add a plane between a capsule and parts of a mesh to the latest, of which the oldest go."""
    if len(latest) == _LATEST:
        latest.pop(0)
    latest.append(plane)


ALLOWANCE = 2.0**-40
"""Rounding of each place computed, as a part of the largest coordinate."""
LONGER = 1 + 2.0**-50
"""Factor of a distance between places that makes up for its rounding."""
FINEST = 2.0**-26
"""Part of the largest coordinate: pieces with a smaller way are not halved."""

_Arm = TypeVar("_Arm")
Found = tuple[int, float, Vec3]
"""An outcome, a distance and a direction."""


class Moving(NamedTuple):
    """A capsule at a pose, with bounds of the displacement of its points on a piece of a motion.

    Attributes:
        number: of the capsule.
        first, last: ends of its segment, [unit], world.
        radius: [unit].
        way: of every point of it, at most, [unit].
        bow: farthest that its points are from straight ways between the ends of the piece, [unit];
            inf where that is not known.
    """

    number: int
    first: Vec3
    last: Vec3
    radius: float
    way: float
    bow: float


class Span(NamedTuple):
    """A piece of a motion, and the pose in it around which a proof holds.

    Attributes:
        start, end, at: its first and last parameter, and that of the pose.
        allowance: for rounding, [unit].
        bounded: whether the ways are bounded on the piece, and joints keep their limits.
        keeps: whether planes are wanted.
    """

    start: float
    end: float
    at: float
    allowance: float
    bounded: bool
    keeps: bool


@jitable(forceinline=True)
def _level(
    allowance: float,
    capsule: Moving,
    way: Vec3,
    level_at_ends: Callable[[_Arm, Moving, Vec3], float],
    arm: _Arm,
) -> float:
    """Level of a plane that is to separate a capsule all along a piece, [unit]."""
    level = min(dot(way, capsule.first), dot(way, capsule.last)) - capsule.way
    if capsule.bow < capsule.way:
        level = max(level, level_at_ends(arm, capsule, way) - capsule.bow)
    return level - capsule.radius - allowance


@jitable(forceinline=True)
def _separated(
    around: Obstacles,
    s: int,
    allowance: float,
    capsule: Moving,
    level_at_ends: Callable[[_Arm, Moving, Vec3], float],
    arm: _Arm,
) -> tuple[int, float, Vec3]:
    """Check whether a direction keeps a capsule clear of row s, or of the floor, near a pose.

    Returns:
        CERTIFIED, REFUTED at the pose or UNDECIDED; the distance there; the direction.
    """
    a, b, radius = capsule.first, capsule.last, capsule.radius
    need = radius + around.margins[s]
    near, far = need - allowance, need + allowance + capsule.way
    if s == len(around.margins) - 1:
        gap, way = min(a[2], b[2]) - around.floor, (0.0, 0.0, 1.0)
        outcome = CERTIFIED if gap > far else REFUTED if gap < near else UNDECIDED
        return outcome, gap - radius, way
    gap, way = between_boxes(around.primitives, s, a, b)
    if gap > far:
        return CERTIFIED, gap - radius, way
    axes, core = axes_of(around.primitives, s), core_of(around.primitives, s)
    centre = centre_of(around.primitives, s)
    p, d = in_body(axes, sub(a, centre)), in_body(axes, sub(b, a))
    outcome, gap, way = judged(core, p, d, near, min(far, need + allowance + capsule.bow))
    there = in_world(axes, way)
    if outcome == CERTIFIED and gap <= far:
        reached = support(core, way) + dot(there, centre) + around.margins[s]
        if reached >= _level(allowance, capsule, there, level_at_ends, arm):
            outcome = UNDECIDED
    return outcome, gap - radius, there


@jitable(forceinline=True)
def separate_pairs(
    around: Obstacles,
    span: Span,
    lists: ProofLists,
    latest: list[SeparatingPlane],
    capsule_of: Callable[[_Arm, int], Moving],
    level_at_ends: Callable[[_Arm, Moving, Vec3], float],
    refined: Callable[[_Arm, Obstacles, int, int, float, Found], tuple[bool, Found]],
    arm: _Arm,
) -> tuple[int, int, float, tuple[int, int], float]:
    """Separate the pairs of ``lists.work`` on a piece; those that are left become candidates.

    Where a capsule has a bow, a direction n is tried at both ends of the piece, too.

    Args:
        around: what to keep clear of.
        span: the piece.
        lists: written; a pair is capsule times number of obstacles, plus obstacle.
        latest: planes that may serve for the next pair, too, by numbers of meshes; room.
        capsule_of: a capsule of the arm, by its number.
        level_at_ends: least n·P over the points P of a capsule's segment at both ends of the piece.
        refined: what is found of a closer body than a capsule, by the number of this, the row, the
            allowance and what was found of the capsule; and whether that is of the closer body.
        arm: the arm near the pose.

    Returns:
        REFUTED or UNDECIDED; the pair and the distance that refute it; how many were tried, and how
        many could be left out; the largest way of a capsule that is left, [unit].
    """
    count, (start, end, at, allowance, bounded, keeps) = len(around.margins), span
    planes, candidates, work = lists.planes, lists.candidates, lists.work
    latest.clear()
    capsule = capsule_of(arm, 0)
    left, tries, spared, farthest = -1, 0, 0, 0.0
    while len(work) > 0:
        pair = work.pop()
        s = pair % count
        if pair // count != capsule.number:
            capsule = capsule_of(arm, pair // count)
            latest.clear()
            left = -1
        if is_separated(around, s, latest):
            spared += 1
            continue
        if left >= 0 and around.meshes[s] == left:
            spared += 1
            candidates.append(pair)
            continue
        tries += 1
        found = _separated(around, s, allowance, capsule, level_at_ends, arm)
        closer = False
        if found[0] != CERTIFIED and is_solid(around, pair):
            closer, found = refined(arm, around, capsule.number, s, allowance, found)
        outcome, away, way = found
        if outcome == REFUTED and is_solid(around, pair):
            return REFUTED, pair, away, (tries, spared), farthest
        if bounded and outcome == CERTIFIED:
            if keeps:
                planes.append(SeparatingPlane(start, end, -1 - pair if closer else pair, way, at))
            if around.meshes[s] >= 0 and not closer:
                level = _level(allowance, capsule, way, level_at_ends, arm)
                mesh = around.meshes[s] + 0
                keep_plane(latest, SeparatingPlane(start, end, mesh, way, level))
        elif not open_box(around, pair, capsule.way, (capsule.first, capsule.last), work):
            candidates.append(pair)
            farthest = max(farthest, capsule.way)
            # the piece is halved anyhow: the rest of the mesh is as good tried on its halves
            left = around.meshes[s] + 0
    return UNDECIDED, -1, 0.0, (tries, spared), farthest


@jitable(forceinline=True)
def as_found(
    arm: _Arm, around: Obstacles, c: int, s: int, allowance: float, found: Found
) -> tuple[bool, Found]:
    """Result for a capsule that contains no closer body: it stays as it is."""
    return False, found
