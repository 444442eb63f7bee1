"""Exercise: the joints of an arm with two links whose elbow points up."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from abi.scene.scene import Scene
from abi.search.search import search
from abi.teach.exercise import Counterexample, Exercise, Trial
from abi.teach.hidden_scenes import graph_of, hidden_scenes
from abi.teach.numbers import are_numbers, shown, text

_ROUNDING = 1e-6
_CALLS = 12
_FAR, _NEAR = (1.01, 1.27), (0.4, 0.8, 0.97)
"""Distances out of reach, over the largest and over the least within it."""


def _trials(seed: int) -> tuple[Trial, ...]:
    return tuple(_trial(one, seed + k) for k, one in enumerate(hidden_scenes(seed)))


def _trial(one: Scene, seed: int) -> Trial:
    """Points around the shoulder, the path as seen from the base, and some out of reach."""
    random = np.random.default_rng(seed)
    path = search("dijkstra", graph_of(one), "length").points
    upper, fore = random.uniform(3.5, 7.0, 2).round(1).tolist()
    seen = np.stack([np.hypot(path[:, 0] - 3.0, path[:, 1] + 3.0), path[:, 2] - 3.0], axis=1)
    angle = random.uniform(-np.pi, np.pi, _CALLS)
    reach = random.uniform(abs(upper - fore) + 0.1, upper + fore - 0.1, _CALLS)
    around = np.stack([reach * np.cos(angle), reach * np.sin(angle)], axis=1)
    beyond = [*((upper + fore) * np.array(_FAR)), *(abs(upper - fore) * np.array(_NEAR))]
    angle = random.uniform(-np.pi, np.pi, len(beyond))
    out = np.stack([beyond * np.cos(angle), beyond * np.sin(angle)], axis=1)
    places = np.concatenate([seen, around, out])
    calls = []
    for r, z in places.round(3).tolist():
        gap = min(abs(math.hypot(r, z) - upper - fore), abs(math.hypot(r, z) - abs(upper - fore)))
        if gap > 1e-3:  # at the very limit rounding decides
            calls.append((r, z, upper, fore))
    return Trial(one, tuple(calls))


def _judge(trial: Trial, values: list[Any]) -> Counterexample | None:
    for call, (value, arguments) in enumerate(zip(values, trial.calls, strict=True)):
        sentence = fault_of(value, *arguments)
        if sentence:
            r, z, upper, fore = arguments
            case = f"For a tip at r = {text(r)}, z = {text(z)} and links of {text(upper)} and "
            right = right_angles(*arguments)
            expected = "None" if right is None else f"({text(right[0])}, {text(right[1])})"
            return trial.wrong(f"{case}{text(fore)}: {sentence}", call, shown(value), expected)
    return None


def fault_of(value: Any, r: float, z: float, upper: float, fore: float) -> str:
    """What is wrong with two angles, as the rest of a sentence; empty for nothing."""
    if right_angles(r, z, upper, fore) is None:
        distance = math.hypot(r, z)
        far = f"the tip is {text(distance)} away, out of reach, and None would be right"
        return "" if value is None else f"{far}; yours returns {shown(value)}."
    if not are_numbers(value, 2):
        return f"yours returns {shown(value)}, not two angles."
    shoulder, elbow = value
    joint, tip = _posed(shoulder, elbow, upper, fore)
    near = _ROUNDING * (upper + fore)
    if math.dist(tip, (r, z)) > near:
        guess = ""
        if (
            math.dist(_posed(math.radians(shoulder), math.radians(elbow), upper, fore)[1], (r, z))
            <= near
        ):
            guess = " They seem to be degrees; radians are asked for."
        elif math.dist(_posed(shoulder, elbow - shoulder, upper, fore)[1], (r, z)) <= near:
            guess = " The elbow's angle seems to count from the r axis, not from the upper arm."
        return (
            f"with your angles {shown(value)} the tip is at r = {text(tip[0])}, "
            f"z = {text(tip[1])}.{guess}"
        )
    if r * joint[1] - z * joint[0] < -_ROUNDING:
        return (
            f"with your angles {shown(value)} the tip is right, but the elbow is on the other side "
            "of the line from the shoulder to the tip."
        )
    return ""


def _posed(
    shoulder: float, elbow: float, upper: float, fore: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Positions of elbow and tip as (r, z)."""
    joint = upper * math.cos(shoulder), upper * math.sin(shoulder)
    angle = shoulder + elbow
    return joint, (joint[0] + fore * math.cos(angle), joint[1] + fore * math.sin(angle))


def right_angles(r: float, z: float, upper: float, fore: float) -> tuple[float, float] | None:
    """The angles by the law of cosines; None out of reach."""
    square = r * r + z * z
    cosine = (square - upper**2 - fore**2) / (2 * upper * fore)
    if abs(cosine) > 1:
        return None
    elbow = -math.acos(cosine)
    shoulder = math.atan2(z, r) - math.atan2(fore * math.sin(elbow), upper + fore * math.cos(elbow))
    return shoulder, elbow


ELBOW = Exercise(
    name="elbow",
    title="One branch of the inverse kinematics",
    task=(
        "An arm in the plane has its shoulder at r = z = 0, an upper arm and a forearm of the "
        "given lengths. The shoulder's angle is counted from the r axis, the elbow's from the "
        "upper arm on, both counter-clockwise, in radians. Return both angles with which the tip "
        "is at (r, z) and the elbow lies to the left of the line from the shoulder to the tip: "
        "above it, where r > 0. Return None where the tip is out of reach."
    ),
    starter=(
        "import math\n\n\ndef elbow(r, z, upper, fore):\n"
        "    return math.atan2(z, r), 0.0  # an arm that does not bend\n"
    ),
    lesson="07-arm",
    caller="alone",
    trials=_trials,
    judge=_judge,
)
