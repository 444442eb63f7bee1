"""Tables of the result tab."""

from __future__ import annotations

import re
from dataclasses import replace
from html import unescape

import pytest

import abi
from abi.scene.scene import load_scene
from app.layers.tables import _searches


@pytest.mark.parametrize("ms", [0.01, 0.99, 13.0, 40_000.0])
def test_the_table_is_as_high_however_long_the_searches_took(ms: float) -> None:
    plan = abi.Planner()(load_scene("paper"))
    slow = replace(plan, ms=dict.fromkeys(plan.ms, ms))
    told, usual = (unescape(re.sub(r"<.*?>", " ", _searches(one, False))) for one in (slow, plan))
    times = re.compile(r"Time, in this order: (.*)\.")
    (line,), (usual_line,) = times.findall(told), times.findall(usual)
    assert times.sub("", told) == times.sub("", usual)
    assert len(line.split(", ")) == len(usual_line.split(", ")) == len(plan.searches)
    # of some 55 letters that a line of the panel has
    assert len(f"Time, in this order: {line}.") < 48
