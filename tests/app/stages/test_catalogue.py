"""Every stage is at all places where one looks for it: a missing one is named."""

from __future__ import annotations

from pathlib import Path

import pytest

import abi
from abi.planner.branch import STAGE_NAMES
from app.stages.catalogue import SHOWN_STAGES, STAGE_OF_ERROR, TITLES
from app.state.legend import SWITCHES

ROOT = Path(__file__).parents[3]
PLAN = abi.plan(abi.load_scene("paper"))
SECTIONS = {"search": "searches"}


def test_errors_and_the_page_know_the_same_stages() -> None:
    assert set(STAGE_OF_ERROR) == set(STAGE_NAMES), "abi/planner/branch.py, STAGE_NAMES"


@pytest.mark.parametrize("name", SHOWN_STAGES)
def test_a_stage_is_everywhere(name: str) -> None:
    number, _, title = TITLES[name].partition(" · ")
    assert PLAN.to_dict().get(SECTIONS.get(name, name)), "abi/planner/plan.py, to_dict"
    assert SHOWN_STAGES[name].result(PLAN), "app/stages/catalogue.py, result"
    assert SHOWN_STAGES[name].numbers(PLAN), "app/stages/catalogue.py, numbers"
    assert SHOWN_STAGES[name].layers <= {one.name for one in SWITCHES}, "app/layers/catalogue.py"
    assert f"\n| {number} | {title}" in (ROOT / "README.md").read_text(encoding="utf-8"), (
        "README.md, the table of the stages"
    )
    assert list(ROOT.glob(f"docs/method/{number}-{name}*.md")), "docs/method"
