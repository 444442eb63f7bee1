"""Inverse kinematics of the paper's arm along a path."""

from __future__ import annotations

import math

from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, NEW_FLOATS, compiled


@jitable
def _distance_to_axis(points: FloatArray, tangents: FloatArray, i: int) -> float:
    """Distance from the z axis to the cubic that joins points i and i + 1 as directed."""
    k = 3 * i
    chord, product = 0.0, 0.0
    for j in range(k, k + 3):
        chord += (points[j + 3] - points[j]) ** 2
        product += tangents[j] * tangents[j + 3]
    half = math.acos(min(1.0, max(-1.0, product))) / 2
    # The length of the circular arc with these end tangents: the cubic is then exact to 4th order.
    length = math.sqrt(chord) * (half / math.sin(half) if half > 1e-6 else 1.0)
    low, high, least = 0.0, 1.0, math.inf
    for _ in range(14):
        # Zoom in on the best of 17 places; each round is 8 times closer.
        best, least = 0, math.inf
        for place in range(17):
            t = low + (high - low) * place / 16
            away = 0.0
            for j in (k, k + 1):
                step, start, end = points[j + 3] - points[j], tangents[j], tangents[j + 3]
                bent = 3 * step - length * (2 * start + end)
                turned = length * (start + end) - 2 * step
                away += (points[j] + t * (length * start + t * (bent + t * turned))) ** 2
            if away < least:
                best, least = place, away
        step = (high - low) / 16
        low, high = low + step * max(best - 1, 0), low + step * min(best + 1, 16)
    return math.sqrt(least)


@jitable
def _fill(q1: FloatArray, first: int, last: int, before: int) -> None:
    """Write the angles of points on the axis, evenly between those of its neighbours.

    Args:
        q1: (n,), [rad]; written between.
        first: the first point on the axis.
        last: the point behind it that is not on the axis.
        before: the point before it that is not, -1 if there is none.
    """
    for j in range(first, last):
        share = (j - before) / (last - before) if before >= 0 else 1.0
        q1[j] = (1 - share) * q1[max(before, 0)] + share * q1[last]


@jitable
def _head(tangents: FloatArray, across: FloatArray, q1: FloatArray, turned: bool) -> None:
    """Turn points on the axis to where the path goes there, up to half turns.

    Args:
        tangents: directions of the path, flat (3 n,), unit vectors or zero.
        across: signed distance from the axis (n,), [unit].
        q1: (n,), [rad]; changed.
        turned: whether there are neighbours whose angles tell the half turns.
    """
    for i in range(len(q1)):
        x, y = tangents[3 * i], tangents[3 * i + 1]
        if across[i] == 0 and math.hypot(x, y) > 1e-9:
            heading = math.atan2(x, -y)
            halves = round((q1[i] - heading) / math.pi) if turned else 0
            q1[i] = heading + math.pi * halves


@compiled(example=(FLOATS, FLOATS, 0.0, 0.0, NEW_FLOATS, NEW_FLOATS))
def base_angle(
    points: FloatArray,
    tangents: FloatArray,
    rounding: float,
    through: float,
    q1: FloatArray,
    across: FloatArray,
) -> None:
    """Angle about the base axis along a path, and distance from it (``inverse_kinematics``).

    Args:
        points: from the shoulder, flat (3 n,), [unit].
        tangents: directions of the path, flat (3 n,), unit vectors or zero.
        rounding: points nearer to the axis are on it, [unit].
        through: a path that passes it nearer than this goes through it, [unit].
        q1: unwrapped along the path (n,), [rad]; written.
        across: signed distance from the axis (n,), [unit]; written.
    """
    count, last = len(q1), -1
    behind, turns, before = 0, 0, 0.0
    for i in range(count):
        x, y = points[3 * i], points[3 * i + 1]
        distance = math.hypot(x, y)
        across[i] = 0.0
        if distance <= rounding:
            continue
        angle = math.atan2(x, -y)
        if last >= 0:
            step = angle - before
            flips = abs(step - 2 * math.pi * round(step / (2 * math.pi))) > math.pi / 2
            if flips and i == last + 1:
                flips = _distance_to_axis(points, tangents, last) <= through
            if flips:
                behind += 1
                step += math.pi
            turns += round(step / (2 * math.pi))
        before = angle
        q1[i] = angle + math.pi * behind - 2 * math.pi * turns
        across[i] = distance if behind % 2 == 0 else -distance
        if last + 1 < i:
            _fill(q1, last + 1, i, last)
        last = i
    for j in range(last + 1, count):
        q1[j] = q1[last] if last >= 0 else 0.0
    # All on the axis: a single point may still know where it is going.
    if last >= 0 or count == 1:
        _head(tangents, across, q1, last >= 0)


@compiled(example=(FLOATS, FLOATS, FLOATS, 1.0, 1.0, 0.0, NEW_FLOATS))
def elbow_angles(
    across: FloatArray,
    height: FloatArray,
    forearm: FloatArray,
    upper: float,
    side: float,
    rounding: float,
    found: FloatArray,
) -> None:
    """Shoulder and elbow that put the tool at places of the arm's plane (``inverse_kinematics``).

    Args:
        across: the tool's signed distance from the base axis (n,), [unit].
        height: of the tool above the shoulder (n,), [unit].
        forearm: a6 (n,), [unit].
        upper: a3, [unit].
        side: the sign of q3.
        rounding: shortfalls up to this are none, [unit].
        found: q2, unwrapped along the path (n,), [rad], then q3 (n,), [rad], then the shortfall
            (n,), [unit]; written.
    """
    count = len(across)
    turned, last = 0.0, 0.0
    for i in range(count):
        a6 = forearm[i]
        distance = math.hypot(across[i], height[i])
        short = max(distance - (upper + abs(a6)), 0.0) - max(abs(upper - abs(a6)) - distance, 0.0)
        stretch, fold = upper + a6, upper - a6
        # A force that pulls can make a6 negative: the tool is then behind the elbow.
        sign = 1.0 if a6 > 0 else -1.0 if a6 < 0 else 0.0
        folded = sign * (stretch - distance) * (stretch + distance)
        stretched = sign * (distance - fold) * (distance + fold)
        half = math.atan2(math.sqrt(max(folded, 0.0)), math.sqrt(max(stretched, 0.0)))
        q3 = 2 * side * half
        angle = math.atan2(across[i], height[i])
        if i > 0 and abs(angle - last) > math.pi:
            turned += -2 * math.pi if angle > last else 2 * math.pi
        last = angle
        lead = math.atan2(a6 * math.sin(q3), upper + a6 * math.cos(q3))
        found[i] = angle + turned - lead
        found[count + i] = q3
        found[2 * count + i] = short if abs(short) > rounding else 0.0
