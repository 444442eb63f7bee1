"""Exercise: whether an edge of the mesh meets a box."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from abi.arrays import FloatArray
from abi.scene.scene import Scene
from abi.teach.boxes import segment_meets
from abi.teach.exercise import Counterexample, Exercise, Trial
from abi.teach.hidden_scenes import boxes_of, graph_of, hidden_scenes
from abi.teach.numbers import point, shown, text

_NEAR = Fraction(1, 10**6)
"""Amount by which a box is grown or shrunk, [unit], to leave out edges that this decides
otherwise."""
_EDGES = 60
_SHAVES = 6
"""Segments of a scene that cut so little off a box that samples miss it."""
_TIE = 1e-9
"""Difference of distances that counts as a tie, [unit]."""


def _trials(seed: int) -> tuple[Trial, ...]:
    return tuple(_trial(one, seed + k) for k, one in enumerate(hidden_scenes(seed)))


def _trial(one: Scene, seed: int) -> Trial:
    """Edges of the mesh, along axes and across, and segments that cut a box's corner."""
    random = np.random.default_rng(seed)
    low, high = boxes_of(one)[0]
    mesh = graph_of(one).mesh
    chosen = mesh.points[random.permutation(mesh.edges)[:_EDGES]]
    calls, facts = [], []
    box = np.array([low, high])
    given = np.concatenate([chosen, _across_corners(random, box), _along_edges(random, box)])
    for a, b in given.tolist():
        meets = _meets(a, b, low, high, Fraction(0))
        if all(_meets(a, b, low, high, grown) == meets for grown in (_NEAR, -_NEAR)):
            calls.append((a, b, low, high))
            facts.append(meets)
    return Trial(one, tuple(calls), {"meets": tuple(facts)})


def _across_corners(random: np.random.Generator, box: FloatArray) -> FloatArray:
    """Segments (n, 2, 3) near corners of a box, from one face to the next or just past both."""
    corner = box[random.integers(0, 2, (_EDGES, 3)), np.arange(3)]
    middle = corner + random.normal(0.0, 0.08, (_EDGES, 3))
    half = random.normal(0.0, 0.8, (_EDGES, 3))
    return np.stack([middle - half, middle + half], axis=1).round(3)


def _along_edges(random: np.random.Generator, box: FloatArray) -> FloatArray:
    """Segments (n, 2, 3) across an edge of a box, of which 1e-5 to 1e-4 is inside, or misses it."""
    found = []
    for axis in random.integers(0, 3, _SHAVES).tolist():
        one, other = (axis + 1) % 3, (axis + 2) % 3
        upper = random.integers(0, 2, 3)
        place = box[upper, np.arange(3)]
        place[axis] = box[0, axis] + random.uniform(0.3, 0.7) * np.ptp(box[:, axis])
        outward, half = np.where(upper, 1.0, -1.0), np.zeros(3)
        outward[axis] = 0.0
        half[[axis, one, other]] = random.uniform(-0.5, 0.5), outward[other], -outward[one]
        half *= random.uniform(0.5, 0.8)
        # beneath an edge what is inside is twice as long as it is deep
        share = 10 ** random.uniform(-5.0, -4.0) * random.choice([-1.0, 1.0])
        middle = place - share * abs(half[one]) * outward
        found.append([middle - half, middle + half])
    return np.array(found).round(7)


def _meets(a: Any, b: Any, low: Any, high: Any, grown: Fraction) -> bool:
    """Check exactly whether a segment meets a box that is grown on each side."""
    exact_a, exact_b, lower, upper = ([Fraction(x) for x in part] for part in (a, b, low, high))
    return segment_meets(exact_a, exact_b, ([x - grown for x in lower], [x + grown for x in upper]))


def _judge(trial: Trial, values: list[Any]) -> Counterexample | None:
    for call, (value, meets) in enumerate(zip(values, trial.facts["meets"], strict=True)):
        if value is not True and value is not False and value not in (0, 1):
            return trial.wrong(
                f"For {_segment(trial, call)} it returns {shown(value)} instead of True or False.",
                call,
            )
        if bool(value) == meets:
            continue
        return _fault(trial, call, meets)
    return None


def _fault(trial: Trial, call: int, meets: bool) -> Counterexample:
    a, b, low, high = trial.calls[call]
    box = f"the box from {point(low)} to {point(high)}"
    truth, why = ("meets", _why_met) if meets else ("does not meet", _why_clear)
    return trial.wrong(
        f"{_segment(trial, call).capitalize()} {truth} {box}: {why(a, b, low, high)} Your function "
        f"returns {not meets}.",
        call,
        str(not meets),
        str(meets),
        **_around(a, b, low, high),
    )


def _segment(trial: Trial, call: int) -> str:
    a, b, _, _ = trial.calls[call]
    return f"the segment from {point(a)} to {point(b)}"


def _why_met(a: Any, b: Any, low: Any, high: Any) -> str:
    """Where a segment is inside, as the end of a sentence."""
    inside = [
        all(x0 <= x <= x1 for x, x0, x1 in zip(place, low, high, strict=True)) for place in (a, b)
    ]
    if all(inside):
        return "it lies inside from end to end."
    if any(inside):
        return "one of its ends is inside."
    places = _places(a, b)
    within = places[((places >= low) & (places <= high)).all(axis=1)]
    if not len(within):
        return "both ends are outside, and it cuts a corner off."
    return f"both ends are outside, but its point {point(within[len(within) // 2])} is inside."


def _why_clear(a: Any, b: Any, low: Any, high: Any) -> str:
    """How near a segment comes to a box, as the end of a sentence."""
    places = _places(a, b)
    away = np.linalg.norm(places - np.clip(places, low, high), axis=1)
    nearest = int(np.flatnonzero(away <= away.min() + _TIE)[0])
    if nearest in (0, len(places) - 1):
        return f"its end {point(places[nearest])} comes nearest, and is {text(away[nearest])} away."
    return f"its point {point(places[nearest])} comes nearest, and is {text(away[nearest])} away."


def _places(a: Any, b: Any) -> FloatArray:
    """Points (n, 3) of a segment, both ends among them."""
    steps = np.linspace(0.0, 1.0, 10_001)[:, None]
    places: FloatArray = (1 - steps) * np.array(a) + steps * np.array(b)
    return places


def _around(a: Any, b: Any, low: Any, high: Any) -> dict[str, Any]:
    """Fields of a scene with that box, from one end of the segment to the other."""
    every = np.array([a, b, low, high])
    margin = 0.5
    workspace = {"min": (every.min(0) - margin).tolist(), "max": (every.max(0) + margin).tolist()}
    box = {
        "shape": "box",
        "size": (np.array(high) - low).tolist(),
        "position": ((np.array(high) + low) / 2).tolist(),
    }
    return {"workspace": workspace, "start": a, "goal": b, "obstacles": [box]}


EDGE_TEST = Exercise(
    name="edge_test",
    title="Does an edge meet a box?",
    task=(
        "An edge goes straight from a to b, a box along the axes from its lower to its upper "
        "corner; all four are points (x, y, z). Return True if any point of the edge lies in the "
        "box or on it, else False."
    ),
    starter=(
        "def edge_test(a, b, lower, upper):\n"
        "    return all(lo <= x <= hi for x, lo, hi in zip(a, lower, upper))  # an end alone\n"
    ),
    lesson="02-graph",
    caller="alone",
    trials=_trials,
    judge=_judge,
)
