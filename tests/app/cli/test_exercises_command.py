"""``abi exercises``: it lists, begins a file, checks it and writes results."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from abi.teach.catalogue import exercises as all_exercises
from abi.teach.exercise_file import beginning, exercises_in
from abi.teach.exercise_notebook import notebook
from app.cli.exercises import exercises

_RIGHT = "import math\n\ndef heuristic(node, goal):\n    return math.dist(node, goal)\n"


def test_it_lists_what_is_asked() -> None:
    found = CliRunner().invoke(exercises, [])
    assert found.exit_code == 0
    for one in all_exercises().values():
        assert one.task in found.output


def test_a_file_begins_with_every_function(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    assert CliRunner().invoke(exercises, [str(file), "--begin"]).exit_code == 0
    assert exercises_in(file) == tuple(all_exercises().values())
    again = CliRunner().invoke(exercises, [str(file), "--begin"])
    assert "there already" in again.output
    assert max(map(len, beginning(tuple(all_exercises().values())).splitlines())) <= 100


@pytest.mark.slow
def test_results_are_those_of_an_autograder(tmp_path: Path) -> None:
    file, target = tmp_path / "mine.py", tmp_path / "results.json"
    file.write_text(_RIGHT + "\ndef priority(g, h):\n    return h\n")
    found = CliRunner().invoke(exercises, [str(file), "--results", str(target)])
    assert found.exit_code == 3
    assert "✓ heuristic" in found.output
    assert "✗ priority" in found.output
    tests = json.loads(target.read_text())["tests"]
    assert [one["score"] for one in tests] == [0.0, 10.0]
    assert [one["status"] for one in tests] == ["failed", "passed"]
    assert "is waiting with a smaller" in tests[0]["output"]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("def other(): pass\n", "with a function of that name"),
        ("def heuristic(:\n", "line 1"),
        ("\x00", "without errors"),
    ],
)
def test_a_file_that_is_none_is_refused(tmp_path: Path, text: str, told: str) -> None:
    file = tmp_path / "mine.py"
    file.write_text(text)
    found = CliRunner().invoke(exercises, [str(file)])
    assert told in str(found.exception)


def test_a_notebook_begins_for_students_or_for_a_grader(tmp_path: Path) -> None:
    file = tmp_path / "mine.ipynb"
    asked = [str(file), "--begin", "--only", "heuristic"]
    assert CliRunner().invoke(exercises, [*asked, "--grader", "otter"]).exit_code == 0
    assert json.loads(file.read_text()) == notebook(["heuristic"], grader="otter")
    assert "there already" in CliRunner().invoke(exercises, asked).output
    wrong = CliRunner().invoke(
        exercises, [str(tmp_path / "mine.py"), "--begin", "--grader", "otter"]
    )
    assert "ends in .ipynb" in wrong.output
    unread = CliRunner().invoke(exercises, [str(file)])
    assert unread.exit_code == 2
    assert "Only Python files (.py)" in unread.output
