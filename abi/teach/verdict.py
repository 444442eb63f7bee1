"""Check of a student's function: hidden scenes, a sentence, and a counterexample."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any

from abi.teach.catalogue import exercise
from abi.teach.exercise import Counterexample, Exercise, Trial
from abi.teach.numbers import shown
from abi.teach.student_process import Answers, Limits, Student, run

SEED = 2016
"""Default seed of the hidden scenes; a teacher may choose another."""


@dataclass(frozen=True)
class ExerciseVerdict:
    """Result of a check.

    Attributes:
        exercise: its name.
        passed: whether every hidden scene was right.
        sentence: what was found, for the student.
        right: number of hidden scenes that were right, up to the first that was not.
        scenes: number of hidden scenes.
        seconds: that the check took.
        counterexample: of the first scene that was not right; None where all were, or where the
            function could not be loaded.
    """

    exercise: str
    passed: bool
    sentence: str
    right: int
    scenes: int
    seconds: float = 0.0
    counterexample: Counterexample | None = None

    def __str__(self) -> str:
        sign = "✓" if self.passed else "✗"
        lines = [f"{sign} {self.exercise}: {self.sentence}"]
        case = self.counterexample
        if case is not None and case.expected:
            lines.append(f"  yours: {case.got}")
            lines.append(f"  right: {case.expected}")
        return "\n".join(lines)

    __repr__ = __str__


def check(
    name: str, function: Student, *, seed: int = SEED, limits: Limits | None = None
) -> ExerciseVerdict:
    """Run a student's function on 20 hidden scenes, in a separate process.

    Args:
        name: of the exercise, in :func:`abi.teach.exercises`.
        function: the function, or the name of a Python file with one of the exercise's name.
        seed: of the hidden scenes.
        limits: of time and memory.

    Returns:
        What was found: a sentence, and the first case that is wrong.

    Raises:
        ArgumentError: there is no such exercise, or what was given is no function.
    """
    began = time.perf_counter()
    asked = exercise(name)
    trials = asked.trials(seed)
    calls = [trial.calls for trial in trials]
    answers = run(function, asked.name, asked.caller, calls, limits)
    return replace(judged(asked, trials, answers), seconds=time.perf_counter() - began)


def judged(asked: Exercise, trials: tuple[Trial, ...], answers: Answers) -> ExerciseVerdict:
    """What the answers to an exercise's trials are worth."""
    right, count = len(answers.values), len(trials)
    if not answers.began:
        sentence = f"It could not be loaded: {answers.failure}."
        return ExerciseVerdict(asked.name, False, sentence, 0, count)
    for number, (trial, values) in enumerate(zip(trials, answers.values, strict=False)):
        if (case := _case(asked, trial, values)) is not None:
            return _failed(asked, case, number, count)
    if right < count:
        trial = trials[right]
        given = f"({_given(trial.calls[answers.call])})" if asked.caller == "alone" else ""
        sentence = f"{asked.name}{given} failed: {answers.failure}."
        return _failed(asked, trial.wrong(sentence, answers.call), right, count)
    return ExerciseVerdict(asked.name, True, f"All {count} hidden scenes are right.", right, count)


def _case(asked: Exercise, trial: Trial, values: list[Any]) -> Counterexample | None:
    """What is wrong with the values of a trial, which may be anything."""
    if len(values) != len(trial.calls):
        return trial.wrong("It did not answer every call.")
    return asked.judge(trial, values)


def _failed(asked: Exercise, case: Counterexample, number: int, count: int) -> ExerciseVerdict:
    """Verdict on a function that gets the hidden scene of a number wrong, from 0 on."""
    sentence = f"Hidden scene {number + 1} of {count}: {case.sentence}"
    return ExerciseVerdict(asked.name, False, sentence, number, count, counterexample=case)


def _given(arguments: tuple[Any, ...]) -> str:
    return ", ".join(map(shown, arguments))
