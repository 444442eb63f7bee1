"""Check of a student's function: hidden scenes, a sentence, and a counterexample."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

from abi.scene.scene import Scene
from abi.teach.catalogue import exercise
from abi.teach.exercise import Exercise, ExerciseFault, Trial
from abi.teach.numbers import shown
from abi.teach.student_process import Answers, Limits, Student, run

SEED = 2016
"""Default seed of the hidden scenes; a teacher may choose another."""


@dataclass(frozen=True)
class Counterexample:
    """A case that a student's function gets wrong.

    Attributes:
        scene: what a page can show of it.
        arguments: with which the function was called, as plain data.
        got: what it returned, as text; empty where it failed.
        expected: what would be right, as text; empty where it failed.
        steps: nodes that the student's search expands, up to where it goes wrong; empty where the
            exercise is no search.
        right_steps: nodes that the right search expands.
    """

    scene: Scene
    arguments: tuple[Any, ...]
    got: str = ""
    expected: str = ""
    steps: tuple[int, ...] = ()
    right_steps: tuple[int, ...] = ()

    @property
    def parting(self) -> int:
        """Number of steps that both searches have in common."""
        pairs = zip(self.steps, self.right_steps, strict=False)
        return next(
            (number for number, (own, right) in enumerate(pairs) if own != right),
            min(len(self.steps), len(self.right_steps)),
        )


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
    seconds: float
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
    found = judged(asked, trials, answers)
    return ExerciseVerdict(name, seconds=time.perf_counter() - began, scenes=len(trials), **found)


def judged(asked: Exercise, trials: tuple[Trial, ...], answers: Answers) -> dict[str, Any]:
    """The fields of a verdict that the answers decide."""
    if not answers.began:
        sentence = f"It could not be loaded: {answers.failure}."
        return {"passed": False, "sentence": sentence, "right": 0}
    for number, (trial, values) in enumerate(zip(trials, answers.values, strict=False)):
        fault = _fault(asked, trial, values)
        if fault is not None:
            return _wrong(trial, number, len(trials), fault)
    right = len(answers.values)
    if right < len(trials):
        trial = trials[right]
        given = f"({_given(trial.calls[answers.call])})" if asked.caller == "alone" else ""
        sentence = f"{asked.name}{given} failed: {answers.failure}."
        fault = ExerciseFault(sentence, answers.call)
        return _wrong(trial, right, len(trials), fault)
    sentence = f"All {len(trials)} hidden scenes are right."
    return {"passed": True, "sentence": sentence, "right": right}


def _fault(asked: Exercise, trial: Trial, values: list[Any]) -> ExerciseFault | None:
    """Fault of the values of a trial, which may be anything."""
    if len(values) != len(trial.calls):
        return ExerciseFault("It did not answer every call.")
    return asked.judge(trial, values)


def _wrong(trial: Trial, number: int, trials: int, fault: ExerciseFault) -> dict[str, Any]:
    scene = trial.scene.replace(**fault.change) if fault.change else trial.scene
    case = Counterexample(
        scene,
        trial.calls[fault.call],
        fault.got,
        fault.expected,
        fault.steps,
        fault.right_steps,
    )
    return {
        "passed": False,
        "sentence": f"Hidden scene {number + 1} of {trials}: {fault.sentence}",
        "right": number,
        "counterexample": case,
    }


def _given(arguments: tuple[Any, ...]) -> str:
    return ", ".join(map(shown, arguments))
