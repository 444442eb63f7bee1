"""Exercise: insert a knot without changing the curve."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from abi.arrays import FloatArray
from abi.scene.scene import Scene
from abi.search.search import search
from abi.teach.exercise import Counterexample, Exercise, Trial
from abi.teach.hidden_scenes import graph_of, hidden_scenes
from abi.teach.numbers import are_points, point, shown, text

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

_FEWEST_HOPS = 5
_CALLS = 6
_SAMPLES = 41
_ROUNDING = 1e-7


def _trials(seed: int) -> tuple[Trial, ...]:
    return tuple(_trial(one, seed + k) for k, one in enumerate(hidden_scenes(seed)))


def _trial(one: Scene, seed: int) -> Trial:
    """Clamped splines whose control points are a path's corners, and places for a knot."""
    random = np.random.default_rng(seed)
    points = search("dijkstra", graph_of(one), "length").points
    while len(points) < _FEWEST_HOPS:
        points = np.insert(points, 1, points[:2].mean(axis=0), axis=0)
    calls = []
    for number in range(_CALLS):
        degree = 2 + number % 3
        count = len(points) - degree
        inner = (
            np.sort(random.uniform(0.05, 0.95, count - 1))
            if number % 2
            else (np.arange(1, count) / count)
        )
        knots = np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])
        place = float(random.uniform(0.01, 0.99))
        if number == _CALLS - 1 and len(inner):
            place = float(inner[len(inner) // 2])  # once more where a knot is already
        calls.append((points.tolist(), knots.tolist(), degree, place))
    return Trial(one, tuple(calls))


def _judge(trial: Trial, values: list[Any]) -> Counterexample | None:
    cases = (_case(trial, call, value) for call, value in enumerate(values))
    return next((case for case in cases if case is not None), None)


def _case(trial: Trial, call: int, value: Any) -> Counterexample | None:
    points, knots, degree, place = trial.calls[call]
    asked = f"One more knot, at t = {text(place)}, in a curve of degree {degree}"
    if not are_points(value):
        return trial.wrong(
            f"{asked}: it returns {shown(value)}, not a list of points (x, y, z).", call
        )
    wanted = len(points) + 1
    if len(value) != wanted:
        return trial.wrong(
            f"{asked} turns {len(points)} control points into {wanted}; yours are {len(value)}.",
            *(call, str(len(value)), str(wanted)),
        )
    longer = np.sort([*knots, place])
    parameters = np.linspace(0.0, 1.0, _SAMPLES)
    before = curve(np.array(points), np.array(knots), degree)(parameters)
    after = curve(np.array(value), longer, degree)(parameters)
    away = np.linalg.norm(after - before, axis=1)
    worst = int(away.argmax())
    if away[worst] <= _ROUNDING * max(1.0, float(np.abs(points).max())):
        return None
    return trial.wrong(
        f"{asked} with {len(points)} control points must leave the curve where it was. At the "
        f"parameter {text(parameters[worst])} it was at {point(before[worst])}; with your control "
        f"points it is at {point(after[worst])}.",
        *(call, point(after[worst]), point(before[worst])),
    )


def curve(points: FloatArray, knots: FloatArray, degree: int) -> BSpline:
    """The curve of control points and knots."""
    from scipy.interpolate import BSpline  # takes longer to load than a page's first plan

    return BSpline(knots, points, degree)


KNOT_INSERTION = Exercise(
    name="knot_insertion",
    title="A knot more, to keep a clearance",
    task=(
        "Where the curve is too near an obstacle, one more knot gives one more control point to "
        "push. Return the control points, one more than before, with which the curve of this "
        "degree and the knots with t among them is the same as before. Points are (x, y, z); the "
        "knots do not fall, and t is between two of them."
    ),
    starter=(
        "def knot_insertion(points, knots, degree, t):\n"
        "    k = max(i for i in range(len(points)) if knots[i] <= t)  # the span of t\n"
        "    return points[: k + 1] + [points[k]] + points[k + 1 :]  # the wrong places\n"
    ),
    lesson="04-bspline",
    caller="alone",
    trials=_trials,
    judge=_judge,
)
