from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from abi import assets
from app.ui.formulas import with_formulas

LESSONS = sorted(assets.path("lessons").glob("*.md"))


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_every_formula_of_a_lesson_becomes_mathml(path: Path) -> None:
    text = with_formulas(path.read_text(encoding="utf-8"))

    assert "$" not in text
    formulas = [part.split("</math>")[0] for part in text.split("<math")[1:]]
    assert len(formulas) > 10
    for formula in formulas:
        tree = ElementTree.fromstring(f"<math{formula}</math>")
        unknown = [element.text for element in tree.iter() if (element.text or "").startswith("\\")]
        assert not unknown


def test_links_and_accelerations_have_letters_of_their_own() -> None:
    text = assets.path("lessons", "paper.md").read_text(encoding="utf-8")
    before, arm = text.split("#### 6 · Arm")
    # in brackets stands what the paper writes
    assert re.findall(r"[ab]_\d", re.sub(r"\(For .*?\)", "", before)) == []
    assert re.findall(r"= V|V /", arm) == []


def test_inline_and_block() -> None:
    text = with_formulas("a $x^2$ b\n$$y$$\nc")

    assert text.count('display="inline"') == 1
    assert text.count('display="block"') == 1
    assert text.startswith("a <math")
