"""Gaps between the paper's arm and its surroundings, for given tool positions.

See ``abi.arm.pose_kernels`` for the numbers of an arm and its capsules.
"""

from __future__ import annotations

from numba.extending import register_jitable

from abi.arm.mask_kernels import is_beside, is_far, outline
from abi.arm.pose_kernels import (
    CAPSULE,
    NO_ARM,
    UPPER_ARM,
    ArmTable,
    capsule_ends,
    pose_of,
)
from abi.arm.surroundings_kernels import NO_OBSTACLES, Obstacles, asked_rows, box_gap
from abi.arrays import BoolArray, FloatArray
from abi.compiled import FLAGS, FLOATS, NEW_FLOATS, compiled
from abi.obstacles.obstacle_set_kernels import distance_to_segment
from abi.obstacles.vector_kernels import Vec3, vec3_at


@compiled(example=(FLOATS, NO_ARM, NO_OBSTACLES, 1.0, FLAGS, 1.0, NEW_FLOATS))
def arm_gaps(
    points: FloatArray,
    table: ArmTable,
    around: Obstacles,
    forearm: float,
    reached: BoolArray,
    most: float,
    gaps: FloatArray,
) -> None:
    """Least distance of the moving capsules to what is asked of them, with the tool at places.

    A box around others counts as what is in it only where it has nothing inside.

    Args:
        points: flat (3 n,), [unit], world.
        table: the arm.
        around: what to keep clear of.
        forearm: length a6, [unit].
        reached: places to look at (n,).
        most: distances above count as this, [unit].
        gaps: (n,), [unit]; ``most`` where it is not reached; written.
    """
    arm, capsules = table
    count, moving = len(around.margins), len(capsules) // CAPSULE
    still, widest, out_of_upper, out_of_fore = outline(table)
    rows = [s for s in asked_rows(around, moving) if s < count - 1]
    for i in range(len(gaps)):
        gaps[i] = most
        if not reached[i]:
            continue
        tool = vec3_at(points, 3 * i)
        near = False
        for s in rows:
            near = near or not is_beside(around, s, arm, tool, widest + most)
        if not near:
            continue
        pose = pose_of(arm, tool, forearm)
        for s in rows:
            a, b = pose.shoulder, pose.elbow
            upper = is_far(around.primitives, s, a, b, out_of_upper + gaps[i])
            fore = is_far(around.primitives, s, b, tool, out_of_fore + gaps[i])
            for c in range(still, moving):
                if upper if capsules[CAPSULE * c] == UPPER_ARM else fore:
                    continue
                if around.asked[c * count + s]:
                    a, b = capsule_ends(arm, pose, capsules, c)
                    gaps[i] = _gap(around, s, a, b, capsules[CAPSULE * c + 3], gaps[i])


@register_jitable
def _gap(around: Obstacles, s: int, a: Vec3, b: Vec3, radius: float, best: float) -> float:
    """The lesser of ``best`` and the distance of a capsule to row s, or to what is inside it."""
    if box_gap(around.primitives, s, a, b) - radius >= best:
        return best
    if around.inside[2 * s + 1] == 0:
        return distance_to_segment(around.primitives, s, best + radius, a, b) - radius
    work = [s]
    while len(work) > 0:
        box = work.pop()
        for row in range(around.inside[2 * box], around.inside[2 * box + 1]):
            if box_gap(around.primitives, row, a, b) - radius >= best:
                continue
            if around.inside[2 * row + 1] == 0:
                best = distance_to_segment(around.primitives, row, best + radius, a, b) - radius
            else:
                work.append(row)
    return best
