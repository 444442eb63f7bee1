"""Regions of tool positions on a grid, and their surface.

See ``abi.robot.paper_arm.pose_kernels`` for the numbers of an arm and its capsules.
"""

from __future__ import annotations

import math

import numpy as np

from abi.arm_planning.exclusion.paper_arm_mask_kernels import is_beside, is_far, outline
from abi.arm_planning.world.collision_world_kernels import (
    NO_OBSTACLES,
    Obstacles,
    asked_rows,
    box_gap,
)
from abi.arrays import BoolArray, FloatArray
from abi.compilation.jitable import jitable
from abi.compiled import FLAGS, FLOATS, NEW_FLOATS, compiled
from abi.obstacles.obstacle_set_kernels import distance_to_segment
from abi.obstacles.vector_kernels import Vec3, axpy, sub, vec3_at
from abi.robot.paper_arm.pose_kernels import (
    CAPSULE,
    NO_ARM,
    UPPER_ARM,
    ArmTable,
    capsule_ends,
    pose_of,
)

_TETRAHEDRA = (
    *((0, 1, 3, 7), (0, 1, 5, 7), (0, 2, 3, 7)),
    *((0, 2, 6, 7), (0, 4, 5, 7), (0, 4, 6, 7)),
)
"""Six to a cube, all along its diagonal; corner 4 x + 2 y + z is at (x, y, z)."""


@compiled(example=(FLOATS, NO_ARM, 1.0, NEW_FLOATS))
def reach_rooms(points: FloatArray, arm: ArmTable, forearm: float, rooms: FloatArray) -> None:
    """Margin of places to the arm's reach and limits, as parts of its lengths; < 0 beyond them.

    Args:
        points: flat (3 n,), [unit], world.
        arm: the arm.
        forearm: length a6, [unit].
        rooms: (n,), [unit]; written.
    """
    upper = arm.upper
    far = upper + forearm
    square = upper * upper + forearm * forearm + 2 * upper * forearm * arm.least_cosine_q3
    near = math.sqrt(max(square, 0.0))
    for i in range(len(rooms)):
        x, y, z = sub(vec3_at(points, 3 * i), (arm.x, arm.y, arm.shoulder))
        across = math.sqrt(x * x + y * y)
        reach = math.sqrt(across * across + z * z)
        room = min(far - reach, reach - near)
        if room > 0 and across > 0:
            pose = pose_of(arm, vec3_at(points, 3 * i), forearm)
            room = min(room, pose.elbow[2] - arm.shoulder - upper * arm.least_cosine_q2)
        rooms[i] = room


@compiled(example=(FLOATS, NO_ARM, NO_OBSTACLES, 1.0, FLAGS, 1.0, NEW_FLOATS))
def arm_gaps(
    points: FloatArray,
    arm: ArmTable,
    around: Obstacles,
    forearm: float,
    reached: BoolArray,
    most: float,
    gaps: FloatArray,
) -> None:
    """Least distance of the moving links to the obstacles asked for, with the tool at places.

    A box around others counts as what is in it only where it has nothing inside.

    Args:
        points: flat (3 n,), [unit], world.
        arm: the arm.
        around: what to keep clear of.
        forearm: length a6, [unit].
        reached: places to look at (n,).
        most: distances above count as this, [unit].
        gaps: (n,), [unit]; ``most`` where it is not reached; written.
    """
    capsules = arm.capsules
    count, moving = len(around.margins), len(capsules) // CAPSULE
    still, widest, out_of_upper, out_of_fore = outline(arm)
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
                    a, b = capsule_ends(arm, pose, c)
                    gaps[i] = _gap(around, s, a, b, capsules[CAPSULE * c + 3], gaps[i])


@jitable
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


@jitable
def _crossing(points: FloatArray, values: FloatArray, i: int, j: int) -> Vec3:
    """Crossing of 0 between the values of two neighbours."""
    share = values[i] / (values[i] - values[j])
    a, b = vec3_at(points, 3 * i), vec3_at(points, 3 * j)
    return axpy(share, sub(b, a), a)


@compiled(example=(FLOATS, FLOATS, 2, 2, 2))
def zero_surface(points: FloatArray, values: FloatArray, nx: int, ny: int, nz: int) -> FloatArray:
    """Triangles between the places of a grid with values <= 0 and the others.

    By tetrahedra: of each the surface is a triangle or a quadrilateral.

    Args:
        points: places, z fastest, flat (3 nx ny nz,).
        values: (nx ny nz,).
        nx, ny, nz: places along each axis.

    Returns:
        Nine numbers a triangle, flat.
    """
    found = [0.0] * 0
    inner, outer = [0, 0, 0, 0], [0, 0, 0, 0]
    for i in range(nx - 1):
        for j in range(ny - 1):
            for k in range(nz - 1):
                first = (i * ny + j) * nz + k
                low = values[first] <= 0
                same = True
                for corner in range(1, 8):
                    at = first + (corner >> 2) * ny * nz + (corner >> 1 & 1) * nz + (corner & 1)
                    same = same and (values[at] <= 0) == low
                if same:
                    continue
                for tetrahedron in _TETRAHEDRA:
                    a = b = 0
                    for corner in tetrahedron:
                        at = first + (corner >> 2) * ny * nz + (corner >> 1 & 1) * nz
                        at += corner & 1
                        if values[at] <= 0:
                            inner[a] = at
                            a += 1
                        else:
                            outer[b] = at
                            b += 1
                    if a == 0 or b == 0:
                        continue
                    p = _crossing(points, values, inner[0], outer[0])
                    if a == 2:
                        q = _crossing(points, values, inner[0], outer[1])
                        r = _crossing(points, values, inner[1], outer[1])
                        t = _crossing(points, values, inner[1], outer[0])
                        for v in (p, q, r, p, r, t):
                            found.extend(v)
                        continue
                    q = _crossing(points, values, inner[1 % a], outer[1 % b])
                    r = _crossing(points, values, inner[2 % a], outer[2 % b])
                    for v in (p, q, r):
                        found.extend(v)
    return np.array(found)
