"""Values of widgets, files and rates: what is let through, and what is not."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.guard.connection import BURST, paid_until
from app.guard.messages import UploadPart, UploadStart
from app.guard.uploads import MAX_TRANSFERS, Uploads
from app.guard.values import MAX_TEXT, fits


@pytest.mark.parametrize(
    ("held", "good", "bad"),
    [
        (True, [False], [1, 0.0, None, "x"]),
        (3, [4, 4.0, -1], [math.nan, math.inf, 1e300, True, "4", [4], None]),
        (1.5, [2, -1e308, math.nan], [True, "2", None, [2]]),
        ("a", ["", "b" * 10_000], ["b" * (MAX_TEXT + 1), 1, None, ["b"]]),
        ((1.0, 2.0), [[3, 4.5]], [[1], [1, 2, 3], [1, "2"], [1, None], 1, "12", {}]),
        (b"an uploaded file", [], [b"x", "x", None, 1]),
    ],
)
def test_a_value_must_be_of_the_kind_that_the_widget_holds(
    held: object, good: list[object], bad: list[object]
) -> None:
    widget = SimpleNamespace(value=held)
    assert all(fits(widget, value) for value in good)
    assert not any(fits(widget, value) for value in bad)


def test_a_choice_must_be_one_of_the_options() -> None:
    widget = SimpleNamespace(value="a", options=("a", "b"))
    assert fits(widget, "b")
    assert not any(fits(widget, value) for value in ("c", "__init__", None, 0, ["a"]))


def _start(size: int, parts: int, name: str = "scene.yaml", number: int = 0) -> UploadStart:
    return UploadStart("button", str(number), name, "", parts, size)


def _part(size: int, number: int = 0) -> UploadPart:
    return UploadPart("button", str(number), 0, bytes(size))


BUTTON = SimpleNamespace(mime_type=".yaml,.yml,.json")


def test_a_file_is_of_a_kind_that_the_button_takes() -> None:
    assert Uploads().begins(_start(3, 1, "Scene.YML"), BUTTON)
    assert not Uploads().begins(_start(3, 1, "scene.html"), BUTTON)
    assert not Uploads().begins(_start(3, 1, "yaml"), BUTTON)
    assert Uploads().begins(_start(3, 1, "anything"), SimpleNamespace(mime_type="*/*"))


@given(st.integers(0, 40), st.integers(1, 5), st.lists(st.integers(0, 20), max_size=12))
def test_no_more_comes_than_was_announced(size: int, parts: int, sent: list[int]) -> None:
    uploads = Uploads()
    assert uploads.begins(_start(size, parts), BUTTON)
    taken = [length for length in sent if uploads.continues(_part(length))]
    assert sum(taken) <= size
    assert len(taken) <= parts


def test_a_tab_sends_few_files_at_once() -> None:
    uploads = Uploads()
    for number in range(MAX_TRANSFERS):
        assert uploads.begins(_start(3, 1, number=number), BUTTON)
    assert not uploads.begins(_start(3, 1, number=MAX_TRANSFERS), BUTTON)
    assert not uploads.continues(_part(3, number=MAX_TRANSFERS))
    assert uploads.continues(_part(3, number=0))
    assert not uploads.continues(_part(0, number=0))
    assert uploads.begins(_start(3, 1, number=MAX_TRANSFERS), BUTTON)


def test_a_burst_passes_and_what_is_over_the_rate_waits() -> None:
    now, cost = 50.0, BURST / 20
    paid = 0.0
    for number in range(120):
        paid = paid_until(paid, now, cost)
        pause = max(paid - now - BURST, 0.0)
        assert number >= 20 or pause == pytest.approx(0.0)
        now += pause
    assert now - 50.0 == pytest.approx(100 * cost)
