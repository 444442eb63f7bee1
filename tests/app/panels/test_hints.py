"""Each number of the results says what it means."""

from __future__ import annotations

import re

import pytest

import abi
from abi.planner.plan import Plan
from app.layers.result.tables import _searches, _stages
from app.panels.headline import headline
from app.stages.catalogue import SHOWN_STAGES
from app.state.legend import SWITCHES
from app.tab.session import Session
from app.ui.numbers import format_setting
from tests.app.fake_tab import FakeTab, until

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


@pytest.mark.parametrize("name", ["taut", "ghost", "bases", "tool_only", "other_elbow"])
def test_a_layer_that_is_not_always_there_says_when(
    name: str, tab: tuple[FakeTab, Session]
) -> None:
    _, session = tab
    (switch,) = (one for one in SWITCHES if one.name == name)
    assert len(switch.hint or "") > 20
    assert session.panels.layer_switches.boxes[name].hint == switch.hint


def test_each_large_number_is_explained(plan: Plan) -> None:
    made = headline(plan)
    assert made.count("<div title=") == made.count("<span>")
    assert (made == "") == (plan.followed is None)


def test_each_number_of_a_stage_is_explained_and_is_its_own(plan: Plan) -> None:
    shown = [number for stage in SHOWN_STAGES for number in SHOWN_STAGES[stage].numbers(plan)]
    assert all(len(hint) > 10 for _, _, hint in shown)
    told = {
        stage: {name for _, name, _ in one.numbers(plan)} for stage, one in SHOWN_STAGES.items()
    }
    assert all(1 < len(names) < 4 for names in told.values() if names)
    assert not told["mesh"] & told["graph"]
    assert not told["quadratic"] & told["arm"]


def test_the_numbers_of_grid_and_graph_are_the_plans(plan: Plan) -> None:
    assert plan.free is not None
    assert plan.graph is not None
    (free, *_), (tetrahedra, *_), (removed, *_) = SHOWN_STAGES["mesh"].numbers(plan)
    points = len(plan.free.mesh.points)
    assert int(free.replace(",", "")) + int(removed.replace(",", "")) == points
    assert int(tetrahedra.replace(",", "")) == plan.free.tetrahedra_kept
    kept, whole = SHOWN_STAGES["graph"].numbers(plan)[0][0].replace(",", "").split(" of ")
    assert int(whole) - int(kept) == plan.graph.removed_edges


def test_the_quadratic_tells_how_near_it_comes_itself() -> None:
    made = abi.plan(abi.load_scene("paper"))
    numbers = {name: value for value, name, _ in SHOWN_STAGES["quadratic"].numbers(made)}
    assert "✗" in numbers["closest to an obstacle (curve)"]
    assert numbers["top speed"] == "4.000 cm/s"
    assert numbers["speed up, cruise, brake"] == "0.67 + 2.19 + 0.67 s"


def test_each_number_box_tells_its_range(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    fake.set(session.panels.files.choice, "kitchen-ur5e")
    until(lambda: session.frame.plan.scene == abi.load_scene("kitchen-ur5e") and session.resting)
    stages, editor = session.panels.stages, session.panels.editor
    pitch = stages.fields["mesh.pitch"]
    assert pitch.hint is not None
    assert pitch.hint.endswith(
        f" From {format_setting(pitch.min)} to {format_setting(pitch.max)} m."
    )
    until(lambda: "x from −0.5 to 0.5" in (editor._end_boxes["goal"].handle.hint or ""))
    arm, sizes = stages.arm, editor.sizes
    lengths = (arm.columns, arm.links, arm.masses, arm.radii)
    names = ("speed", "acceleration", "joint_acceleration", "jerk")
    rates = [stages.fields[f"motion.{name}"] for name in names]
    for box in (*lengths, *rates, sizes.size, sizes.radius, sizes.height, sizes.scale):
        assert "above 0" in (box.hint or "").lower()
    for hint in (arm.clearance.hint, arm.extension.hint, stages.fields["mesh.seed"].hint):
        assert "0 or more" in (hint or "")
    for slider in (pitch, stages.fields["spline.degree"], stages.fields["spline.clearance"]):
        assert re.search(r"From \S+ to \S+", slider.hint or "")
