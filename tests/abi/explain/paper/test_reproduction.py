from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from abi import assets
from abi.arm_planning.paper_arm_model import paper_arm
from abi.curves.curve import arc_length
from abi.explain.paper import printed
from abi.explain.paper.comparison import PaperComparison
from abi.explain.paper.reproduction import compare
from abi.robot.paper_arm.paper_arm import forward
from abi.scene.scene import Scene
from tests.thorough import examples


@pytest.fixture(scope="module")
def comparisons() -> dict[str, PaperComparison]:
    found = compare()
    by_subject = {one.subject: one for one in found}
    assert len(by_subject) == len(found)
    return by_subject


@pytest.mark.slow
@pytest.mark.parametrize(
    ("what", "found"),
    [
        ("excluding the nodes in the obstacles", "with edges tested, too, 0"),
        ("vertices of the paths", "9, 9, 9 by edges"),
        ("the three lengths on one graph", "the same"),
        ("length of the printed polynomials", "11.3581"),
        ("speed along the printed polynomials", "14.74 → 10.39 → 11.61"),
        ("y = cos q1·r", "right in 0 %"),
        ("q1 by arccos", "q1 = atan2(x, −y): 100 %"),
        ("q2 with a3²·Pza", "right in 0 % of 10,000 poses; q2 with a3³·Pza: 100 %"),
        ("q4 = t²·Q / I under the force Q", "2.000 Q; t²·Q / (2·I) takes 1.000 Q"),
    ],
)
def test_what_was_checked_by_hand_is_found(
    comparisons: dict[str, PaperComparison], what: str, found: str
) -> None:
    assert found in comparisons[what].ours


@pytest.mark.slow
@pytest.mark.parametrize(
    ("what", "found", "told"),
    [
        ("excluding the nodes in the obstacles", r"(\d+) of 100 random", r"(\d+) of 100 random"),
        ("q1 by arccos", r"right in (\d+) %", r"(\d+) % of random poses"),
    ],
)
def test_lessons_quote_what_is_found(
    comparisons: dict[str, PaperComparison], what: str, found: str, told: str
) -> None:
    files = [one for one in assets.path("lessons").iterdir() if one.is_file()]
    texts = [file.read_text(encoding="utf-8") for file in files]
    quoted = {number for text in texts for number in re.findall(told, text)}
    computed = re.search(found, comparisons[what].ours)
    assert computed is not None
    assert quoted == {computed[1]}


def test_what_does_not_hold_is_shown_to_fail(comparisons: dict[str, PaperComparison]) -> None:
    wrong = {one.subject for one in comparisons.values() if one.verdict == "does not hold"}
    for what in (
        "B-spline on the path's vertices",
        "quadratic fitted by least squares",
        "excluding the nodes in the obstacles",
    ):
        assert what in wrong
        assert not comparisons[what].ours.startswith(("0 of", "enters it in 0"))


def test_our_path_shortens_from_stage_to_stage_as_the_papers(
    comparisons: dict[str, PaperComparison],
) -> None:
    spline = comparisons["length of the B-spline, degree 4"]
    square = comparisons["length of the quadratic"]
    for said in ("printed", "ours"):
        shares = [
            float(getattr(one, said).split(", ")[1].split(" of")[0]) for one in (spline, square)
        ]
        assert 1 > shares[0] > shares[1] > 0.8


def test_the_printed_quadratic_is_as_long_as_printed_and_ends_where_it_should() -> None:
    assert arc_length(printed.QUADRATIC).length == pytest.approx(printed.QUADRATIC_LENGTH, abs=5e-4)
    np.testing.assert_allclose(printed.QUADRATIC([0, 1]), [[0, 0, 0], [6, 6, 6]], atol=1e-12)


@settings(max_examples=examples(33))
@given(st.floats(-np.pi, np.pi), st.floats(0.1, 1.5), st.floats(0.1, 1.5))
def test_printed_q1_is_right_in_one_quadrant(q1: float, q2: float, q3: float) -> None:
    assume(min(abs(q1), abs(q1 - np.pi / 2)) > 1e-5)
    arm = paper_arm(Scene(version=1).arm.model_copy(update={"base": (0.0, 0.0, 0.0)}))
    tool = forward(arm, np.array([[q1, q2, q3, 0, 0, 0]]))
    (found,) = printed.q1(tool)
    assert (abs(found - q1) < 1e-6) == (0 < q1 < np.pi / 2)
