"""Exercises and questions for students.

Students write one function of the method, and have it checked on hidden scenes.
:func:`exercises` lists them, :func:`check` checks a function::

    import math, abi.teach

    def heuristic(node, goal):
        return math.dist(node, goal)

    abi.teach.check("heuristic", heuristic)

:func:`question` makes a question of a template for any seed, with its answer, and :func:`notebook`
a notebook with exercises, also for a course that nbgrader or Otter grades.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from abi.teach.catalogue import exercises
    from abi.teach.exercise import Counterexample, Exercise
    from abi.teach.exercise_notebook import notebook
    from abi.teach.quiz.question import QuizQuestion
    from abi.teach.quiz.templates import question, templates
    from abi.teach.student_process import Limits
    from abi.teach.verdict import ExerciseVerdict, check

__all__ = [
    "Counterexample",
    "Exercise",
    "ExerciseVerdict",
    "Limits",
    "QuizQuestion",
    "check",
    "exercises",
    "notebook",
    "question",
    "templates",
]

_MODULES = {
    "Counterexample": "abi.teach.exercise",
    "Exercise": "abi.teach.exercise",
    "Limits": "abi.teach.student_process",
    "QuizQuestion": "abi.teach.quiz.question",
    "ExerciseVerdict": "abi.teach.verdict",
    "check": "abi.teach.verdict",
    "exercises": "abi.teach.catalogue",
    "notebook": "abi.teach.exercise_notebook",
    "question": "abi.teach.quiz.templates",
    "templates": "abi.teach.quiz.templates",
}


def __getattr__(name: str) -> object:
    """Import a public name when it is first used: a student's process needs none of them."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module(_MODULES[name]), name)
    globals()[name] = value
    return value
