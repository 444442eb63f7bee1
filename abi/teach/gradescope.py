"""Results of exercises as Gradescope's autograder reads them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from abi.teach.catalogue import exercise
from abi.teach.verdict import ExerciseVerdict

POINTS = 10.0
"""Points for each exercise that is right."""


def results(verdicts: Sequence[ExerciseVerdict]) -> dict[str, Any]:
    """The content of ``results.json``: a test for each verdict."""
    return {
        "tests": [
            {
                "name": exercise(one.exercise).title,
                "score": POINTS * one.passed,
                "max_score": POINTS,
                "status": "passed" if one.passed else "failed",
                "output": str(one),
            }
            for one in verdicts
        ],
        "execution_time": round(sum(one.seconds for one in verdicts), 3),
    }
