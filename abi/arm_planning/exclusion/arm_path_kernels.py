"""Segments along which the paper's arm stays clear, and paths pulled tight with such segments.

The test of a segment works as ``abi.arm_planning.certificates.separate_paper_arm_kernels`` does for
a curve, but keeps no directions to check later. The longest pieces of the segment come first, so
that a collision shows at one of the first poses.

Where a capsule passes close to an obstacle, a bound of its motion would split the segment into
thousands of pieces. There a direction n is tried at both ends of the piece, too: between them
n·P(t) is above the lower one less B l²/8, l being the length of the piece and B a bound of the
second derivative of P (:mod:`abi.robot.paper_arm.pose_kernels`).

For segments, tool and arm only answer yes or no; that takes most of the time of tightening. A path
is a list of points, [unit], world. ``clear(around, points)`` checks whether the segments between
two or three points are clear; with one that is not compiled, :func:`pull` runs as plain Python.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np

from abi.arm_planning.certificates.separate_pairs_kernels import (
    ALLOWANCE,
    FINEST,
    LONGER,
    Span,
    as_found,
    separate_pairs,
)
from abi.arm_planning.certificates.separate_paper_arm_kernels import (
    allowance_of,
    capsule_of,
    level_at_ends,
)
from abi.arm_planning.exclusion.paper_arm_mask_kernels import touched_row
from abi.arm_planning.world.collision_world_kernels import NO_OBSTACLES, Obstacles, add_pairs_within
from abi.arrays import BoolArray, FloatArray, IntArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, NEW_FLAGS, compiled
from abi.curves.clearance.separation_kernels import NO_PLANE, REFUTED, new_lists
from abi.obstacles.triangle_mesh.surface_tables_kernels import DescentWorkspace, new_room
from abi.obstacles.triangle_mesh.triangle_kernels import DEPTH
from abi.obstacles.vector_kernels import Vec3, axpy, distance, dot, sub, vec3_at
from abi.robot.paper_arm.pose_kernels import (
    CAPSULE,
    NO_ARM,
    ArmTable,
    bend_near,
    bent,
    capsule_ends,
    is_bounded,
    neighbourhood_of,
    pose_of,
    reaches,
    shoulder_holds,
)
from abi.search.taut.tighten_kernels import length_of
from abi.search.taut.tighten_near_meshes_kernels import NO_SURROUNDINGS, PathObstacles, is_clear

MOST_TRIES = 20_000
"""Largest number of tries to prove a segment clear, before it counts as shut."""


_LOOKS = (2, 4, 8)
"""Parts of a segment at whose ends it is seen whether what was touched last is touched again."""


class ArmSegments(NamedTuple):
    """Arm and surroundings on the segments of its tool.

    Attributes:
        arm: the arm.
        around: what to keep clear of.
        forearm: middle of a6, [unit].
        slide: how much longer or shorter it may be, [unit].
        most_tries: of a capsule and an obstacle, to prove a segment; those far away do not count.
    """

    arm: ArmTable
    around: Obstacles
    forearm: float
    slide: float
    most_tries: int


_LastContact = tuple[IntArray, IntArray]
"""The pair that touched, (1,), on the last segment that was not clear, as it often does so on the
next: capsule times number of obstacles, plus obstacle, -1 for none; and room for ``DEPTH`` rows."""


NO_SEGMENTS = ArmSegments(NO_ARM, NO_OBSTACLES, 1.0, 0.0, MOST_TRIES)
"""Example for the compiler."""


@jitable
def no_contact() -> _LastContact:
    """Memory of the last contact, without one."""
    return np.full(1, -1, np.int32), np.empty(DEPTH, np.int32)


@jitable
def _touches_again(segments: ArmSegments, latest: _LastContact, first: Vec3, last: Vec3) -> bool:
    """Check if the capsule that touched an obstacle last touches it at places of a segment."""
    arm, around, forearm, _, _ = segments
    count, (touched, waiting) = len(around.margins), latest
    c, s = touched[0] // count, touched[0] % count
    if touched[0] < 0 or s == count - 1:
        return False
    root = s
    if around.meshes[s] >= 0:
        for k in range(len(around.outer)):
            if around.meshes[around.outer[k]] == around.meshes[s]:
                root = int(around.outer[k])
    way = sub(last, first)
    need = arm.capsules[CAPSULE * c + 3] + around.margins[s] - ALLOWANCE * around.size
    for parts in _LOOKS:
        for k in range(1, parts, 2):
            tool = axpy(k / parts, way, first)
            if not reaches(arm, tool, forearm):
                return True
            a, b = capsule_ends(arm, pose_of(arm, tool, forearm), c)
            row = touched_row(around, root, a, b, need, s, waiting)
            if row >= 0:
                touched[0] = c * count + row
                return True
    return False


@jitable
def arm_is_clear(segments: ArmSegments, contact: _LastContact, first: Vec3, last: Vec3) -> bool:
    """Check whether it is proven that the arm keeps clear from one place of the tool to another.

    Args:
        segments: what to keep clear of.
        contact: its last one; written.
        first, last: places of the tool, [unit], world.
    """
    if _touches_again(segments, contact, first, last):
        return False
    arm, around, forearm, slid, most_tries = segments
    length, way = distance(first, last), sub(last, first)
    pending, at, tries = [(0.0, 1.0, 0, 0)], 0, 0
    lists, latest = new_lists(), [NO_PLANE]
    candidates, work = lists.candidates, lists.work
    while at < len(pending):
        start, end, lowest, highest = pending[at]
        at += 1
        middle = axpy((start + end) / 2, way, first)
        farthest = LONGER * (end - start) / 2 * length
        if not reaches(arm, middle, forearm):
            return False
        pose = pose_of(arm, middle, forearm)
        if not shoulder_holds(arm, pose):
            return False
        neighbourhood = neighbourhood_of(arm, pose, farthest, slid)
        bounded = is_bounded(arm, neighbourhood)
        if bounded and slid == 0:
            a = pose_of(arm, axpy(start, way, first), forearm)
            b = pose_of(arm, axpy(end, way, first), forearm)
            bend = bend_near(arm, neighbourhood) * farthest * farthest / 2
            neighbourhood = bent(neighbourhood, a, b, bend)
        allowance = allowance_of(around, neighbourhood)
        if at == 1:  # the whole segment: what boxes do not keep clear of it
            for c in range(len(arm.capsules) // CAPSULE):
                capsule, far = capsule_of((arm, neighbourhood), c), math.inf
                if bounded:
                    far = capsule.radius + capsule.way + allowance
                add_pairs_within(around, c, (capsule.first, capsule.last), far, candidates)
            highest = len(candidates)
        span = Span(start, end, (start + end) / 2, allowance, bounded, False)
        work.clear()
        left = len(candidates)
        for i in range(highest - 1, lowest - 1, -1):
            work.append(candidates[i])
        outcome, pair, _, tried, _ = separate_pairs(
            around,
            span,
            lists,
            latest,
            capsule_of,
            level_at_ends,
            as_found,
            (arm, neighbourhood),
        )
        if outcome == REFUTED:
            contact[0][0] = pair
            return False
        tries += tried[0]
        if len(candidates) == left:
            continue
        if tries > most_tries or farthest < FINEST * around.size:
            return False
        pending.append((start, (start + end) / 2, left, len(candidates)))
        pending.append(((start + end) / 2, end, left, len(candidates)))
    return True


@compiled(example=(FLOATS, NO_SEGMENTS, NEW_FLAGS))
def clear_segments(points: FloatArray, segments: ArmSegments, clear: BoolArray) -> None:
    """Flag the segments of a polyline on which it is proven that the arm keeps clear.

    Args:
        points: its vertices, flat (3 k,), k >= 2, [unit], world.
        segments: what the arm is to keep clear of.
        clear: (k - 1,); written.
    """
    own = no_contact()
    contact = borrowed(own)
    for k in range(len(clear)):
        clear[k] = arm_is_clear(
            segments, contact, vec3_at(points, 3 * k), vec3_at(points, 3 * k + 3)
        )
    held(own)


_Segments = TypeVar("_Segments")
Clear = Callable[[_Segments, tuple[Vec3, ...]], bool]

ROUNDS = 3
"""Rounds, at most, in which a path is pulled tight."""
_STEPS = (0.8, 0.3, 0.08)
_SETTLED = 1e-3
_CUT = (0.45, 0.2)


_Around = tuple[PathObstacles, DescentWorkspace, ArmSegments, _LastContact]
"""What the tool keeps clear of, room for its descents, what the arm does, and its last contact."""


@jitable
def _clear(around: _Around, points: tuple[Vec3, ...]) -> bool:
    """Check whether tool and arm are clear on the segments between points."""
    tool, room, arm, contact = around
    for k in range(len(points) - 1):
        a, b = points[k], points[k + 1]
        if not (is_clear(tool, 0, a, b, room) and arm_is_clear(arm, contact, a, b)):
            return False
    return True


@jitable
def _shortcuts(path: list[Vec3], around: _Segments, clear: Clear[_Segments]) -> list[Vec3]:
    """Path from each vertex to the farthest that it sees, found by doubling, then halving."""
    kept, i, last = [path[0]], 0, len(path) - 1
    while i < last:
        near, step = i + 1, 2
        while i + step <= last and clear(around, (path[i], path[i + step])):
            near, step = i + step, 2 * step
        tried = i + step <= last
        far = min(i + step, last)
        while far > near + 1:
            middle = (near + far) // 2
            if clear(around, (path[i], path[middle])):
                near = middle
            else:
                far, tried = middle, True
        if near < far and not tried and clear(around, (path[i], path[last])):
            near = last
        i = near
        kept.append(path[i])
    return kept


@jitable
def _moved(path: list[Vec3], around: _Segments, clear: Clear[_Segments]) -> list[Vec3]:
    """Path with vertices dropped, or moved towards the chord of their neighbours."""
    kept = [path[0]]
    for k in range(1, len(path) - 1):
        a, vertex, b = kept[-1], path[k], path[k + 1]
        if clear(around, (a, b)):
            continue
        chord = sub(b, a)
        share = dot(sub(vertex, a), chord) / max(dot(chord, chord), 1e-300)
        pull = sub(axpy(min(max(share, 0.0), 1.0), chord, a), vertex)
        found = vertex
        for step in _STEPS:
            at = axpy(step, pull, vertex)
            if clear(around, (a, at, b)):
                found = at
                break
        kept.append(found)
    kept.append(path[-1])
    return kept


@jitable
def _cut_corners(path: list[Vec3], around: _Segments, clear: Clear[_Segments]) -> list[Vec3]:
    """Path with its corners cut where tool and arm stay clear."""
    kept = [path[0]]
    for k in range(1, len(path) - 1):
        vertex = path[k]
        back, ahead = sub(path[k - 1], vertex), sub(path[k + 1], vertex)
        cut = False
        for share in _CUT:
            first, last = axpy(share, back, vertex), axpy(share, ahead, vertex)
            if clear(around, (first, last)):
                kept.append(first)
                kept.append(last)
                cut = True
                break
        if not cut:
            kept.append(vertex)
    kept.append(path[-1])
    return kept


@jitable
def pull(path: list[Vec3], around: _Segments, clear: Clear[_Segments], rounds: int) -> list[Vec3]:
    """Drop the vertices that a path can do without, move others, and cut corners.

    Args:
        path: the path, all of it clear.
        around: passed to ``clear``.
        clear: whether the segments between points are.
        rounds: in which vertices are moved and corners cut, at most.

    Returns:
        The path, never longer.
    """
    path = _shortcuts(path, around, clear)
    for _ in range(rounds):
        before = length_of(path)
        path = _cut_corners(_moved(path, around, clear), around, clear)
        if length_of(path) > (1 - _SETTLED) * before:
            break
    return path


@compiled(example=(FLOATS, NO_SURROUNDINGS, NO_SEGMENTS))
def pulled(points: FloatArray, surroundings: PathObstacles, segments: ArmSegments) -> FloatArray:
    """Pull a path taut for the tool and an arm that the kernels know.

    Args:
        points: flat (3 k,), clear for tool and arm, [unit], world.
        surroundings: what the tool keeps clear of.
        segments: what the arm keeps clear of.

    Returns:
        The path, flat, never longer.
    """
    own = surroundings, new_room(), segments, no_contact()
    both = borrowed(own)
    path = pull([vec3_at(points, 3 * k) for k in range(len(points) // 3)], both, _clear, ROUNDS)
    taut = np.empty(3 * len(path))
    for k in range(len(path)):
        taut[3 * k], taut[3 * k + 1], taut[3 * k + 2] = path[k]
    held(own)
    return taut
