"""Wrong solutions of the exercises: errors that students make, one each."""

from __future__ import annotations

import bisect
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from tests.abi.teach.right_students import (
    edge_by_slabs,
    elbow_by_cosines,
    elbow_by_triangle,
    knot_by_boehm,
    shortcut_farthest,
    time_by_area,
)


def nothing_is_returned(g: float, h: float) -> None:
    g + h


def edge_ends_alone(a: Any, b: Any, lower: Any, upper: Any) -> bool:
    return any(
        all(lo <= x <= hi for x, lo, hi in zip(p, lower, upper, strict=True)) for p in (a, b)
    )


def edge_at_samples(a: Any, b: Any, lower: Any, upper: Any) -> bool:
    if not edge_boxes_overlap(a, b, lower, upper):
        return False
    shares = np.linspace(0.0, 1.0, 8_000)[:, None]
    places = np.array(a) + shares * (np.array(b) - np.array(a))
    return bool(((places >= lower) & (places <= upper)).all(axis=1).any())


def edge_boxes_overlap(a: Any, b: Any, lower: Any, upper: Any) -> bool:
    rows = zip(a, b, lower, upper, strict=True)
    return all(min(p, q) <= hi and max(p, q) >= lo for p, q, lo, hi in rows)


def edge_divides_by_nothing(a: Any, b: Any, lower: Any, upper: Any) -> bool:
    first, last = 0.0, 1.0
    for p, q, lo, hi in zip(a, b, lower, upper, strict=True):
        t, u = sorted(((lo - p) / (q - p), (hi - p) / (q - p)))
        first, last = max(first, t), min(last, u)
    return first <= last


def edge_as_endless_line(a: Any, b: Any, lower: Any, upper: Any) -> bool:
    far = [p - 100 * (q - p) for p, q in zip(a, b, strict=True)]
    farther = [q + 100 * (q - p) for p, q in zip(a, b, strict=True)]
    return edge_by_slabs(far, farther, lower, upper)


def edge_one_direction(a: Any, b: Any, lower: Any, upper: Any) -> bool:
    """Does not sort the two parameters of an axis."""
    first, last = 0.0, 1.0
    for p, q, lo, hi in zip(a, b, lower, upper, strict=True):
        if p == q:
            if not lo <= p <= hi:
                return False
            continue
        first, last = max(first, (lo - p) / (q - p)), min(last, (hi - p) / (q - p))
    return first <= last


def shortcut_nearest_first(path: Any, is_clear: Any) -> Any:
    """Stops at the first point that is hidden, though later ones may be seen again."""
    found, place = [path[0]], 0
    while place < len(path) - 1:
        ahead = place + 1
        while ahead + 1 < len(path) and is_clear(path[place], path[ahead + 1]):
            ahead += 1
        place = ahead
        found.append(path[place])
    return found[:-1]


def shortcut_once(path: Any, is_clear: Any) -> Any:
    for k in range(1, len(path) - 1):
        if is_clear(path[k - 1], path[k + 1]):
            return path[:k] + path[k + 1 :]
    return path


def knot_without_weights(points: Any, knots: Any, degree: int, t: float) -> Any:
    k = bisect.bisect_right(knots, t) - 1
    middle = [
        tuple((p + q) / 2 for p, q in zip(points[i - 1], points[i], strict=True))
        for i in range(k - degree + 1, k + 1)
    ]
    return points[: k - degree + 1] + middle + points[k:]


def _knot(points: Any, knots: Any, degree: int, t: float, first: int, span: int) -> Any:
    k = bisect.bisect_right(knots, t) - 1
    new = []
    for i in range(len(points) + 1):
        if i < k - degree + first:
            new.append(points[i])
        elif i > k:
            new.append(points[i - 1])
        else:
            a = (t - knots[i]) / (knots[i + span] - knots[i])
            pairs = zip(points[i - 1], points[i], strict=True)
            new.append(tuple((1 - a) * p + a * q for p, q in pairs))
    return new


def time_never_triangular(length: float, speed: float, up: float, down: float) -> Any:
    return speed / up, (length - speed**2 / 2 * (1 / up + 1 / down)) / speed, speed / down


def elbow_on_the_other_side(r: float, z: float, upper: float, fore: float) -> Any:
    c = (r * r + z * z - upper**2 - fore**2) / (2 * upper * fore)
    if not -1 <= c <= 1:
        return None
    q2 = math.acos(c)
    return math.atan2(z, r) - math.atan2(fore * math.sin(q2), upper + fore * math.cos(q2)), q2


def elbow_by_arc_tangent(r: float, z: float, upper: float, fore: float) -> Any:
    found = elbow_by_cosines(r, z, upper, fore)
    return None if found is None else (found[0] - math.atan2(z, r) + math.atan(z / r), found[1])


def elbow_in_degrees(r: float, z: float, upper: float, fore: float) -> Any:
    found = elbow_by_cosines(r, z, upper, fore)
    return None if found is None else tuple(map(math.degrees, found))


def elbow_from_the_axis(r: float, z: float, upper: float, fore: float) -> Any:
    found = elbow_by_cosines(r, z, upper, fore)
    return None if found is None else (found[0], sum(found))


def elbow_reaches_everything(r: float, z: float, upper: float, fore: float) -> Any:
    c = (r * r + z * z - upper**2 - fore**2) / (2 * upper * fore)
    q2 = -math.acos(max(-1.0, min(1.0, c)))
    return math.atan2(z, r) - math.atan2(fore * math.sin(q2), upper + fore * math.cos(q2)), q2


def elbow_reaches_nearer(r: float, z: float, upper: float, fore: float) -> Any:
    short = math.hypot(r, z) < abs(upper - fore) / 2
    return None if short else elbow_stretched(r, z, upper, fore)


def elbow_stretched(r: float, z: float, upper: float, fore: float) -> Any:
    if math.hypot(r, z) > 1.02 * (upper + fore):
        return None
    return elbow_reaches_everything(r, z, upper, fore)


def elbow_without_a_way_out(r: float, z: float, upper: float, fore: float) -> Any:
    q2 = -math.acos((r * r + z * z - upper**2 - fore**2) / (2 * upper * fore))
    return math.atan2(z, r) - math.atan2(fore * math.sin(q2), upper + fore * math.cos(q2)), q2


def elbow_by_wrong_cosines(r: float, z: float, upper: float, fore: float) -> Any:
    found = elbow_by_triangle(r, z, upper, fore)
    return None if found is None else (found[0], found[1] + math.pi)


WRONG: tuple[tuple[str, Callable[..., Any]], ...] = (
    ("priority", lambda g, h: g),
    ("priority", lambda g, h: h),
    ("priority", lambda g, h: g - h),
    ("priority", lambda g, h: -(g + h)),
    ("priority", lambda g, h: g + 2 * h),
    ("priority", lambda g, h: g + 1.001 * h),
    ("priority", lambda g, h: g + 0.999 * h),
    ("priority", lambda g, h: max(g, h)),
    ("priority", lambda g, h: g * h),
    ("priority", lambda g, h: round(g + h)),
    ("priority", lambda g, h: (h, g + h)),
    ("priority", nothing_is_returned),
    ("heuristic", lambda node, goal: sum(abs(a - b) for a, b in zip(node, goal, strict=True))),
    ("heuristic", lambda node, goal: 1.05 * math.dist(node, goal)),
    ("heuristic", lambda node, goal: math.dist(node, goal) ** 2),
    ("heuristic", lambda node, goal: math.dist(node, (0, 0, 0))),
    ("heuristic", lambda node, goal: 1.0),
    ("heuristic", lambda node, goal: 0.0),
    ("heuristic", lambda node, goal: float("nan")),
    ("heuristic", lambda node, goal: math.dist(node, goal) + 1),
    ("heuristic", lambda node, goal: -math.dist(node, goal)),
    ("heuristic", lambda node, goal: round(math.dist(node, goal))),
    ("heuristic", lambda node, goal: sum(b - a for a, b in zip(node, goal, strict=True))),
    ("edge_test", edge_ends_alone),
    ("edge_test", edge_at_samples),
    ("edge_test", edge_boxes_overlap),
    ("edge_test", edge_divides_by_nothing),
    ("edge_test", edge_as_endless_line),
    ("edge_test", edge_one_direction),
    ("edge_test", lambda *given: not edge_by_slabs(*given)),
    ("edge_test", lambda *given: None),
    ("shortcut", lambda path, is_clear: path),
    ("shortcut", lambda path, is_clear: [path[0], path[-1]]),
    ("shortcut", lambda path, is_clear: path[::2]),
    ("shortcut", shortcut_nearest_first),
    ("shortcut", shortcut_once),
    ("shortcut", lambda path, is_clear: shortcut_farthest(path[::-1], is_clear)),
    ("knot_insertion", lambda points, knots, degree, t: points),
    ("knot_insertion", knot_without_weights),
    ("knot_insertion", lambda p, u, n, t: _knot(p, u, n, t, first=2, span=n)),
    ("knot_insertion", lambda p, u, n, t: _knot(p, u, n, t, first=1, span=n + 1)),
    ("knot_insertion", lambda *given: knot_by_boehm(*given)[1:]),
    ("time_law", time_never_triangular),
    ("time_law", lambda s, v, up, down: time_by_area(s, v, up, up)),
    ("time_law", lambda s, v, up, down: time_by_area(s, v, down, up)),
    ("time_law", lambda s, v, up, down: (v / up, (s - v**2 / up - v**2 / down) / v, v / down)),
    ("time_law", lambda s, v, up, down: tuple(np.cumsum(time_by_area(s, v, up, down)))),
    ("time_law", lambda s, v, up, down: time_by_area(s, v / 2, up, down)),
    ("elbow", elbow_on_the_other_side),
    ("elbow", elbow_by_arc_tangent),
    ("elbow", elbow_in_degrees),
    ("elbow", elbow_from_the_axis),
    ("elbow", elbow_reaches_everything),
    ("elbow", elbow_reaches_nearer),
    ("elbow", elbow_stretched),
    ("elbow", elbow_without_a_way_out),
    ("elbow", elbow_by_wrong_cosines),
)
"""Name of the exercise, and a wrong solution."""
