"""A page's report of its size, and the panels and camera that follow it."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.tab.session import Session
from app.ui.page_area import PageArea, label_scale
from app.ui.panel_folding import NARROW, folding
from tests.app.fake_tab import FakeTab, labelled, until

WIDE = PageArea(width=1280, left=348, right=384)
SLIM = PageArea(width=900, left=40, right=40)


@given(st.text(max_size=50) | st.recursive(st.none() | st.floats() | st.text(), st.lists).map(str))
def test_nonsense_is_no_area(text: str) -> None:
    assert PageArea.of(text) is None


@pytest.mark.parametrize(
    "wrong", [{"width": -1}, {"height": 1e9}, {"below": 2}, {"left": 1e9}, {"above": "x"}]
)
def test_an_area_of_wrong_numbers_is_none(wrong: dict[str, Any]) -> None:
    fields = asdict(WIDE)
    assert PageArea.of(json.dumps(fields)) == WIDE
    assert PageArea.of(json.dumps(fields | wrong)) is None


def _area(width: float, left: float, right: float) -> PageArea:
    return PageArea(width=width, left=left, right=right)


class _Panel:
    def __init__(self) -> None:
        self.open = True

    def minimize(self) -> None:
        self.open = False

    def expand(self) -> None:
        self.open = True


def _folding() -> tuple[Callable[[PageArea, bool], None], _Panel, _Panel]:
    """How both panels are told of the page, and these."""
    left, right = _Panel(), _Panel()
    panels: Any = left, right
    foldings = [folding(panel, is_left=panel is left) for panel in panels]

    def update(area: PageArea, lecture: bool) -> None:
        for fold in foldings:
            fold(area, lecture)

    return update, left, right


def test_a_window_made_narrow_folds_its_panels_and_unfolds_them_when_wide() -> None:
    update, left, right = _folding()
    update(WIDE, False)
    assert left.open
    # as long as the page has not folded them, it says that they are open
    for area in (_area(NARROW - 1, 348, 384), SLIM):
        update(area, False)
        assert not left.open
        assert not right.open
    update(_area(1280, 40, 40), False)
    assert left.open
    assert right.open


def test_what_a_hand_has_folded_or_unfolded_stays() -> None:
    update, left, right = _folding()
    update(WIDE, False)
    left.open = False  # by hand
    update(_area(1280, 40, 384), False)
    update(_area(900, 40, 384), False)
    update(SLIM, False)
    assert not right.open
    update(_area(1280, 40, 40), False)
    assert not left.open
    assert right.open

    update(SLIM, False)
    update(SLIM, False)
    for width, is_open in ((384, True), (40, False)):  # opened by hand, and folded again
        right.open = is_open
        update(_area(900, 40, width), False)
    update(_area(1280, 40, 40), False)
    assert not right.open


def test_the_end_of_a_lecture_leaves_a_narrow_page_folded() -> None:
    update, left, right = _folding()
    update(WIDE, True)
    assert not left.open
    update(_area(1280, 40, 40), True)
    update(SLIM, True)
    update(SLIM, False)
    assert not right.open
    update(_area(1280, 40, 40), False)
    assert right.open


def test_before_the_page_has_panels_nothing_is_taken_for_folded() -> None:
    update, left, _ = _folding()
    update(_area(900, 0, 0), False)
    assert not left.open
    update(_area(1280, 40, 40), False)
    assert left.open


def test_a_phones_sheet_is_left_to_the_page() -> None:
    update, left, _ = _folding()
    update(WIDE, False)
    for _ in range(3):
        update(_area(390, 0, 0), False)
    assert left.open
    update(SLIM, False)
    assert not left.open


@given(
    st.floats(0, 4000), st.floats(0, 4000), st.floats(0, 400), st.floats(0, 400), st.floats(1, 2)
)
def test_labels_of_a_lecture_are_larger_where_the_scene_is(
    width: float, height: float, left: float, right: float, factor: float
) -> None:
    area = PageArea(width, height, left, right)
    larger = PageArea(factor * width, factor * height, left, right)
    assert label_scale(area, False) == 1
    assert 1 < label_scale(area, True) <= label_scale(larger, True)
    # never more than a part of the scene, but for what must be read
    letters = 12 * label_scale(area, True)
    assert letters <= max(15, 0.04 * min(width - left - right, height))


def test_a_lectures_labels_follow_the_page_while_nothing_else_happens(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    box = labelled(session, "area")
    fake.set(session.panels.lecture.toggle, True)
    until(lambda: session.frame.lecture and session.resting)
    scales = []
    for height in (400, 1000):
        area = PageArea(width=1900, height=height)
        fake.set(box, json.dumps(asdict(area)))
        until(lambda: session._view._area() == area)  # noqa: B023
        until(lambda: session.frame.label_scale == label_scale(session._view._area(), True))
        scales.append(session.frame.label_scale)
        for label in session.panels.ends._labels.values():
            until(lambda: label.font_screen_scale == scales[-1])  # noqa: B023
    assert scales[0] < scales[1]


def test_for_a_page_that_nobody_sees_nothing_follows_from_the_time(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    view = session._view
    until(lambda: session.resting)
    monkeypatch.setattr(session.panels.theatre, "timeout", lambda: 0.1)
    for hidden in (False, True, False):
        area = replace(WIDE, hidden=hidden)
        fake.set(labelled(session, "area"), json.dumps(asdict(area)))
        until(lambda: view._area() == area)  # noqa: B023
        assert (view.timeout(session.frame) is None) == hidden
        assert view.is_due(session.frame) != hidden


def test_a_new_area_is_no_input(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    box, fitted = labelled(session, "area"), list[PageArea]()
    monkeypatch.setattr(session._view.viewpoint, "fit", lambda area, **_: fitted.append(area))
    session._pause.begin()
    begun = session._pause._begun
    fake.set(box, json.dumps(asdict(SLIM)))
    until(lambda: session._view._area() == SLIM)
    until(lambda: SLIM in fitted)
    assert session._pause._begun == begun
