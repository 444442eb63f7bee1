"""An exercise: a short function to write, hidden trials, and a judge of the answers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from abi.scene.scene import Scene


@dataclass(frozen=True)
class Trial:
    """One hidden scene of an exercise, and the calls of the student's function in it.

    Attributes:
        scene: what the page shows of it.
        calls: arguments of each call, as plain data.
        facts: what the judge alone knows, by name.
    """

    scene: Scene
    calls: tuple[tuple[Any, ...], ...]
    facts: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class ExerciseFault:
    """Fault of an answer.

    Attributes:
        sentence: what the function does there and what would be right, for the student.
        call: number of the call in its trial.
        got: what it returned, as text.
        expected: what would be right, as text.
        steps: nodes that the student's search expands, up to where it goes wrong.
        right_steps: nodes that the right search expands, to its end.
        change: fields of the trial's scene that show the fault better than the whole.
    """

    sentence: str
    call: int = 0
    got: str = ""
    expected: str = ""
    steps: tuple[int, ...] = ()
    right_steps: tuple[int, ...] = ()
    change: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Exercise:
    """An exercise.

    Attributes:
        name: by which it is chosen, and the name of the function in a file.
        title: what it is about.
        task: what the function takes and returns, and what is asked of it.
        starter: the beginning of a solution, as Python text.
        lesson: name of the lesson that leads to it.
        caller: how the function is called, in :data:`abi.teach.callers.CALLERS`.
        trials: makes the hidden scenes of a seed.
        judge: finds what is wrong with the values of a trial's calls; None where nothing is.
    """

    name: str
    title: str
    task: str
    starter: str
    lesson: str
    caller: str
    trials: Callable[[int], tuple[Trial, ...]]
    judge: Callable[[Trial, list[Any]], ExerciseFault | None]

    def __str__(self) -> str:
        return f"{self.name}: {self.title}\n\n{self.task}\n\n{self.starter}"
