"""A page's report of files that it does not send."""

from __future__ import annotations

import json
from typing import Any

import pytest

from app.tab.refused_files import refusal

REASONS: list[Any] = [None, [], {}, 3]


@pytest.mark.parametrize(
    "text",
    ["", "[]", "null", "{}", '{"name": "a", "why": "no reason", "kinds": ""}', "[" * 100_000]
    + [json.dumps({"name": "a.stl", "why": why, "kinds": ""}) for why in REASONS],
)
def test_nonsense_is_not_told(text: str) -> None:
    assert refusal(text) is None


def test_file_and_reason_are_named() -> None:
    text = {"name": "x" * 300 + "\n\u202e.txt", "why": "kind", "kinds": ".stl,.obj" + "," * 500}
    title, reason = refusal(json.dumps(text)) or ("", "")
    assert title.endswith("x.txt is not sent")
    assert len(title) < 60
    assert reason.startswith("This button takes .stl, .obj")
    assert len(reason) < 350
    # braces of a page are no fields
    text["kinds"] = "{0.__class__}"
    assert "{0.__class__}" in (refusal(json.dumps(text)) or ("", ""))[1]
