"""Cards of lists: with a picture where there is one, and no empty place where there is none."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from abi import assets
from abi.scene.scene import scene_names
from app.ui import page
from app.ui.cards import card


def test_a_card_has_a_picture_or_no_place_for_one(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(page, "uuid", lambda widget: "u")
    widget: Any = SimpleNamespace()
    shown = card(widget, "A <b>", "note", tmp_path / "missing.webp")
    assert "<img" not in shown
    assert "<i" not in shown
    assert "A &lt;b&gt;" in shown
    picture = assets.path("pictures", "scenes", "paper.webp")
    assert card(widget, "A", "note", picture).count("<img") == 1


def test_every_shipped_scene_and_lesson_has_its_picture() -> None:
    for scene in scene_names():
        assert assets.path("pictures", "scenes", f"{scene}.webp").is_file(), scene
    for lesson in assets.path("lessons").glob("*.yaml"):
        assert assets.path("pictures", "lessons", f"{lesson.stem}.webp").is_file(), lesson
