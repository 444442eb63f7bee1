"""What a page says of its size, and what panels and camera make of that."""

from __future__ import annotations

import json
from dataclasses import asdict
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app import page
from app.page_area import PageArea
from app.panel_folding import NARROW, PanelFolding
from app.session import Session
from tests.app.fake_tab import FakeTab, until

WIDE = PageArea(width=1280, left=348, right=384)
SLIM = PageArea(width=900, left=40, right=40)


@given(st.text(max_size=50) | st.recursive(st.none() | st.floats() | st.text(), st.lists).map(str))
def test_nonsense_is_no_area(text: str) -> None:
    assert PageArea.of(text) is None


@pytest.mark.parametrize("wrong", [{"width": -1}, {"below": 2}, {"left": 1e9}, {"above": "x"}])
def test_an_area_of_wrong_numbers_is_none(wrong: dict[str, Any]) -> None:
    fields = asdict(WIDE)
    assert PageArea.of(json.dumps(fields)) == WIDE
    assert PageArea.of(json.dumps(fields | wrong)) is None


class _Panel:
    def __init__(self) -> None:
        self.open = True

    def minimize(self) -> None:
        self.open = False

    def expand(self) -> None:
        self.open = True


def _folding() -> tuple[PanelFolding, _Panel, _Panel]:
    left, right = _Panel(), _Panel()
    layout: Any = SimpleNamespace(client=None, panels=(left, right))
    return PanelFolding(layout), left, right


def test_a_window_made_narrow_folds_its_panels_and_unfolds_them_when_wide() -> None:
    folding, left, right = _folding()
    folding.update(WIDE, False)
    assert left.open
    # as long as the page has not folded them, it says that they are open
    for area in (PageArea(NARROW - 1, 348, 384), SLIM):
        folding.update(area, False)
        assert not left.open
        assert not right.open
    folding.update(PageArea(1280, 40, 40), False)
    assert left.open
    assert right.open


def test_what_a_hand_has_folded_or_unfolded_stays() -> None:
    folding, left, right = _folding()
    folding.update(WIDE, False)
    left.open = False  # by hand
    folding.update(PageArea(1280, 40, 384), False)
    folding.update(PageArea(900, 40, 384), False)
    folding.update(SLIM, False)
    assert not right.open
    folding.update(PageArea(1280, 40, 40), False)
    assert not left.open
    assert right.open

    folding.update(SLIM, False)
    folding.update(SLIM, False)
    for width, is_open in ((384, True), (40, False)):  # opened by hand, and folded again
        right.open = is_open
        folding.update(PageArea(900, 40, width), False)
    folding.update(PageArea(1280, 40, 40), False)
    assert not right.open


def test_the_end_of_a_lecture_leaves_a_narrow_page_folded() -> None:
    folding, left, right = _folding()
    folding.update(WIDE, True)
    assert not left.open
    folding.update(PageArea(1280, 40, 40), True)
    folding.update(SLIM, True)
    folding.update(SLIM, False)
    assert not right.open
    folding.update(PageArea(1280, 40, 40), False)
    assert right.open


def test_before_the_page_has_panels_nothing_is_taken_for_folded() -> None:
    folding, left, _ = _folding()
    folding.update(PageArea(900, 0, 0), False)
    assert not left.open
    folding.update(PageArea(1280, 40, 40), False)
    assert left.open


def test_a_phone_folds_its_sheet_once(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[str] = []
    monkeypatch.setattr(page, "fold_sheet", lambda _, label: told.append(label))
    folding, left, _ = _folding()
    folding.update(WIDE, False)
    for _ in range(3):
        folding.update(PageArea(390, 0, 0), False)
    assert len(told) == 1
    assert left.open
    folding.update(SLIM, False)
    assert not left.open


def test_a_new_area_is_no_input(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    watch = session._view._watch
    session._pause.begin()
    begun = session._pause._begun
    fake.set(watch._box, json.dumps(asdict(SLIM)))
    until(lambda: watch.area() == SLIM)
    until(lambda: session._view._folding._narrow)
    assert session._pause._begun == begun
