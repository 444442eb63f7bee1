"""Answers to the questions of every template, by other libraries or by trying everything."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from types import MappingProxyType
from typing import Any

import networkx
import numpy as np
import scipy.interpolate
import scipy.optimize

from abi.teach.quiz.question import QuizQuestion

Facts = Mapping[str, Any]


def answer(template: str, question: QuizQuestion) -> int:
    """Number of the choice that is right; -1 where none is, or more than one."""
    right = _ORACLES[template](question.facts)
    found = [k for k, choice in enumerate(question.choices) if _is(choice, right)]
    return found[0] if len(found) == 1 else -1


def _is(choice: str, right: str | float | int | list[float]) -> bool:
    if isinstance(right, str):
        return choice == right
    words = choice.replace("−", "-").strip("()").replace(",", " ").split()
    numbers = []
    for word in words:
        try:
            numbers.append(float(word))
        except ValueError:
            continue
    wanted = right if isinstance(right, list) else [right]
    return len(numbers) == len(wanted) and all(
        math.isclose(a, b, rel_tol=6e-4, abs_tol=1e-9) for a, b in zip(numbers, wanted, strict=True)
    )


def _graph(facts: Facts) -> networkx.Graph:
    graph = networkx.Graph()
    graph.add_weighted_edges_from(facts["edges"])
    return graph


def _last(facts: Facts) -> int:
    return int(max(max(a, b) for a, b, _ in facts["edges"]))


def _shortest_length(facts: Facts) -> int:
    return int(networkx.dijkstra_path_length(_graph(facts), 0, _last(facts)))


def _fewest_edges(facts: Facts) -> int:
    return int(networkx.shortest_path_length(_graph(facts), 0, _last(facts)))


def _expansion_order(facts: Facts) -> str:
    costs = networkx.single_source_dijkstra_path_length(_graph(facts), 0)
    order = sorted(costs, key=costs.__getitem__)[: facts["count"]]
    return ", ".join(chr(ord("A") + node) for node in order)


def _bellman_ford_round(facts: Facts) -> int:
    """The least of all walks of so many edges, by powers of the matrix in (min, +)."""
    n = _last(facts) + 1
    steps = np.full((n, n), np.inf)
    np.fill_diagonal(steps, 0.0)
    for a, b, length in facts["edges"]:
        steps[a, b] = steps[b, a] = length
    costs = np.full(n, np.inf)
    costs[0] = 0.0
    for _ in range(facts["rounds"]):
        costs = (costs[:, None] + steps).min(axis=0)
    return int(costs[facts["node"]])


def _next_node(facts: Facts) -> str:
    sums: dict[str, Callable[[float, float], float]] = {
        "A*": lambda g, h: g + h,
        "Dijkstra's algorithm": lambda g, h: g,
        "greedy best-first search": lambda g, h: h,
    }
    priority = sums[facts["search"]]
    numbers: dict[str, tuple[float, float]] = facts["numbers"]
    return min(numbers, key=lambda place: priority(*numbers[place]))


def _priority_of_node(facts: Facts) -> float:
    node, parent, goal = facts["places"]
    g, h = float(facts["before"]) + math.dist(node, parent), math.dist(node, goal)
    return {"g": g, "h": h, "f": g + h}[str(facts["asked"])]


def _edge_passes(facts: Facts) -> str:
    """Exactly, at the parameters at which a segment may enter or leave the box."""
    a, b = ([Fraction(x) for x in end] for end in facts["ends"])
    low, high = ([Fraction(x) for x in corner] for corner in facts["box"])
    shares = {Fraction(0), Fraction(1)}
    for p, q, lo, hi in zip(a, b, low, high, strict=True):
        if p != q:
            shares |= {(lo - p) / (q - p), (hi - p) / (q - p)}
    inside = any(
        all(lo <= p + s * (q - p) <= hi for p, q, lo, hi in zip(a, b, low, high, strict=True))
        for s in shares
        if 0 <= s <= 1
    )
    return "It meets it." if inside else "It keeps clear of it."


def _box_distance(facts: Facts) -> float:
    """By a search for the nearest point of the box."""
    low, high = facts["box"]
    place = np.array(facts["place"])
    found = scipy.optimize.minimize(
        lambda x: ((x - place) ** 2).sum(),
        (np.array(low) + high) / 2,
        jac=lambda x: 2 * (x - place),
        bounds=list(zip(low, high, strict=True)),
        tol=1e-14,
    )
    return math.sqrt(found.fun)


def _consistent(facts: Facts) -> str:
    for name, length, (before, after) in zip(
        ("PQ", "RS", "TU"), facts["lengths"], facts["h"], strict=True
    ):
        if before > length + after:
            return f"Not along {name}"
    return "Along all three it is."


def _spline(facts: Facts, points: Any) -> scipy.interpolate.BSpline:
    degree, count = facts["degree"], len(points)
    knots = [0.0] * degree + np.linspace(0, 1, count - degree + 1).tolist() + [1.0] * degree
    return scipy.interpolate.BSpline(knots, np.array(points, float), degree)


def _pieces_moved(facts: Facts) -> int:
    """Pieces in which the curve of one control point is anywhere but 0."""
    points = np.zeros(facts["points"])
    points[facts["number"]] = 1.0
    pieces = facts["points"] - facts["degree"]
    curve = _spline(facts, points)
    inside = np.arange(1, 20) / 20
    return sum(bool(np.abs(curve((k + inside) / pieces)).max() > 1e-9) for k in range(pieces))


def _points_influencing(facts: Facts) -> int:
    units = np.eye(facts["points"])
    values = _spline(facts, units)(facts["parameter"])
    return int((np.abs(values) > 1e-12).sum())


def _points_after_knot(facts: Facts) -> int:
    before = np.array(facts["points"])
    after = _spline(facts, before).insert_knot(facts["place"]).c
    away = np.linalg.norm(after[:, None] - before[None], axis=2).min(axis=1)
    return int((away > 1e-9).sum())


def _point_of_curve(facts: Facts) -> list[float]:
    curve = _spline({"degree": 2}, facts["points"])
    return [float(x) for x in curve(facts["parameter"])]


def _fastest(facts: Facts) -> tuple[float, float]:
    """Duration and peak of the fastest motion, by trying peaks."""
    length, up, down = (float(facts[name]) for name in ("length", "up", "down"))

    def duration(peak: float) -> float:
        ramps = peak * peak / 2 * (1 / up + 1 / down)
        return peak / up + peak / down + (length - ramps) / peak

    top = scipy.optimize.brentq(
        lambda v: v * v / 2 / up + v * v / 2 / down - length, 1e-6, 1e3, xtol=1e-13
    )
    peaks = np.linspace(1e-3, min(top, facts["speed"]), 2001)
    best = min(peaks.tolist(), key=duration)
    return duration(best), best


def _speed_limit_hit(facts: Facts) -> str:
    _, peak = _fastest(facts)
    if peak >= facts["speed"] - 1e-9:
        return "At the end of the first phase; then it cruises."
    return "Nowhere: the way is too short."


def _tip(facts: Facts) -> tuple[complex, complex]:
    """Elbow and tip of the arm, seen from its shoulder, by turning complex numbers."""
    upper, fore = facts["links"]
    shoulder, elbow = map(math.radians, facts["angles"])
    joint = upper * complex(math.cos(shoulder), math.sin(shoulder))
    return joint, joint + fore * complex(math.cos(shoulder + elbow), math.sin(shoulder + elbow))


def _which_elbow(facts: Facts) -> str:
    joint, tip = _tip(facts)
    return "Above it" if joint.imag > tip.imag / tip.real * joint.real else "Below it"


def _reachable_distance(facts: Facts) -> float:
    return abs(_tip({"links": facts["links"], "angles": (0.0, facts["bend"])})[1])


_ORACLES: Mapping[str, Callable[[Facts], str | float | int | list[float]]] = MappingProxyType(
    {
        "edge_passes": _edge_passes,
        "box_distance": _box_distance,
        "shortest_length": _shortest_length,
        "fewest_edges": _fewest_edges,
        "expansion_order": _expansion_order,
        "bellman_ford_round": _bellman_ford_round,
        "next_node": _next_node,
        "priority_of_node": _priority_of_node,
        "consistent": _consistent,
        "pieces_moved": _pieces_moved,
        "points_influencing": _points_influencing,
        "points_after_knot": _points_after_knot,
        "point_of_curve": _point_of_curve,
        "speed_limit_hit": _speed_limit_hit,
        "peak_speed": lambda facts: _fastest(facts)[1],
        "duration": lambda facts: _fastest(facts)[0],
        "which_elbow": _which_elbow,
        "reachable_distance": _reachable_distance,
    }
)
"""The other way to an answer, by template."""
ORACLES = frozenset(_ORACLES)
