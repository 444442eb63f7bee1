"""Notebooks with exercises: for students alone, or for a course that nbgrader or Otter grades."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from abi.errors import ArgumentError
from abi.teach.catalogue import exercise, exercises
from abi.teach.exercise import Exercise
from abi.teach.gradescope import POINTS
from abi.teach.verdict import SEED

GRADED = SEED + 1
"""Seed of the hidden scenes for grading; students try those of ``SEED``."""
_NBGRADER_SCHEMA = 3
_HEAD = (
    "# Exercises\n\nChange each function until its check says that all hidden scenes are right. A "
    "check that fails tells a case that your function gets wrong."
)

Cell = dict[str, Any]


def notebook(names: Sequence[str] = (), *, grader: str = "", seed: int = GRADED) -> dict[str, Any]:
    """Make a Jupyter notebook in which students write the functions of exercises.

    Args:
        names: of the exercises, in :func:`abi.teach.exercises`; all without them.
        grader: ``"nbgrader"`` for the source notebook of an nbgrader assignment, ``"otter"`` for
            the master notebook that ``otter assign`` takes, empty for students alone.
        seed: of the hidden scenes that decide the grade; not in a notebook for students alone.

    Returns:
        The notebook as its file has it, in format 4.5: ``json.dump`` writes it.

    Raises:
        ArgumentError: there is no such exercise or grader.
    """
    if grader not in _GRADERS:
        raise ArgumentError("grader", grader, f"one of {', '.join(filter(None, _GRADERS))}")
    asked = tuple(map(exercise, names)) or tuple(exercises().values())
    head = [_markdown("head", _HEAD), _code("import", "import math\n\nimport abi.teach")]
    if grader == "otter":
        head.insert(0, _raw("assignment", "# ASSIGNMENT CONFIG\nrun_tests: false"))
    cells = [*head, *(cell for one in asked for cell in _GRADERS[grader](one, seed))]
    return {"cells": cells, "metadata": _metadata(), "nbformat": 4, "nbformat_minor": 5}


def _for_students(one: Exercise, seed: int) -> list[Cell]:
    """The task, the beginning of a solution, and its check."""
    check = f'abi.teach.check("{one.name}", {one.name})'
    return [
        _markdown(f"{one.name}-task", f"## {one.title}\n\n{one.task}"),
        _code(one.name, one.starter.strip()),
        _code(f"{one.name}-check", check),
    ]


def _for_nbgrader(one: Exercise, seed: int) -> list[Cell]:
    """Task, solution and tests with nbgrader's marks; the release has neither solution nor seed."""
    hidden = f"### BEGIN HIDDEN TESTS\n{_test(one, seed)}\n### END HIDDEN TESTS"
    task = _markdown(f"{one.name}-task", _task_with_beginning(one))
    solution = _code(one.name, _with_region(one.starter, "### "))
    tests = _code(f"{one.name}-check", f"{_test(one)}\n{hidden}")
    return [
        _marked(task, locked=True),
        _marked(solution, solution=True),
        _marked(tests, grade=True, locked=True, points=POINTS),
    ]


def _for_otter(one: Exercise, seed: int) -> list[Cell]:
    """A question of ``otter assign``: a prompt, a solution, an open and a hidden test."""
    question = f"# BEGIN QUESTION\nname: {one.name}\npoints: {POINTS:g}"
    return [
        _raw(f"{one.name}-begin", question),
        _markdown(f"{one.name}-task", _task_with_beginning(one)),
        _raw(f"{one.name}-solution-begin", "# BEGIN SOLUTION"),
        _code(one.name, _with_region(one.starter, "# ")),
        _raw(f"{one.name}-solution-end", "# END SOLUTION"),
        _raw(f"{one.name}-tests-begin", "# BEGIN TESTS"),
        _code(f"{one.name}-check", _test(one)),
        _code(f"{one.name}-hidden", f"# HIDDEN\n{_test(one, seed)}"),
        _raw(f"{one.name}-tests-end", "# END TESTS"),
        _raw(f"{one.name}-end", "# END QUESTION"),
    ]


_GRADERS: Mapping[str, Callable[[Exercise, int], list[Cell]]] = MappingProxyType(
    {"": _for_students, "nbgrader": _for_nbgrader, "otter": _for_otter}
)


def _test(one: Exercise, seed: int | None = None) -> str:
    """Code that fails with the check's sentence if a function is wrong."""
    scenes = "" if seed is None else f", seed={seed}"
    return (
        f'verdict = abi.teach.check("{one.name}", {one.name}{scenes})\n'
        "assert verdict.passed, verdict.sentence"
    )


def _task_with_beginning(one: Exercise) -> str:
    """The task, and the beginning that the grader cuts out of the solution's cell."""
    beginning = f"A beginning, not right yet:\n\n```python\n{one.starter.strip()}\n```"
    return f"## {one.title}\n\n{one.task}\n\n{beginning}"


def _with_region(starter: str, mark: str) -> str:
    """A beginning whose body is between the marks of a solution."""
    head, _, body = starter.strip().partition(":\n")
    return f"{head}:\n    {mark}BEGIN SOLUTION\n{body}\n    {mark}END SOLUTION"


def _marked(cell: Cell, points: float | None = None, **marks: bool) -> Cell:
    """The cell with nbgrader's metadata."""
    given = {} if points is None else {"points": points}
    kinds = {"grade": False, "locked": False, "solution": False, "task": False, **marks}
    mark = {"grade_id": cell["id"], "schema_version": _NBGRADER_SCHEMA, **kinds, **given}
    return {**cell, "metadata": {"nbgrader": mark}}


def _markdown(name: str, text: str) -> Cell:
    return {"cell_type": "markdown", "id": name, "metadata": {}, "source": text}


def _raw(name: str, text: str) -> Cell:
    return {**_markdown(name, text), "cell_type": "raw"}


def _code(name: str, text: str) -> Cell:
    return {
        **_markdown(name, text),
        "cell_type": "code",
        "execution_count": None,
        "outputs": [],
    }


def _metadata() -> dict[str, Any]:
    return {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"},
    }
