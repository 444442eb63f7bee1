"""Cards of lists: with a picture where there is one, and no empty place where there is none."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from abi import assets
from app.ui import page
from app.ui.cards import Card, cards
from app.ui.scene_cards import scene_cards


def test_a_card_has_a_picture_or_no_place_for_one(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(page, "uuid", lambda widget: "u")
    widget: Any = SimpleNamespace()
    shown = cards(widget, [Card("A <b>", "note", tmp_path / "missing.webp")])
    assert "<img" not in shown
    assert "<i" not in shown
    assert "A &lt;b&gt;" in shown
    picture = assets.path("pictures", "scenes", "paper.webp")
    assert cards(widget, [Card("A", "note", picture)]).count("<img") == 1


def test_every_shipped_scene_and_lesson_has_its_picture() -> None:
    assert all(card.picture.is_file() for card in scene_cards("paper"))
    for lesson in assets.path("lessons").glob("*.yaml"):
        assert assets.path("pictures", "lessons", f"{lesson.stem}.webp").is_file(), lesson
