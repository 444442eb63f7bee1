"""Starting files of exercises for students to download."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

from abi.teach.catalogue import exercise
from abi.teach.exercise_file import beginning
from abi.teach.exercise_notebook import notebook

SCRIPT, NOTEBOOK = "mine.py", "mine.ipynb"
"""Names of the files, as in lessons and documentation."""


def exercise_files(names: Sequence[str]) -> Mapping[str, str]:
    """A Python file and a notebook with the beginnings of exercises, as texts by file name.

    Raises:
        ArgumentError: there is no such exercise.
    """
    made = json.dumps(notebook(names), indent=1, ensure_ascii=False)
    return {SCRIPT: beginning(tuple(map(exercise, names))), NOTEBOOK: f"{made}\n"}
