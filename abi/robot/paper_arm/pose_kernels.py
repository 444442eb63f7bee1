"""Poses of the paper's arm from its tool's position, and bounds of its links' displacement.

With S the shoulder, E the elbow, T the tool, D = |T - S|, r the tool's distance from the base axis
and p the elbow's, in the arm's plane |T - E| = a6 gives, with u along the forearm,

    u·dT - u·dE = da6,   dE = a3 dq2 e,   |u·e| = |sin q3|,

so the elbow moves by (u·dT - da6) / sin q3 in the plane, and by p / r of the tool's way around the
axis across it. Both are orthogonal: |dE| <= L |dT| + |da6| / |sin q3| with
L = max(1, 1 / |sin q3|, p / r). The other points of a rigid link move as two of its points tell.

Along a straight way of the tool, with a6 fixed, v = T' in the plane and E' = a3 q2' e there, once
more differentiated,

    a3 q2'' |sin q3| <= |v - E'|²/a6 + |u·v'| + |E'|²/a3,   |v'| <= 1/r,

for u' = (v - E')/a6. The plane turns with abs(f') <= 1/r and abs(f'') <= 1/r², which adds
p f'² + 2 |p'| |f'| + p |f''| to the elbow's second derivative, and q2' adds |E'|²/a3.

Plain Python that numba compiles with its caller. A capsule is four numbers: its body as in
``abi.robot.paper_arm.link_capsules``, low and high end, radius.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, NEW_FLOATS, compiled
from abi.obstacles.vector_kernels import Vec3, axpy, sub

CAPSULE = 4
"""Numbers that describe a capsule."""

_LEAST_SINE = 1e-3  # of q3: nearer to stretched or folded no proof would come to an end
COSINE_ROUNDING = 2.0**-48
"""Rounding of a cosine of q3, as a part of the squares that it is made of."""
COLUMN, UPPER_ARM, FOREARM = 0, 1, 2
"""Bodies of capsules; another one slides."""


class ArmTable(NamedTuple):
    """The paper's arm as numbers: base, lengths, limits, and its capsules.

    Attributes:
        x, y, z: of the base, [unit], world.
        shoulder: height of the shoulder, [unit], world.
        upper: length of the upper arm, a3, [unit].
        forearm: shortest length from elbow to tool, a4 + a5, [unit].
        side: sign of q3.
        least_cosine_q3, least_cosine_q2: cosines of their limits.
        capsules: rows, flat (4 c,).
    """

    x: float
    y: float
    z: float
    shoulder: float
    upper: float
    forearm: float
    side: float
    least_cosine_q3: float
    least_cosine_q2: float
    capsules: FloatArray


class PaperArmPose(NamedTuple):
    """Pose of the paper's arm: where its joints are with the tool at a point.

    Attributes:
        shoulder, elbow, tool: [unit], world.
        forearm: length from elbow to tool, a6, [unit].
        out: the elbow's distance from the base axis, on the tool's side, [unit].
        across: the tool's, [unit].
        reach: from shoulder to tool, [unit].
    """

    shoulder: Vec3
    elbow: Vec3
    tool: Vec3
    forearm: float
    out: float
    across: float
    reach: float


class PoseNeighbourhood(NamedTuple):
    """How far from a pose the arm may be, and how much faster than the tool its elbow moves there.

    Attributes:
        pose: in the middle.
        tool, slide: farthest that tool and slide get from there, [unit].
        by_tool: L, way of the elbow per way of the tool; inf where it is not bounded.
        by_slide: 1 / |sin q3|, its way per way of the slide; inf where it is not bounded.
        shortest, longest: forearm's length a6, [unit].
        first, last: poses at the ends of a piece of a motion, if ``bend`` is finite.
        bend: bound of the elbow's second derivative on it, times l²/8, l being its length, [unit];
            inf where there is none.
    """

    pose: PaperArmPose
    tool: float
    slide: float
    by_tool: float
    by_slide: float
    shortest: float
    longest: float
    first: PaperArmPose
    last: PaperArmPose
    bend: float


NO_ARM = ArmTable(0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, -1.0, -1.0, FLOATS)
"""Example of an arm."""


@jitable(forceinline=True)
def reaches(arm: ArmTable, tool: Vec3, forearm: float) -> bool:
    """Check if the tool can be there, off the axis, with the elbow bent and q3 within its limit."""
    x, y, z = tool[0] - arm.x, tool[1] - arm.y, tool[2] - arm.shoulder
    reach = math.sqrt(x * x + y * y + z * z)
    low, high = abs(arm.upper - forearm), arm.upper + forearm
    if not (forearm > 0 and low < reach < high and x * x + y * y > 0):
        return False
    cosine = (reach * reach - arm.upper * arm.upper - forearm * forearm) / (2 * arm.upper * forearm)
    bent: bool = cosine >= arm.least_cosine_q3
    return bent


@jitable(forceinline=True)
def shoulder_holds(arm: ArmTable, pose: PaperArmPose) -> bool:
    """Check whether q2 is within its limit."""
    holds: bool = pose.elbow[2] - arm.shoulder >= arm.upper * arm.least_cosine_q2
    return holds


@jitable(forceinline=True)
def pose_of(arm: ArmTable, tool: Vec3, forearm: float) -> PaperArmPose:
    """The arm with its tool at a place that it reaches."""
    x, y, z = tool[0] - arm.x, tool[1] - arm.y, tool[2] - arm.shoulder
    across = math.sqrt(x * x + y * y)
    reach = math.sqrt(across * across + z * z)
    upper = arm.upper
    along = (upper * upper - forearm * forearm + reach * reach) / (2 * reach)
    height = arm.side * math.sqrt(max(upper * upper - along * along, 0.0))
    out = (along * across - height * z) / reach
    up = (along * z + height * across) / reach
    elbow = (arm.x + x / across * out, arm.y + y / across * out, arm.shoulder + up)
    return PaperArmPose((arm.x, arm.y, arm.shoulder), elbow, tool, forearm, out, across, reach)


@jitable(forceinline=True)
def unbounded_near(pose: PaperArmPose, tool: float, slide: float) -> PoseNeighbourhood:
    """Where tool and slide get so far from a pose, and nothing bounds how far the elbow gets."""
    short, long, inf = pose.forearm - slide, pose.forearm + slide, math.inf
    return PoseNeighbourhood(pose, tool, slide, inf, inf, short, long, pose, pose, inf)


@jitable(forceinline=True)
def neighbourhood_of(
    arm: ArmTable, pose: PaperArmPose, tool: float, slide: float
) -> PoseNeighbourhood:
    """What is within distances of the tool and of the slide from a pose, [unit].

    cos q3 = (D² - a3² - a6²) / (2 a3 a6) is enclosed by its numerator and denominator. Near to
    stretched or folded its rounding counts: that of sin q3 is cot q3 times as large.
    """
    upper = arm.upper
    near, far = pose.reach - tool, pose.reach + tool
    short, long = pose.forearm - slide, pose.forearm + slide
    none = unbounded_near(pose, tool, slide)
    if near <= 0 or short <= 0 or pose.across - tool <= 0:
        return none
    low = near * near - upper * upper - long * long
    high = far * far - upper * upper - short * short
    low /= 2 * upper * (short if low < 0 else long)
    high /= 2 * upper * (short if high > 0 else long)
    squares = far * far + upper * upper + long * long
    cosine = max(abs(low), abs(high)) + COSINE_ROUNDING * squares / (2 * upper * short)
    if cosine >= 1:
        return none
    sine = math.sqrt(1 - cosine * cosine)
    if sine < _LEAST_SINE:
        return none
    out = abs(pose.out) + (tool + slide) / sine
    rate = max(1.0, 1 / sine, out / (pose.across - tool))
    return PoseNeighbourhood(pose, tool, slide, rate, 1 / sine, short, long, pose, pose, math.inf)


@jitable(forceinline=True)
def bend_near(arm: ArmTable, near: PoseNeighbourhood) -> float:
    """Bound of the elbow's second derivative while the tool runs straight near a pose, [1/unit].

    Args:
        arm: the arm.
        near: where the elbow's way is bounded, and the slide fixed.
    """
    pose, fast = near.pose, near.by_slide
    across = pose.across - near.tool
    out = abs(pose.out) + near.tool * fast
    turn = fast * ((1 + fast) ** 2 / pose.forearm + 1 / across + fast * fast / arm.upper)
    bend: float = turn + fast * fast / arm.upper + 2 * out / (across * across) + 2 * fast / across
    return bend


@jitable(forceinline=True)
def bent(
    near: PoseNeighbourhood, first: PaperArmPose, last: PaperArmPose, bend: float
) -> PoseNeighbourhood:
    """A piece of a motion with poses at its ends, and a bound of the elbow's second derivative."""
    _, tool, slide, by_tool, by_slide, short, long, _, _, _ = near
    return PoseNeighbourhood(
        near.pose, tool, slide, by_tool, by_slide, short, long, first, last, bend
    )


@jitable(forceinline=True)
def is_bounded(arm: ArmTable, near: PoseNeighbourhood) -> bool:
    """Check whether the elbow's way is bounded near a pose, and q2 and q3 keep their limits."""
    if math.isinf(near.by_tool):
        return False
    least, long = near.pose.reach - near.tool, near.longest
    cosine = least * least - arm.upper * arm.upper - long * long
    cosine /= 2 * arm.upper * (near.shortest if cosine < 0 else long)
    lowest = near.pose.elbow[2] - arm.shoulder
    lowest -= near.by_tool * near.tool
    lowest -= near.by_slide * near.slide
    hold: bool = cosine >= arm.least_cosine_q3 and lowest >= arm.upper * arm.least_cosine_q2
    return hold


@jitable(forceinline=True)
def capsule_ends(arm: ArmTable, pose: PaperArmPose, c: int) -> tuple[Vec3, Vec3]:
    """Both ends of capsule c's segment, [unit], world."""
    capsules = arm.capsules
    body, low, high = capsules[CAPSULE * c], capsules[CAPSULE * c + 1], capsules[CAPSULE * c + 2]
    if body == COLUMN:
        return (arm.x, arm.y, arm.z + low), (arm.x, arm.y, arm.z + high)
    if body == UPPER_ARM:
        way = sub(pose.elbow, pose.shoulder)
        return axpy(low / arm.upper, way, pose.shoulder), axpy(high / arm.upper, way, pose.shoulder)
    way = sub(pose.tool, pose.elbow)
    slide = 0.0 if body == FOREARM else pose.forearm - arm.forearm
    a, b = (low + slide) / pose.forearm, (high + slide) / pose.forearm
    return axpy(a, way, pose.elbow), axpy(b, way, pose.elbow)


@jitable(forceinline=True)
def capsule_share(arm: ArmTable, forearm: float, c: int) -> float:
    """Largest part that points of capsule c's segment have in where the elbow is."""
    capsules = arm.capsules
    body, low, high = capsules[CAPSULE * c], capsules[CAPSULE * c + 1], capsules[CAPSULE * c + 2]
    if body == COLUMN:
        return 0.0
    if body == UPPER_ARM:
        share: float = max(abs(low), abs(high)) / arm.upper
        return share
    slide = 0.0 if body == FOREARM else forearm - arm.forearm
    share = max(abs(1 - (low + slide) / forearm), abs(1 - (high + slide) / forearm))
    return share


@jitable(forceinline=True)
def capsule_rates(arm: ArmTable, near: PoseNeighbourhood, c: int) -> tuple[float, float]:
    """Ways of every point of capsule c's segment, per way of the tool and of the slide."""
    capsules = arm.capsules
    body, low, high = capsules[CAPSULE * c], capsules[CAPSULE * c + 1], capsules[CAPSULE * c + 2]
    if body == COLUMN:
        return 0.0, 0.0
    if body == UPPER_ARM:
        share = max(abs(low), abs(high)) / arm.upper
        return share * near.by_tool, share * near.by_slide
    slides = body != FOREARM
    most, slid = 0.0, 0.0
    for forearm in (near.shortest, near.longest):
        for end in (low, high):
            at = end + (forearm - arm.forearm if slides else 0.0)
            behind, ahead = abs(1 - at / forearm), abs(at / forearm)
            most = max(most, behind * near.by_tool + ahead)
            by_slide = behind * (near.by_slide + 1) if slides else behind * near.by_slide + ahead
            slid = max(slid, by_slide)
        if near.shortest == near.longest:  # nothing slides
            break
    return most, slid


@compiled(example=(FLOATS, NO_ARM, NEW_FLOATS))
def place_capsules(joints: FloatArray, arm: ArmTable, ends: FloatArray) -> None:
    """Both ends of every capsule at joint positions.

    Args:
        joints: of each pose q1 to q6, flat (6 n,), [rad], q5 [unit].
        arm: the arm.
        ends: flat (6 n c,), [unit], world; written.
    """
    count = len(arm.capsules) // CAPSULE
    for i in range(len(joints) // 6):
        q1, q2, q3 = joints[6 * i], joints[6 * i + 1], joints[6 * i + 2]
        forearm = arm.forearm + joints[6 * i + 4]
        right, ahead = math.sin(q1), math.cos(q1)
        out, up = arm.upper * math.sin(q2), arm.shoulder + arm.upper * math.cos(q2)
        across, height = out + forearm * math.sin(q2 + q3), up + forearm * math.cos(q2 + q3)
        shoulder = (arm.x, arm.y, arm.shoulder)
        elbow = (arm.x + right * out, arm.y - ahead * out, up)
        tool = (arm.x + right * across, arm.y - ahead * across, height)
        pose = PaperArmPose(shoulder, elbow, tool, forearm, out, across, 0.0)
        for c in range(count):
            k = 6 * (i * count + c)
            a, b = capsule_ends(arm, pose, c)
            ends[k], ends[k + 1], ends[k + 2] = a
            ends[k + 3], ends[k + 4], ends[k + 5] = b
