"""Each number of the results says what it means."""

from __future__ import annotations

import re

import pytest

import abi
from abi.planner.plan import Plan
from app.layers.headline import headline
from app.layers.tables import _searches, _stages

NAMED = {"search", "stage"}
"""Headings over names."""


@pytest.fixture(scope="module", params=["paper", "forest", "wrong-elbow", "no-way"])
def plan(request: pytest.FixtureRequest) -> Plan:
    return abi.plan(abi.load_scene(request.param))


def test_each_heading_of_the_results_is_explained(plan: Plan) -> None:
    for made in (_searches(plan, {}), _stages(plan)):
        heads = re.findall(r"<th([^>]*)>(.*?)</th>", made)
        assert len(heads) > 3
        assert {text for attribute, text in heads if "title=" not in attribute} <= NAMED
    assert re.search(r'<td colspan="4" title="[^"]+"[^>]*>best possible', _stages(plan))


def test_each_large_number_is_explained(plan: Plan) -> None:
    made = headline(plan)
    assert made.count("<div title=") == made.count("<span>")
    assert (made == "") == (plan.followed is None)
