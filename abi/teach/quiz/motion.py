"""Questions about the motion along a curve and the arm that makes it."""

from __future__ import annotations

import math

import numpy as np

from abi.curves.three_phase_profile import ThreePhaseProfile, three_phase
from abi.teach.numbers import text
from abi.teach.quiz.question import QuizQuestion, fixed, of_number
from abi.teach.topics.elbow import right_angles

_NEAR = 0.05
"""Relative distance of a motion in a question from a limit."""


def speed_limit_hit(random: np.random.Generator) -> QuizQuestion:
    """Does a motion reach its speed?"""
    while True:
        profile = _profile(random)
        top = _top(profile)
        if abs(top - profile.speed) > _NEAR * profile.speed:
            break
    reached = not profile.triangular
    told = (
        f"It reaches {text(profile.speed)} cm/s after {text(profile.t1)} s."
        if reached
        else f"It reaches {text(profile.peak_speed)} cm/s and must slow down then."
    )
    return fixed(
        f"{_told(profile)} Where is the speed limit hit?",
        ("At the end of the first phase; then it cruises.", "Nowhere: the way is too short."),
        0 if reached else 1,
        told,
        _facts(profile),
    )


def peak_speed(random: np.random.Generator) -> QuizQuestion:
    """How fast does a motion become?"""
    profile = _profile(random)
    wrong = [
        _top(profile),
        profile.speed,
        math.sqrt(profile.length * profile.acceleration),
        math.sqrt(2 * profile.length * profile.acceleration),
    ]
    return of_number(
        random,
        f"{_told(profile)} How fast does it become?",
        profile.peak_speed,
        wrong,
        "The least of the limit and of √(2 s a b / (a + b)), at which it has to slow down: "
        f"{text(profile.peak_speed)}.",
        _facts(profile),
        "cm/s",
    )


def duration(random: np.random.Generator) -> QuizQuestion:
    """How long does a motion take?"""
    profile = _profile(random)
    length, speed = profile.length, profile.speed
    wrong = [
        length / speed,
        speed / profile.acceleration + length / speed + speed / profile.deceleration,
        profile.t1 + profile.t3,
        profile.duration - profile.t3 / 2,
    ]
    return of_number(
        random,
        f"{_told(profile)} How long does it take?",
        profile.duration,
        wrong,
        f"It speeds up for {text(profile.t1)}, cruises for {text(profile.t2)} and slows down for "
        f"{text(profile.t3)} s.",
        _facts(profile),
        "s",
    )


def which_elbow(random: np.random.Generator) -> QuizQuestion:
    """On which side of the line to the tip is the elbow?"""
    upper, fore = random.uniform(2.0, 6.0, 2).round(1).tolist()
    reach = random.uniform(abs(upper - fore) + 0.3, upper + fore - 0.3)
    angle = random.uniform(-1.2, 1.2)
    angles = right_angles(reach * math.cos(angle), reach * math.sin(angle), upper, fore)
    assert angles is not None
    shoulder, elbow = angles
    if random.integers(2):  # the other branch, mirrored at the line
        shoulder, elbow = 2 * angle - shoulder, -elbow
    shoulder, elbow = round(math.degrees(shoulder), 1), round(math.degrees(elbow), 1)
    above = elbow < 0
    side = "above" if above else "below"
    return fixed(
        f"The arm's shoulder is at an angle of {text(shoulder)}° over the r axis, its elbow is "
        f"bent by {text(elbow)}°, both counter-clockwise; the upper arm is {text(upper)}, the "
        f"forearm {text(fore)} long. Is the elbow above or below the line from the shoulder to the "
        "tip?",
        ("Above it", "Below it"),
        0 if above else 1,
        f"An elbow bent {'clockwise' if above else 'counter-clockwise'} lies {side} that line.",
        {"angles": [shoulder, elbow], "links": [upper, fore]},
    )


def reachable_distance(random: np.random.Generator) -> QuizQuestion:
    """How far is the tip of an arm with two links?"""
    upper, fore = random.uniform(2.0, 6.0, 2).round(1).tolist()
    bend = float(random.integers(20, 150))
    turned = math.radians(bend)
    distance = math.sqrt(upper**2 + fore**2 + 2 * upper * fore * math.cos(turned))
    wrong = [
        math.sqrt(upper**2 + fore**2 - 2 * upper * fore * math.cos(turned)),
        upper + fore * math.cos(turned),
        upper + fore,
        math.hypot(upper, fore),
    ]
    return of_number(
        random,
        f"An upper arm of {text(upper)} cm carries a forearm of {text(fore)} cm, bent by "
        f"{text(bend)}° from the upper arm's direction. How far is the tip from the shoulder?",
        distance,
        wrong,
        "The angle between the links is 180° less the bend, so that the law of cosines has a plus: "
        f"√(a² + b² + 2ab cos {text(bend)}°) = {text(distance)} cm.",
        {"links": [upper, fore], "bend": bend},
        "cm",
    )


def _profile(random: np.random.Generator) -> ThreePhaseProfile:
    length = round(float(random.uniform(2.0, 15.0)), 1)
    up, down = random.uniform(1.0, 9.0, 2).round(1).tolist()
    speed = round(float(random.uniform(1.0, 9.0)), 1)
    return three_phase(length, speed, up, down)


def _top(profile: ThreePhaseProfile) -> float:
    """Peak speed without a limit."""
    a, b = profile.acceleration, profile.deceleration
    return math.sqrt(2 * profile.length * a * b / (a + b))


def _told(profile: ThreePhaseProfile) -> str:
    return (
        f"A motion from rest to rest over {text(profile.length)} cm may move at "
        f"{text(profile.speed)} cm/s; it speeds up by {text(profile.acceleration)} and slows down "
        f"by {text(profile.deceleration)} cm/s²."
    )


def _facts(profile: ThreePhaseProfile) -> dict[str, float]:
    return {
        "length": profile.length,
        "speed": profile.speed,
        "up": profile.acceleration,
        "down": profile.deceleration,
    }
