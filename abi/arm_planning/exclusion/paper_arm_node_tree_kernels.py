"""Places of the tool at which an arm touches an obstacle of many parts, many places at once.

As ``abi.arm_planning.exclusion.paper_arm_mask_kernels`` decides it place by place. But near a pose
an arm moves at most so much faster than its tool (:mod:`abi.robot.paper_arm.pose_kernels`): what
keeps clear with the tool in the middle of a ball, by as much as the arm may move meanwhile, does so
with the tool anywhere in it, and what is deeper than that in the way is so anywhere.
"""

from __future__ import annotations

import math

import numpy as np

from abi.arm_planning.exclusion.paper_arm_mask_kernels import is_far, is_near, outline, touched_row
from abi.arm_planning.world.collision_world_kernels import NO_OBSTACLES, Obstacles
from abi.arrays import BoolArray, IntArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.jitable import jitable
from abi.compiled import FLAGS, NEW_FLAGS, compiled
from abi.obstacles.triangle_mesh.triangle_kernels import DEPTH
from abi.obstacles.vector_kernels import Vec3, vec3_at
from abi.robot.paper_arm.pose_kernels import (
    CAPSULE,
    COLUMN,
    FOREARM,
    NO_ARM,
    UPPER_ARM,
    ArmTable,
    capsule_ends,
    neighbourhood_of,
    pose_of,
    reaches,
)
from abi.tet_mesh.node_tree import NO_NODES, NodeTree

_EVERY = 2
"""Levels of the tree, of which the balls of one are looked at."""

_ROUNDING = 1e-9
"""Part of the largest coordinate by which an arm may move farther, by rounding."""


@jitable
def _stretch_of(arm: ArmTable, forearm: float) -> float:
    """How much farther than elbow and tool points of the capsules go, at most.

    A point at a share t of the forearm goes no farther than abs(1 - t) + abs(t) times what goes
    farther, the elbow or the tool.
    """
    capsules = arm.capsules
    most = 1.0
    for c in range(len(capsules) // CAPSULE):
        body = capsules[CAPSULE * c]
        for k in range(1, 3):
            end = capsules[CAPSULE * c + k]
            if body == UPPER_ARM:
                most = max(most, abs(end) / arm.upper)
            elif body != COLUMN:
                end += 0.0 if body == FOREARM else forearm - arm.forearm
                share = end / forearm
                most = max(most, abs(1.0 - share) + abs(share))
    return most


@jitable(forceinline=True)
def _clear_of(
    around: Obstacles,
    root: int,
    segment: tuple[Vec3, Vec3],
    need: float,
    guess: int,
    waiting: IntArray,
) -> tuple[bool, int]:
    """Check if a segment is farther than ``need`` from all of an obstacle, and what to guess next.

    Args:
        around: what to keep clear of.
        root: the obstacle's row.
        segment: its ends, [unit], world.
        need: [unit].
        guess: a row that is likely to be too near; -1 without.
        waiting: room for ``DEPTH`` rows.
    """
    a, b = segment
    if is_far(around.primitives, root, a, b, need):
        return True, guess
    row = touched_row(around, root, a, b, need, guess, waiting)
    return row < 0, guess if row < 0 else row


@jitable
def _near_ball(
    arm: ArmTable,
    forearm: float,
    obstacle: tuple[Obstacles, int],
    ball: tuple[Vec3, float],
    known: tuple[bool, bool, tuple[int, int]],
    likely: tuple[int, int],
    widths: tuple[float, float, float],
    waiting: IntArray,
) -> tuple[bool, bool, bool, tuple[int, int]]:
    """Decide from the pose in the middle of a ball of tool positions whether all of it is clear.

    Args:
        arm: the arm.
        forearm: length a6, [unit].
        obstacle: what to keep clear of, and the row with all of it.
        ball: centre and radius, [unit], world.
        known: of a ball around it, whether upper arm and forearm are clear all over it, and the
            rows that these were last too near to, -1 for none.
        likely: the capsule that touched something last, and what, -1 for nothing.
        widths: farthest that capsules stand out from the lines of upper arm and forearm, [unit],
            and how much farther than elbow and tool their points go, at most.
        waiting: room for ``DEPTH`` rows.

    Returns:
        Whether upper arm and forearm are clear all over the ball, whether some capsule touches all
        over it, and the rows that those were last too near to.
    """
    (around, root), (centre, radius), (of_upper, of_fore, stretch) = obstacle, ball, widths
    upper, fore, (first, second) = known
    if not reaches(arm, centre, forearm):
        return upper, fore, False, (first, second)
    pose = pose_of(arm, centre, forearm)
    rate = neighbourhood_of(arm, pose, radius, 0.0).by_tool
    if math.isinf(rate):
        return upper, fore, False, (first, second)
    way, margin = stretch * rate * radius + _ROUNDING * around.size, around.margins[root]
    c, row = likely
    need = arm.capsules[CAPSULE * c + 3] + margin - way
    if row >= 0 and need > 0:
        a, b = capsule_ends(arm, pose, c)
        if is_near(around.primitives, row, a, b, need):
            return upper, fore, True, (first, second)
    if not upper:
        need = of_upper + margin + way
        upper, first = _clear_of(around, root, (pose.shoulder, pose.elbow), need, first, waiting)
    if not fore:
        need = of_fore + margin + way
        fore, second = _clear_of(around, root, (pose.elbow, centre), need, second, waiting)
    return upper, fore, False, (first, second)


@compiled(example=(NO_NODES, NO_ARM, (NO_OBSTACLES, 0), 0.0, FLAGS, NEW_FLAGS))
def places_touching(
    nodes: NodeTree,
    arm: ArmTable,
    obstacle: tuple[Obstacles, int],
    forearm: float,
    asked: BoolArray,
    touching: BoolArray,
) -> None:
    """Mark the places of the tool at which a capsule is too near to an obstacle.

    Args:
        nodes: the places (n,).
        arm: the arm.
        obstacle: what to keep clear of, and the row with all of it.
        forearm: length a6, [unit].
        asked: places to look at, that the arm reaches (n,).
        touching: (n,), False at first; written.
    """
    (around, root), capsules = obstacle, arm.capsules
    count, margin = len(around.margins), around.margins[root]
    still, _, of_upper, of_fore = outline(arm)
    widths = of_upper, of_fore, _stretch_of(arm, forearm)
    own = np.empty(DEPTH, np.int32)
    waiting = borrowed(own)
    latest = np.full(len(capsules) // CAPSULE, -1)  # what each capsule touched last
    likely = still  # the capsule that touched something last: beside its place it does so again
    inner, rows = len(nodes.leaves) - 2, (-1, -1)
    work = [(0, 0, False, False)]
    while len(work) > 0:
        branch, level, upper, fore = work.pop()
        touched = False
        if level % _EVERY == 0 or branch >= inner:
            ball = vec3_at(nodes.balls, 4 * branch), nodes.balls[4 * branch + 3]
            guess = likely, int(latest[likely])
            known = upper, fore, rows
            upper, fore, touched, rows = _near_ball(
                arm, forearm, obstacle, ball, known, guess, widths, waiting
            )
        if upper and fore:
            continue
        if branch < inner and not touched:
            work.append((2 * branch + 1, level + 1, upper, fore))
            work.append((2 * branch + 2, level + 1, upper, fore))
            continue
        first, last = branch, branch
        while first < inner:
            first, last = 2 * first + 1, 2 * last + 2
        for i in range(nodes.leaves[first - inner], nodes.leaves[last - inner + 1]):
            at = nodes.order[i]
            if touched or not asked[at]:
                touching[at] = asked[at]
                continue
            pose = pose_of(arm, vec3_at(nodes.points, 3 * i), forearm)
            for number in range(still - 1, len(latest)):
                c = likely if number < still else number
                if number == likely or not around.asked[c * count + root]:
                    continue
                if upper if capsules[CAPSULE * c] == UPPER_ARM else fore:
                    continue
                need = capsules[CAPSULE * c + 3] + margin
                a, b = capsule_ends(arm, pose, c)
                row = touched_row(around, root, a, b, need, int(latest[c]), waiting)
                if row >= 0:
                    latest[c], likely, touching[at] = row, c, True
                    break
    held(own)
