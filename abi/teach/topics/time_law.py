"""Exercise: how long to speed up, cruise and slow down."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from abi.scene.scene import Scene
from abi.search.search import search
from abi.teach.exercise import Counterexample, Exercise, Trial
from abi.teach.hidden_scenes import graph_of, hidden_scenes
from abi.teach.numbers import are_numbers, point, shown, text

_ROUNDING = 1e-6
_CALLS = 4


def _trials(seed: int) -> tuple[Trial, ...]:
    return tuple(_trial(one, seed + k) for k, one in enumerate(hidden_scenes(seed)))


def _trial(one: Scene, seed: int) -> Trial:
    """The path's length at several limits; half of the motions are too short to cruise."""
    random = np.random.default_rng(seed)
    length = search("dijkstra", graph_of(one), "length").length
    calls = []
    for number in range(_CALLS):
        up, down = random.uniform(1.0, 9.0, 2).round(1).tolist()
        top = math.sqrt(2 * length * up * down / (up + down))  # the speed where it cannot cruise
        share = random.uniform(0.2, 0.9) if number % 2 else random.uniform(1.1, 2.0)
        calls.append((round(length, 3), round(top * share, 2), up, down))
    return Trial(one, tuple(calls))


def _judge(trial: Trial, values: list[Any]) -> Counterexample | None:
    for call, (value, arguments) in enumerate(zip(values, trial.calls, strict=True)):
        sentence = fault_of(value, *arguments)
        if sentence:
            right = point(right_times(*arguments))
            length, speed, up, down = arguments
            case = (
                f"For a way of {text(length)} cm, at most {text(speed)} cm/s, speeding up at "
                f"{text(up)} cm/s² and slowing down at {text(down)} cm/s²"
            )
            motion = {"speed": speed, "acceleration": up, "deceleration": down}
            return trial.wrong(f"{case}: {sentence}", call, shown(value), right, motion=motion)
    return None


def fault_of(value: Any, length: float, speed: float, up: float, down: float) -> str:
    """What is wrong with three durations, as the rest of a sentence; empty for nothing."""
    if not are_numbers(value, 3):
        return f"it returns {shown(value)}, not three durations."
    first, cruise, last = value
    if min(value) < -_ROUNDING:
        return f"one of your durations {shown(value)} s is negative."
    peak = up * first
    if peak > speed + _ROUNDING:
        return f"your {text(first)} s of speeding up end at {text(peak)} cm/s, faster than allowed."
    if abs(peak - down * last) > _ROUNDING * max(1.0, peak):
        rest = peak - down * last
        return f"with your durations {shown(value)} s it ends at {text(rest)} cm/s, not at rest."
    travelled = up * first**2 / 2 + peak * cruise + down * last**2 / 2
    if abs(travelled - length) > _ROUNDING * max(1.0, length):
        return f"with your durations {shown(value)} s it travels {text(travelled)} cm."
    least, whole = sum(right_times(length, speed, up, down)), sum(value)
    if whole > least + _ROUNDING:
        return f"your motion takes {text(whole)} s, and {text(least)} s are enough."
    return ""


def right_times(length: float, speed: float, up: float, down: float) -> tuple[float, float, float]:
    """The durations of the fastest motion from rest to rest."""
    peak = min(speed, math.sqrt(2 * length * up * down / (up + down)))
    ramps = peak * peak / 2 * (1 / up + 1 / down)
    return peak / up, max(length - ramps, 0.0) / peak, peak / down


TIME_LAW = Exercise(
    name="time_law",
    title="Speed up, cruise, slow down",
    task=(
        "A motion from rest to rest over a length, no faster than the given speed, speeding up at "
        "the given rate and slowing down at another; all are above 0. Return the durations of the "
        "three phases of the fastest such motion. A short one does not reach the speed: then it "
        "does not cruise."
    ),
    starter=(
        "def time_law(length, speed, acceleration, deceleration):\n"
        "    return 0.0, length / speed, 0.0  # as if it could jump to full speed\n"
    ),
    lesson="06-motion",
    caller="alone",
    trials=_trials,
    judge=_judge,
)
