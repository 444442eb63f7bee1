"""Right solutions of the exercises, each different from the others."""

from __future__ import annotations

import bisect
import math
from collections.abc import Callable
from typing import Any

import numpy as np


def priority_tie_by_h(g: float, h: float) -> Any:
    return g + h, h


def priority_tie_by_g(g: float, h: float) -> Any:
    return round(g + h, 9), -g


def heuristic_by_hand(node: Any, goal: Any) -> float:
    x, y, z = (b - a for a, b in zip(node, goal, strict=True))
    return float((x * x + y * y + z * z) ** 0.5)


def heuristic_largest(node: Any, goal: Any) -> Any:
    return max(abs(a - b) for a, b in zip(node, goal, strict=True))


def heuristic_in_two_planes(node: Any, goal: Any) -> float:
    x, y, z = (b - a for a, b in zip(node, goal, strict=True))
    return max(math.hypot(x, y), math.hypot(y, z), math.hypot(x, z))


def edge_by_slabs(a: Any, b: Any, lower: Any, upper: Any) -> bool:
    first, last = 0.0, 1.0
    for p, q, lo, hi in zip(a, b, lower, upper, strict=True):
        if p == q:
            if p < lo or p > hi:
                return False
        else:
            t, u = (lo - p) / (q - p), (hi - p) / (q - p)
            first, last = max(first, min(t, u)), min(last, max(t, u))
    return first <= last


def edge_with_infinities(a: Any, b: Any, lower: Any, upper: Any) -> Any:
    p, d = np.array(a), np.array(b) - np.array(a)
    with np.errstate(divide="ignore", invalid="ignore"):
        t, u = (np.array(lower) - p) / d, (np.array(upper) - p) / d
    flat = d == 0
    if ((p < lower) | (p > upper))[flat].any():
        return False
    enter = np.where(flat, 0.0, np.minimum(t, u)).max(initial=0.0)
    leave = np.where(flat, 1.0, np.maximum(t, u)).min(initial=1.0)
    return enter <= leave


def edge_by_separating_axes(a: Any, b: Any, lower: Any, upper: Any) -> bool:
    half = (np.array(upper) - lower) / 2
    middle = (np.array(a) + b) / 2 - (np.array(upper) + lower) / 2
    arm = (np.array(b) - a) / 2
    if (np.abs(middle) > half + np.abs(arm)).any():
        return False
    for i, j in ((0, 1), (1, 2), (2, 0)):
        away = abs(middle[i] * arm[j] - middle[j] * arm[i])
        if away > half[i] * abs(arm[j]) + half[j] * abs(arm[i]) + 1e-12:
            return False
    return True


def edge_by_clipping(a: Any, b: Any, lower: Any, upper: Any) -> bool:
    p, q = list(a), list(b)
    for k in range(3):
        if p[k] > q[k]:
            p, q = q, p
        if q[k] < lower[k] or p[k] > upper[k]:
            return False
        start, end = list(p), list(q)
        if p[k] < lower[k]:
            share = (lower[k] - p[k]) / (q[k] - p[k])
            start = [s + share * (e - s) for s, e in zip(p, q, strict=True)]
        if q[k] > upper[k]:
            share = (upper[k] - p[k]) / (q[k] - p[k])
            end = [s + share * (e - s) for s, e in zip(p, q, strict=True)]
        p, q = start, end
    return True


def shortcut_farthest(path: Any, is_clear: Any) -> Any:
    found, place = [path[0]], 0
    while place < len(path) - 1:
        place = next(k for k in range(len(path) - 1, place, -1) if is_clear(path[place], path[k]))
        found.append(path[place])
    return found


def shortcut_until_nothing_goes(path: Any, is_clear: Any) -> Any:
    path = list(path)
    again = True
    while again:
        again = False
        for k in range(1, len(path) - 1):
            if is_clear(path[k - 1], path[k + 1]):
                del path[k]
                again = True
                break
    return path


def shortcut_backwards(path: Any, is_clear: Any) -> Any:
    return shortcut_farthest(path[::-1], is_clear)[::-1]


def shortcut_shortest(path: Any, is_clear: Any) -> Any:
    best = {0: (0.0, [path[0]])}
    for k in range(1, len(path)):
        ways = [
            (length + math.dist(path[j], path[k]), [*points, path[k]])
            for j, (length, points) in best.items()
            if is_clear(path[j], path[k])
        ]
        best[k] = min(ways)
    return shortcut_until_nothing_goes(best[len(path) - 1][1], is_clear)


def knot_by_boehm(points: Any, knots: Any, degree: int, t: float) -> Any:
    k = bisect.bisect_right(knots, t) - 1
    new = []
    for i in range(len(points) + 1):
        if i <= k - degree:
            new.append(points[i])
        elif i > k:
            new.append(points[i - 1])
        else:
            a = (t - knots[i]) / (knots[i + degree] - knots[i])
            pairs = zip(points[i - 1], points[i], strict=True)
            new.append(tuple((1 - a) * p + a * q for p, q in pairs))
    return new


def knot_with_arrays(points: Any, knots: Any, degree: int, t: float) -> Any:
    p, u = np.array(points), np.array(knots)
    k = int(np.searchsorted(u, t, side="right")) - 1
    i = np.arange(k - degree + 1, k + 1)
    a = ((t - u[i]) / (u[i + degree] - u[i]))[:, None]
    return np.concatenate([p[: k - degree + 1], (1 - a) * p[i - 1] + a * p[i], p[k:]])


def knot_by_scipy(points: Any, knots: Any, degree: int, t: float) -> Any:
    from scipy.interpolate import insert

    columns = [
        insert(t, (np.array(knots), np.append(column, np.zeros(degree + 1)), degree))[1]
        for column in np.array(points).T
    ]
    return np.stack(columns, axis=1)[: len(points) + 1]


def knot_by_blossom(points: Any, knots: Any, degree: int, t: float) -> Any:
    """Control point i is the blossom of the next knots after u_i."""
    longer = sorted([*knots, t])
    k = bisect.bisect_right(knots, t) - 1
    new = []
    for i in range(len(points) + 1):
        if i <= k - degree or i > k:
            new.append(points[i] if i <= k - degree else points[i - 1])
            continue
        level = {j: np.array(points[j]) for j in range(k - degree, k + 1)}
        for r, at in enumerate(longer[i + 1 : i + degree + 1], 1):
            level = {
                j: level[j - 1]
                + (at - knots[j])
                / (knots[j + degree + 1 - r] - knots[j])
                * (level[j] - level[j - 1])
                for j in range(k - degree + r, k + 1)
            }
        new.append(level[k])
    return new


def time_by_area(length: float, speed: float, acceleration: float, deceleration: float) -> Any:
    t1, t3 = speed / acceleration, speed / deceleration
    ramps = speed * (t1 + t3) / 2
    if ramps <= length:
        return t1, (length - ramps) / speed, t3
    peak = (2 * length / (1 / acceleration + 1 / deceleration)) ** 0.5
    return peak / acceleration, 0, peak / deceleration


def time_as_array(length: float, speed: float, acceleration: float, deceleration: float) -> Any:
    rate = 2 * acceleration * deceleration / (acceleration + deceleration)
    peak = min(speed, np.sqrt(rate * length))
    return np.array(
        [peak / acceleration, max(0.0, (length - peak**2 / rate) / peak), peak / deceleration]
    )


def time_by_halving(length: float, speed: float, acceleration: float, deceleration: float) -> Any:
    low, high = 0.0, speed
    for _ in range(200):
        peak = (low + high) / 2
        fits = peak**2 / 2 / acceleration + peak**2 / 2 / deceleration <= length
        low, high = (peak, high) if fits else (low, peak)
    cruise = (length - low**2 / 2 / acceleration - low**2 / 2 / deceleration) / low
    return [low / acceleration, cruise, low / deceleration]


def time_by_torricelli(
    length: float, speed: float, acceleration: float, deceleration: float
) -> Any:
    up = min(speed**2 / (2 * acceleration), length * deceleration / (acceleration + deceleration))
    down = up * acceleration / deceleration
    peak = math.sqrt(2 * acceleration * up)
    return 2 * up / peak, abs(length - up - down) / peak, 2 * down / peak


def elbow_by_cosines(r: float, z: float, upper: float, fore: float) -> Any:
    c = (r * r + z * z - upper**2 - fore**2) / (2 * upper * fore)
    if not -1 <= c <= 1:
        return None
    q2 = -math.acos(c)
    return math.atan2(z, r) - math.atan2(fore * math.sin(q2), upper + fore * math.cos(q2)), q2


def elbow_by_triangle(r: float, z: float, upper: float, fore: float) -> Any:
    d = math.hypot(r, z)
    if d > upper + fore or d < abs(upper - fore):
        return None
    at_shoulder = math.acos((upper**2 + d**2 - fore**2) / (2 * upper * d))
    at_elbow = math.acos((upper**2 + fore**2 - d**2) / (2 * upper * fore))
    return math.atan2(z, r) + at_shoulder, at_elbow - math.pi


def elbow_by_circles(r: float, z: float, upper: float, fore: float) -> Any:
    d2 = r * r + z * z
    along = (d2 + upper**2 - fore**2) / 2 / d2
    square = upper**2 / d2 - along**2
    if square < 0:
        return None
    x, y = along * r - square**0.5 * z, along * z + square**0.5 * r
    shoulder = np.arctan2(y, x)
    return [shoulder, np.arctan2(z - y, r - x) - shoulder]


def elbow_with_complex_numbers(r: float, z: float, upper: float, fore: float) -> Any:
    tip = complex(r, z)
    c = (abs(tip) ** 2 - upper**2 - fore**2) / (2 * upper * fore)
    if abs(c) > 1:
        return None
    bend = complex(c, -((1 - c * c) ** 0.5))
    shoulder = tip / (upper + fore * bend)
    return math.atan2(shoulder.imag, shoulder.real) + 2 * math.pi, math.atan2(bend.imag, bend.real)


RIGHT: tuple[tuple[str, Callable[..., Any]], ...] = (
    ("priority", lambda g, h: g + h),
    ("priority", lambda g, h: h + g),
    ("priority", lambda g, h: 3 * (g + h) - 7),
    ("priority", lambda g, h: np.float64(g) + h),
    ("priority", priority_tie_by_h),
    ("priority", priority_tie_by_g),
    ("heuristic", math.dist),
    ("heuristic", heuristic_by_hand),
    ("heuristic", heuristic_largest),
    ("heuristic", heuristic_in_two_planes),
    ("heuristic", lambda node, goal: np.linalg.norm(np.array(node) - goal)),
    ("heuristic", lambda node, goal: 0.9 * math.dist(node, goal)),
    ("edge_test", edge_by_slabs),
    ("edge_test", edge_with_infinities),
    ("edge_test", edge_by_separating_axes),
    ("edge_test", edge_by_clipping),
    ("shortcut", shortcut_farthest),
    ("shortcut", shortcut_until_nothing_goes),
    ("shortcut", shortcut_backwards),
    ("shortcut", shortcut_shortest),
    ("knot_insertion", knot_by_boehm),
    ("knot_insertion", knot_with_arrays),
    ("knot_insertion", knot_by_scipy),
    ("knot_insertion", knot_by_blossom),
    ("time_law", time_by_area),
    ("time_law", time_as_array),
    ("time_law", time_by_halving),
    ("time_law", time_by_torricelli),
    ("elbow", elbow_by_cosines),
    ("elbow", elbow_by_triangle),
    ("elbow", elbow_by_circles),
    ("elbow", elbow_with_complex_numbers),
)
"""Name of the exercise, and a right solution."""
