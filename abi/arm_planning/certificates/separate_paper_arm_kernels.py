"""Certificates of the paper's arm: directions that separate its capsules from its surroundings.

See ``abi.curves.clearance.certificate.Certificate`` for what a direction proves,
``abi.robot.paper_arm.pose_kernels`` for the numbers of an arm and its capsules,
``abi.curves.clearance.separation_kernels`` for pieces and planes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abi.arm_planning.certificates.separate_pairs_kernels import (
    ALLOWANCE,
    FINEST,
    LONGER,
    Moving,
    Span,
    as_found,
    separate_pairs,
)
from abi.arm_planning.world.collision_world_kernels import NO_OBSTACLES, Obstacles, add_pairs_within
from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, NEW_FLOATS, compiled
from abi.curves.clearance.separation_kernels import (
    CERTIFIED,
    NO_PLANE,
    UNDECIDED,
    Attempt,
    CurvePoints,
    HalvingLimits,
    Outcome,
    Piece,
    ProofLists,
    SeparatingPlane,
    halves_of_curve,
    new_lists,
    separate_pieces,
    table_of,
    whole_curve,
)
from abi.obstacles.vector_kernels import Vec3, distance, dot, vec3_at
from abi.robot.paper_arm.pose_kernels import (
    CAPSULE,
    NO_ARM,
    ArmTable,
    PoseNeighbourhood,
    capsule_ends,
    capsule_rates,
    capsule_share,
    is_bounded,
    neighbourhood_of,
    pose_of,
    reaches,
    shoulder_holds,
)

UNREACHED = 3
"""Outcome of a piece with a place that the arm does not reach within its limits."""

_ANYWHERE = (0.0, 0.0, 0.0)


class Slide(NamedTuple):
    """Bounds of the slide q5 along the curve, where q5 does not decrease.

    Attributes:
        parameters: increasing, from the curve's first to its last (m,).
        low, high: bounds at each of them (m,), [unit].
    """

    parameters: FloatArray
    low: FloatArray
    high: FloatArray


NO_SLIDE = Slide(FLOATS, FLOATS, FLOATS)
"""Example for the compiler."""


@jitable(forceinline=True)
def _slide_within(slide: Slide, start: float, end: float) -> tuple[float, float]:
    """Bounds of q5 from one parameter to another."""
    first = int(np.searchsorted(slide.parameters, start, side="right")) - 1
    last = int(np.searchsorted(slide.parameters, end))
    return slide.low[max(first, 0)], slide.high[min(last, len(slide.high) - 1)]


@jitable(forceinline=True)
def capsule_of(near: tuple[ArmTable, PoseNeighbourhood], c: int) -> Moving:
    """Capsule c of an arm near a pose."""
    arm, neighbourhood = near
    a, b = capsule_ends(arm, neighbourhood.pose, c)
    by_tool, by_slide = capsule_rates(arm, neighbourhood, c)
    way = by_tool * neighbourhood.tool + by_slide * neighbourhood.slide
    bow = neighbourhood.bend
    if not math.isinf(bow):
        bow *= capsule_share(arm, neighbourhood.pose.forearm, c)
    return Moving(c, a, b, arm.capsules[CAPSULE * c + 3], way, bow)


@jitable(forceinline=True)
def level_at_ends(near: tuple[ArmTable, PoseNeighbourhood], capsule: Moving, way: Vec3) -> float:
    """Least product of a direction and a capsule's segment at both ends of a piece, [unit]."""
    arm, neighbourhood = near
    a, b = capsule_ends(arm, neighbourhood.first, capsule.number)
    c, d = capsule_ends(arm, neighbourhood.last, capsule.number)
    return min(min(dot(way, a), dot(way, b)), min(dot(way, c), dot(way, d)))


@jitable(forceinline=True)
def allowance_of(around: Obstacles, near: PoseNeighbourhood) -> float:
    """Margin for rounding errors near a pose, [unit]."""
    return ALLOWANCE * around.size * (1.0 if math.isinf(near.by_tool) else 1 + near.by_tool)


@jitable(forceinline=True)
def _farthest(points: FloatArray, piece: Piece, middle: Vec3) -> float:
    """Upper bound of the distance of a piece's points from its middle, [unit]."""
    farthest = 0.0
    for i in range(3 * piece.first, 3 * piece.last, 3):
        farthest = max(farthest, distance(middle, vec3_at(points, i)))
    return farthest * LONGER


_AlongCurve = tuple[CurvePoints, ArmTable, Obstacles, Slide, list[SeparatingPlane]]
"""The tool's curve, an arm, what it is to keep clear of, bounds of q5, and room for planes."""


@jitable(forceinline=True)
def _along_curve(
    problem: _AlongCurve, piece: Piece, behind: Piece, known: tuple[int, int], lists: ProofLists
) -> Attempt:
    """Separate the arm's capsules from rows while the tool runs along a piece.

    The size of what is left is how far the tool gets from the piece's middle.
    """
    (points, _, _), arm, around, slide, latest = problem
    middle = vec3_at(points, 3 * behind.first)
    low, high = _slide_within(slide, piece.start, piece.end)
    forearm, slid = arm.forearm + (low + high) / 2, (high - low) / 2
    farthest = _farthest(points, piece, middle)
    if not reaches(arm, middle, forearm):
        return Attempt(UNREACHED, -1, 0.0, 0, farthest)
    pose = pose_of(arm, middle, forearm)
    if not shoulder_holds(arm, pose):
        return Attempt(UNREACHED, -1, 0.0, 0, farthest)
    neighbourhood = neighbourhood_of(arm, pose, farthest, slid)
    bounded, allowance = is_bounded(arm, neighbourhood), allowance_of(around, neighbourhood)
    span = Span(piece.start, piece.end, behind.start, allowance, bounded, True)
    candidates, work = lists.candidates, lists.work
    work.clear()
    for i in range(known[1] - 1, known[0] - 1, -1):
        work.append(candidates[i])
    before = len(candidates)
    outcome, pair, away, tried, _ = separate_pairs(
        around, span, lists, latest, capsule_of, level_at_ends, as_found, (arm, neighbourhood)
    )
    if len(candidates) > before and outcome == UNDECIDED:
        pair = candidates[len(candidates) - 1]
    return Attempt(outcome, pair, away, tried[0] + tried[1], farthest)


@compiled(example=(FLOATS, FLOATS, NEW_FLOATS, NO_ARM, NO_OBSTACLES, NO_SLIDE, 9))
def separate_arm(
    world: FloatArray,
    breaks: FloatArray,
    points: FloatArray,
    arm: ArmTable,
    around: Obstacles,
    slide: Slide,
    most_tries: int,
) -> Outcome:
    """Separate every capsule from every obstacle while the tool runs along a curve.

    Where that is proven, q2 and q3 keep their limits, too.

    Args:
        world: Bézier points of the s polynomials, flat (3 s (degree + 1),), world frame.
        breaks: parameters between them (s + 1,).
        points: room for the same and the halves, flat (3 (s + 2 MOST_HALVINGS + 2) (degree + 1),).
        arm: the arm.
        around: what to keep clear of.
        slide: bounds of q5.
        most_tries: tries it may take.

    Returns:
        As for curves; a plane's obstacle is the number of its pair, and its level the parameter of
        the pose.
    """
    for i in range(len(world)):
        points[i] = world[i]
    lists = new_lists()
    for c in range(len(arm.capsules) // CAPSULE):
        add_pairs_within(around, c, (_ANYWHERE, _ANYWHERE), math.inf, lists.candidates)
    if len(lists.candidates) == 0:
        return CERTIFIED, 0.0, -1, math.inf, table_of(lists.planes)
    width = len(world) // (3 * (len(breaks) - 1))
    curve, whole = whole_curve(points, breaks, width)
    limits = HalvingLimits(width, FINEST * around.size, most_tries, math.inf, False, False)
    problem = curve, arm, around, slide, [NO_PLANE]
    ending = separate_pieces(problem, whole, halves_of_curve, _along_curve, limits, lists)
    return (*ending, table_of(lists.planes))
