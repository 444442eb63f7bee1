"""Places of the tool that the arm does not reach, or where it would touch something.

See ``abi.arm.pose_kernels`` for the numbers of an arm and its capsules.
"""

from __future__ import annotations

from numba.extending import register_jitable

from abi.arm.pose_kernels import (
    CAPSULE,
    Pose,
    capsule_ends,
    capsule_rates,
    pose_of,
    rates_near,
    reaches,
    shoulder_holds,
)
from abi.arm.separate_arm_kernels import NO_OBSTACLES, Obstacles, between_boxes, to_segment
from abi.arrays import BoolArray, FloatArray
from abi.compiled import FLAGS, FLOATS, NEW_FLAGS, compiled
from abi.obstacles.primitive_kernels import BOUNDS, WIDTH
from abi.obstacles.vector_kernels import Vec3, vec3_at


@compiled(example=(FLOATS, FLOATS, 0.0, 0.0, NEW_FLAGS))
def reached_places(
    points: FloatArray, arm: FloatArray, forearm: float, slide: float, reached: BoolArray
) -> None:
    """Mark the places that the arm reaches within the limits of q2 and q3.

    Args:
        points: flat (3 n,), [unit], world.
        arm: its nine numbers.
        forearm: length a6, [unit].
        slide: how much longer or shorter it may be, [unit].
        reached: (n,); written.
    """
    for i in range(len(reached)):
        x = vec3_at(points, 3 * i)
        reached[i] = (
            reaches(arm, x, forearm - slide)
            and reaches(arm, x, forearm + slide)
            and shoulder_holds(arm, pose_of(arm, x, forearm))
        )


@register_jitable
def _touches(around: Obstacles, s: int, a: Vec3, b: Vec3, need: float) -> bool:
    """Whether a..b is nearer than ``need`` to row s, or to what is inside it."""
    if between_boxes(around.primitives, s, a, b)[0] >= need:
        return False
    if to_segment(around.primitives, s, a, b)[0] >= need:
        return False
    if around.inside[2 * s + 1] == 0:
        return True
    work = [s]
    while len(work) > 0:
        box = work.pop()
        for row in range(around.inside[2 * box], around.inside[2 * box + 1]):
            if between_boxes(around.primitives, row, a, b)[0] >= need:
                continue
            if to_segment(around.primitives, row, a, b)[0] >= need:
                continue
            if around.inside[2 * row + 1] == 0:
                return True
            work.append(row)
    return False


@register_jitable
def _far(around: Obstacles, s: int, pose: Pose, most: float) -> bool:
    """Whether the box around shoulder, elbow and tool is farther than ``most`` from row s."""
    k = WIDTH * s + BOUNDS
    for axis in range(3):
        p, q, r = pose.shoulder[axis], pose.elbow[axis], pose.tool[axis]
        low, high = min(p, q, r), max(p, q, r)
        above, below = low - around.primitives[k + 3 + axis], around.primitives[k + axis] - high
        if max(above, below) >= most:
            return True
    return False


@compiled(example=(FLOATS, FLOATS, FLOATS, NO_OBSTACLES, 0.0, 0.0, FLAGS, NEW_FLAGS))
def touching_places(
    points: FloatArray,
    arm: FloatArray,
    capsules: FloatArray,
    around: Obstacles,
    forearm: float,
    slide: float,
    reached: BoolArray,
    touching: BoolArray,
) -> None:
    """Mark the places of the tool at which a capsule is too near to something.

    Args:
        points: flat (3 n,), [unit], world.
        arm: its nine numbers.
        capsules: rows (4 c,).
        around: what to keep clear of.
        forearm: length a6, [unit].
        slide: how much longer or shorter it may be, [unit].
        reached: places to look at (n,).
        touching: (n,), False at first; written.
    """
    count, moving = len(around.margins), len(capsules) // CAPSULE
    widest, longest = 0.0, 0.0
    for c in range(moving):
        widest = max(widest, capsules[CAPSULE * c + 3])
        # ends of capsules that lie before the shoulder, the elbow, or beyond the tool
        longest = max(longest, -capsules[CAPSULE * c + 1])
        longest = max(longest, capsules[CAPSULE * c + 2] - arm[5])
    still = 0  # capsules of the column, which are not at shoulder, elbow and tool
    while still < moving and capsules[CAPSULE * still] == 0:
        still += 1
    for i in range(len(reached)):
        if not reached[i]:
            continue
        pose = pose_of(arm, vec3_at(points, 3 * i), forearm)
        rates = rates_near(arm, pose, 0.0, slide)
        for s in range(count):
            margin = around.margins[s]
            if touching[i]:
                break
            most = (
                widest + longest + margin + (rates.slide + 1) * slide
                if slide > 0
                else (widest + longest + margin)
            )
            if s < count - 1 and _far(around, s, pose, most):
                continue
            for c in range(still, moving):
                if not around.asked[c * count + s]:
                    continue
                need = capsules[CAPSULE * c + 3] + margin
                if slide > 0:
                    need += capsule_rates(arm, rates, capsules, c)[1] * slide
                a, b = capsule_ends(arm, pose, capsules, c)
                if s == count - 1:
                    touching[i] = min(a[2], b[2]) - around.floor < need
                else:
                    touching[i] = _touches(around, s, a, b, need)
                if touching[i]:
                    break
