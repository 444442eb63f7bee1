"""An exercise: a short function to write, hidden trials, and a judge of the answers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from abi.scene.scene import Scene


@dataclass(frozen=True)
class Counterexample:
    """A case that a student's function gets wrong.

    Attributes:
        sentence: what the function does there and what would be right, for the student.
        scene: what a page can show of it.
        arguments: with which the function was called, as plain data.
        got: what it returned, as text; empty where it failed.
        expected: what would be right, as text; empty where it failed.
        steps: nodes that the student's search expands, up to where it goes wrong; empty where the
            exercise is no search.
        right_steps: nodes that the right search expands, to its end.
    """

    sentence: str
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

    def wrong(
        self,
        sentence: str,
        call: int = 0,
        got: str = "",
        expected: str = "",
        steps: tuple[int, ...] = (),
        right_steps: tuple[int, ...] = (),
        **change: Any,
    ) -> Counterexample:
        """The counterexample of a call, by its number.

        Other arguments are as in :class:`Counterexample`; ``change`` are fields of the scene that
        show the fault better than the whole.
        """
        scene = self.scene.replace(**change) if change else self.scene
        arguments = self.calls[call]
        return Counterexample(sentence, scene, arguments, got, expected, steps, right_steps)


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
        judge: finds a case that the values of a trial's calls get wrong; None where none is.
    """

    name: str
    title: str
    task: str
    starter: str
    lesson: str
    caller: str
    trials: Callable[[int], tuple[Trial, ...]]
    judge: Callable[[Trial, list[Any]], Counterexample | None]

    def __str__(self) -> str:
        return f"{self.name}: {self.title}\n\n{self.task}\n\n{self.starter}"
