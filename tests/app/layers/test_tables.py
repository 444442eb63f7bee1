"""Tables of the result tab."""

from __future__ import annotations

import contextlib
import re
from dataclasses import replace
from html import unescape
from types import SimpleNamespace

import pytest

import abi
from abi.errors import SceneError
from abi.planner.arm_words import arm_result, contact_sentence
from abi.planner.plan import Plan
from abi.scene.scene import load_scene
from app.layers.result.plan_numbers import plan_numbers_layer
from app.layers.result.tables import _searches, _stages
from app.panels.plan_sentence import _replan_ms, plan_sentence
from app.panels.stages.stage_headings import headings
from app.state.frame import Frame
from app.ui.numbers import format_length
from app.ui.plan_notes import notes


@pytest.mark.parametrize("ms", [0.01, 0.99, 13.0, 40_000.0])
def test_the_table_is_as_high_however_long_the_searches_took(ms: float) -> None:
    plan = abi.Planner()(load_scene("paper"))
    slow = replace(plan, ms=dict.fromkeys(plan.ms, ms))
    told, usual = (unescape(re.sub(r"<.*?>", " ", _searches(one, {}))) for one in (slow, plan))
    times = re.compile(r"\d[\d.]* (?:µs|ms|s)\b")
    assert times.sub("", told) == times.sub("", usual)
    assert len(times.findall(told)) == len(times.findall(usual)) == len(plan.searches)
    assert max(map(len, times.findall(told))) <= 6


@pytest.mark.parametrize(
    ("name", "arm", "heading"),
    [
        ("wrong-elbow", {"elbow": "up"}, "no motion ✗"),
        ("drag-a-box", {"elbow": "down"}, "no motion ✗"),
        ("paper", {"base": (3.0, -30.0, 0.0)}, "out of reach ✗"),
    ],
)
def test_an_arm_without_a_motion_has_one_reason_everywhere(
    name: str, arm: dict[str, object], heading: str
) -> None:
    plan = abi.plan(load_scene(name).replace(arm=arm))
    assert plan.error is not None
    assert arm_result(plan) == heading
    first, _, rest = notes(plan)["arm"].partition("<br>")
    assert plan.error.message in unescape(first)
    assert "<details" not in rest.partition("tool tip alone.")[0]
    row = unescape(_stages(plan)).partition("whole arm")[2].partition("</tr>")[0]
    assert "none ✗" in row
    assert "<b> ▸</b>" not in _stages(plan)  # nothing is followed
    assert not re.search(r"\d ✗", row)


def test_a_link_that_touches_counts_before_a_joint_that_lacks_room() -> None:
    plan = abi.plan(load_scene("drag-a-box").replace(arm={"elbow": "down"}))
    assert plan.error is not None
    assert "the upper arm touches the floor at the start" in plan.error.message


def test_the_arms_row_has_the_depth_of_the_contact_that_is_told() -> None:
    plan = abi.plan(load_scene("drag-a-box").replace(arm={"elbow": "down", "avoid": False}))
    assert plan.arm_clearance is not None
    worst = plan.arm_clearance.contacts[0]
    row = unescape(_stages(plan)).partition("whole arm")[2]
    assert contact_sentence(worst, "cm") in row
    assert f"−{format_length(worst.depth)} ✗" in row


class _Tables:
    """The layer without a page."""

    def __init__(self) -> None:
        self._texts: list[SimpleNamespace] = []
        gui = SimpleNamespace(add_html=self._add)
        folders = dict.fromkeys(("bspline", "quadratic", "arm"), contextlib.nullcontext())
        layout = SimpleNamespace(
            result=contextlib.nullcontext(), folders=folders, client=SimpleNamespace(gui=gui)
        )
        self._draw = plan_numbers_layer(layout)  # type: ignore[arg-type]

    def _add(self, content: str) -> SimpleNamespace:
        self._texts.append(SimpleNamespace(content=content))
        return self._texts[-1]

    def show(self, plan: Plan, partial: bool = False) -> list[list[str]]:
        """The cells of every row, and the paragraphs."""
        self._draw(Frame(replace(plan, coarse=partial, partial=partial)))
        rows = re.findall(r"<tr>(.*?)</tr>|<div[^>]*>(?!<table)(.*?)</div>", self._texts[0].content)
        return [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row) or [text] for row, text in rows]


def test_tables_keep_their_rows_while_a_hand_drags() -> None:
    scene, tables = load_scene("paper"), _Tables()
    full = abi.Planner()(scene)
    at_rest = tables.show(full)
    one = abi.Planner()(scene.replace(mesh={"pitch": 0.4}), chosen_only=True)
    assert len(one.searches) == 1
    preview = tables.show(one, partial=True)
    assert list(map(len, preview)) == list(map(len, at_rest))
    others = [
        index
        for index, (new, old) in enumerate(zip(preview, at_rest, strict=True))
        if "Dijkstra" in old[0] or "Bellman" in old[0]
    ]
    assert len(others) == 2
    for index in others:
        cells = [re.sub("<.*?>", "", cell) for cell in preview[index]]
        assert cells == [re.sub("<.*?>", "", cell) for cell in at_rest[index]]
        assert all("opacity" in cell for cell in preview[index][1:])
    assert tables.show(full) == at_rest


@pytest.mark.parametrize("partial", [False, True])
def test_tables_are_as_high_where_there_is_no_path(partial: bool) -> None:
    tables = _Tables()
    at_rest = tables.show(abi.Planner()(load_scene("two-boxes")))
    blocked = abi.Planner()(load_scene("no-way"))
    assert blocked.error is not None
    missed = tables.show(blocked, partial)
    assert list(map(len, missed)) == list(map(len, at_rest))
    # numbers of another plan would be taken for this one's
    assert "opacity" not in str(missed)


def test_a_preview_is_marked_once() -> None:
    plan = abi.Planner()(load_scene("paper"))
    labels = []
    for coarse in (False, True):
        frame = Frame(replace(plan, coarse=coarse, partial=coarse))
        labels.append(headings(frame))
        assert plan_sentence(frame).count("≈") == coarse
    assert labels[0] == labels[1]
    assert plan_sentence(Frame(replace(plan, partial=True))).count("≈") == 1


def test_a_heading_and_the_table_judge_the_quadratic_alike() -> None:
    for name in ("paper", "forest", "two-boxes"):
        made = abi.Planner()(load_scene(name))
        assert made.quadratic is not None
        fit = made.quadratic
        noted = replace(made, quadratic=replace(fit, note="The arm cannot follow it."))
        for plan in (made, noted):
            folders = headings(Frame(plan))
            assert ("✓" in folders["quadratic"]) == fit.holds
            row = _stages(plan).split("quadratic")[1].split("</tr>")[0]
            assert ("✓" in row) == ("✓" in folders["quadratic"])


def test_after_a_refused_change_no_result_is_called_good() -> None:
    plan = abi.Planner()(load_scene("paper"))
    error = SceneError("spline.degree", 9, "at most 5")
    folders = headings(Frame(plan, refused=error))
    assert "✓" in str(headings(Frame(plan)))
    assert "✓" not in str(folders)
    assert "not changed ✗" in folders["bspline"]


def test_a_plan_that_ends_in_the_timing_tells_so_beside_the_quadratic() -> None:
    plan = abi.plan(load_scene("paper").replace(motion={"time_step": 1e-5}))
    assert plan.error is not None
    assert plan.error.stage == "timing"
    assert "✗" in headings(Frame(plan))["quadratic"]


def test_the_time_told_is_that_of_all_stages() -> None:
    planner, scene = abi.Planner(), load_scene("paper").replace(mesh={"pitch": 0.5})
    first = planner(scene, chosen_only=True)
    second = planner(scene)  # does what was left
    assert _replan_ms(second) > _replan_ms(first) > first.ms["mesh"] + first.ms["graph"]
    third = planner(scene)  # has nothing to do
    assert third.total_ms < _replan_ms(third) == _replan_ms(second)
    assert _replan_ms(replace(third, ms=dict.fromkeys(third.ms, 0.0))) == 0
