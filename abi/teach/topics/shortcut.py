"""Exercise: leave out the corners of a path that are not needed."""

from __future__ import annotations

import itertools
import math
from typing import Any

from abi.scene.scene import Scene
from abi.search.search import search
from abi.teach.boxes import segment_meets_any
from abi.teach.exercise import Counterexample, Exercise, Trial
from abi.teach.hidden_scenes import boxes_of, graph_of, hidden_scenes
from abi.teach.numbers import are_points, point, shown, text

_ROUNDING = 1e-9
_SHORTER = 1e-6
"""Difference of lengths that is reported, [unit]."""


def _trials(seed: int) -> tuple[Trial, ...]:
    return tuple(map(_trial, hidden_scenes(seed)))


def _trial(one: Scene) -> Trial:
    """The path with the fewest edges, which leaves much to gain, among the boxes themselves."""
    path = search("dijkstra", graph_of(one), "hops").points.tolist()
    return Trial(one, ((path, list(boxes_of(one))),))


def _judge(trial: Trial, values: list[Any]) -> Counterexample | None:
    path, answer = trial.calls[0][0], values[0]
    if not are_points(answer) or len(answer) < 2:
        return trial.wrong(f"It returns {shown(answer)}, not a list of points (x, y, z).")
    for name, asked, given in (("start", path[0], answer[0]), ("end", path[-1], answer[-1])):
        if math.dist(asked, given) > _ROUNDING:
            return trial.wrong(
                f"The path has to {name} at {point(asked)}; yours {name}s at {point(given)}."
            )
    return _blocked(trial, answer) or _foreign(trial, answer) or _left(trial, answer)


def _blocked(trial: Trial, answer: list[list[float]]) -> Counterexample | None:
    _, boxes = trial.calls[0]
    for a, b in itertools.pairwise(answer):
        if segment_meets_any(a, b, boxes):
            return trial.wrong(
                f"The leg of your path from {point(a)} to {point(b)} runs into a box."
            )
    return None


def _foreign(trial: Trial, answer: list[list[float]]) -> Counterexample | None:
    """A corner that the path does not have, or not there."""
    path, _ = trial.calls[0]
    place = 0
    for corner in answer:
        while place < len(path) and math.dist(path[place], corner) > _ROUNDING:
            place += 1
        if place == len(path):
            return trial.wrong(
                f"Your path has the corner {point(corner)}, which the given path has not, or not "
                "at this place of its order."
            )
        place += 1
    return None


def _left(trial: Trial, answer: list[list[float]]) -> Counterexample | None:
    """A corner that could be left out."""
    path, boxes = trial.calls[0]
    for a, corner, b in zip(answer, answer[1:], answer[2:], strict=False):
        if not segment_meets_any(a, b, boxes):
            saved = math.dist(a, corner) + math.dist(corner, b) - math.dist(a, b)
            gain = f"{text(saved)} shorter" if saved > _SHORTER else "just as long"
            return trial.wrong(
                f"Your path still has the corner {point(corner)}, which it does not need: the "
                f"straight line from {point(a)} to {point(b)} is clear, and {gain}.",
                got=f"{len(answer)} points of {len(path)}",
                expected="no corner that can be left out",
            )
    return None


SHORTCUT = Exercise(
    name="shortcut",
    title="Shortcuts",
    task=(
        "A path is a list of points (x, y, z), and is_clear(a, b) says whether the straight line "
        "from one point to another meets no obstacle. Return the path without the corners that it "
        "does not need: a list of its points, in order, with the same ends, all of whose legs are "
        "clear, and no single corner of which could still be left out."
    ),
    starter="def shortcut(path, is_clear):\n    return path  # as long as it was\n",
    lesson="10-optimal",
    caller="clear_test",
    trials=_trials,
    judge=_judge,
)
