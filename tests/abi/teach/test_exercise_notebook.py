"""Notebooks of exercises: valid, marked as graders ask for it, and right where the student is."""

from __future__ import annotations

import json
import sys
from typing import Any

import pytest

import abi.teach
from abi.errors import ArgumentError
from abi.teach.exercise_notebook import GRADED


@pytest.mark.parametrize("grader", ["", "nbgrader", "otter"])
def test_a_notebook_is_valid_and_asks_each_exercise(
    grader: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    # a grammar of addresses, which takes a second to build and no notebook needs
    monkeypatch.setitem(sys.modules, "rfc3987_syntax", None)
    import nbformat

    made = abi.teach.notebook(grader=grader)
    nbformat.validate(nbformat.reads(json.dumps(made), as_version=4))
    for name, one in abi.teach.exercises().items():
        (task,) = [cell for cell in made["cells"] if one.task in cell["source"]]
        assert one.title in task["source"]
        (solution,) = [cell for cell in code_cells(made) if cell["id"] == name]
        compile(solution["source"], name, "exec")
        assert f"def {name}(" in solution["source"].partition("BEGIN SOLUTION")[0]


@pytest.mark.slow
@pytest.mark.parametrize("grader", ["nbgrader", "otter"])
def test_its_tests_fail_as_it_begins_and_pass_with_a_right_function(grader: str) -> None:
    made = abi.teach.notebook(["heuristic"], grader=grader, seed=3)
    sources = [cell["source"] for cell in code_cells(made)]
    assert "seed=3" in sources[-1]
    assert "seed" not in "".join(sources[:-1]) + sources[-1].partition("HIDDEN")[0]
    with pytest.raises(AssertionError, match="Dijkstra"):
        run(sources)
    run([sources[0], "import math\nheuristic = math.dist", *sources[2:]])


def test_only_the_source_of_a_grader_has_its_seed() -> None:
    assert "seed" not in json.dumps(abi.teach.notebook())
    assert f"seed={GRADED}" in json.dumps(abi.teach.notebook(grader="nbgrader"))


def test_marks_of_nbgrader_are_those_of_its_schema() -> None:
    marks = [
        cell["metadata"].get("nbgrader") for cell in abi.teach.notebook(grader="nbgrader")["cells"]
    ]
    marked = [mark for mark in marks if mark is not None]
    assert (
        len({mark["grade_id"] for mark in marked}) == len(marked) == 3 * len(abi.teach.exercises())
    )
    for mark in marked:
        assert {"schema_version", "grade", "locked", "solution", "task"} <= set(mark)
        assert mark["grade"] is ("points" in mark)
        assert mark["locked"] is not mark["solution"]


def test_what_is_no_grader_or_exercise_is_refused() -> None:
    with pytest.raises(ArgumentError, match="grader is 'okpy'; expected one of nbgrader, otter"):
        abi.teach.notebook(grader="okpy")
    with pytest.raises(ArgumentError, match="exercise is 'none'"):
        abi.teach.notebook(["none"])


def code_cells(made: dict[str, Any]) -> list[dict[str, Any]]:
    return [cell for cell in made["cells"] if cell["cell_type"] == "code"]


def run(sources: list[str]) -> None:
    """Run cells one after the other, as a notebook does."""
    names: dict[str, Any] = {"__name__": "__main__"}
    for source in sources:
        exec(source, names)
