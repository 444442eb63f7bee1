"""Legs of a sequence of tasks in a tab: one after the other, and back."""

from __future__ import annotations

import itertools
import re
from functools import partial
from html import unescape

import pytest

from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.planner.plan import Plan
from abi.scene.scene import load_scene
from app.panels import playback
from app.panels.legs import LegsCard
from app.state.frame import Frame
from app.state.known_legs import legs_of
from app.state.tab_state import TabState
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, until


def told(session: Session) -> str:
    shown = session.panels.layout.overlay.shown.get("message", "")
    return unescape(re.sub(r"<.*?>", " ", shown)).replace("\N{NO-BREAK SPACE}", " ")


def at_leg(session: Session, number: int) -> bool:
    legs = session.panels.messages.legs._legs
    return session.resting and len(legs) > number and session.frame.plan is legs[number].plan


@pytest.mark.slow  # three plans of a real arm
def test_the_object_is_taken_along_from_leg_to_leg_and_stands_again_where_one_goes_back(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    legs, whole = session.panels.messages.legs, load_scene("pick-and-place")
    assert legs.html() == ""
    fake.set(session.panels.files.choice, "pick-and-place")
    until(lambda: at_leg(session, 0))
    assert "Leg 1 of 6 : above the block." in told(session)

    for number in (1, 2):
        until(lambda: legs.state()[2] is True)
        last = session.frame.plan.motion
        assert last is not None
        fake.set(legs.go_on, True)
        until(partial(at_leg, session, number))
        motion = session.frame.plan.motion
        assert motion is not None
        assert abs(motion.positions[0] - last.positions[-1]).max() <= 1e-9
        assert f"Leg {number + 1} of 6" in told(session)
    scene = session.frame.plan.scene
    assert len(scene.obstacles) == len(whole.obstacles) - 1
    assert scene.arm.attached is not None

    for number in (1, 0):
        fake.set(legs.go_back, True)
        until(partial(at_leg, session, number))
        assert session.frame.plan.scene.arm.attached is None
    assert session.frame.plan.scene == whole
    fake.set(session.panels.files.choice, "paper")
    until(lambda: session.resting and session.frame.plan.scene.arm.model == "abi")
    until(lambda: "Leg" not in told(session))


@pytest.mark.slow  # six plans of a real arm
def test_what_plays_goes_through_all_legs_and_begins_anew(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    legs, player = session.panels.messages.legs, session.playback
    monkeypatch.setitem(playback.SPEEDS, "real time", 20.0)
    shown: list[tuple[int, Plan]] = []
    early: list[bool] = []
    draw = session._view.draw

    def watched(frame: Frame) -> Frame:
        drawn = draw(frame)
        if legs.shows(drawn) and drawn.current and (not shown or shown[-1][1] is not drawn.plan):
            shown.append((legs.number or 0, drawn.plan))
            early.append(drawn.time < drawn.duration)
        return drawn

    monkeypatch.setattr(session._view, "draw", watched)
    fake.set(session.panels.files.choice, "pick-and-place")
    count = len(load_scene("pick-and-place").tasks)
    until(lambda: [number for number, _ in shown].count(count - 1) >= 2)
    fake.set(player.button, True)
    until(lambda: not player.playing)

    numbers = [number for number, _ in shown]
    begin = numbers.index(1)
    assert numbers[begin : begin + 2 * count - 1] == [*range(1, count), *range(count)]
    # the arm goes on from where it is, the clock anew, and what has been planned is not again
    assert all(early[begin:])
    for (_, plan), (number, other) in itertools.pairwise(shown[begin - 1 : begin + count - 1]):
        assert plan.motion is not None
        assert other.motion is not None
        if number:
            assert abs(other.motion.positions[0] - plan.motion.positions[-1]).max() <= 1e-9
    assert [plan for _, plan in shown[begin : begin + count - 1]] == [
        plan for _, plan in shown[begin + count : begin + 2 * count - 1]
    ]
    assert "The time bar is of all legs, " in told(session)
    # playing has not filled what can be undone
    fake.set(session.panels.history.undo, True)
    until(lambda: session.resting and session.frame.plan.scene.arm.model == "abi")


def stand_on_the_first_leg(fake: FakeTab, session: Session) -> None:
    """Stop the player, open the tasks, and wait until their first leg is planned."""
    fake.set(session.playback.button, True)
    until(lambda: not session.playback.playing)
    fake.set(session.panels.files.choice, "pick-and-place")
    until(lambda: at_leg(session, 0) and session.panels.messages.legs.state()[2] is True)


@pytest.mark.slow  # two plans of a real arm
def test_a_leg_asked_for_begins_at_its_begin_also_while_the_arm_stands(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    legs, player = session.panels.messages.legs, session.playback
    stand_on_the_first_leg(fake, session)
    fake.set(player.slider, 1.0)
    until(lambda: session.resting and abs(session.frame.time - 1.0) < 1e-6)
    fake.set(legs.go_on, True)
    until(partial(at_leg, session, 1))
    first = legs._legs[0].plan
    assert first is not None
    assert session.frame.time == 0
    assert abs(player.slider.value - first.motion.time[-1]) <= 0.01  # type: ignore[union-attr]
    assert not player.playing


@pytest.mark.slow  # three plans of a real arm
def test_the_slider_leads_to_every_leg_that_is_known_and_a_reload_keeps_them(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    legs, player = session.panels.messages.legs, session.playback
    stand_on_the_first_leg(fake, session)
    for number in (1, 2):
        fake.set(legs.go_on, True)
        until(partial(at_leg, session, number))
        until(lambda: legs.state()[2] is True)
    begins = legs.begins_on_bar(session.frame)
    assert len(begins) == len(load_scene("pick-and-place").tasks) + 1
    assert player.slider.max == round(begins[-1], 2)

    # back into the first leg, within it, and on to the third
    for moment, number in ((0.5, 0), (0.9, 0), (begins[2] + 0.4, 2), (begins[1], 1)):
        fake.set(player.slider, moment)
        until(partial(at_leg, session, number))
        until(lambda at=moment - begins[number]: abs(session.frame.time - at) < 0.02)  # type: ignore[misc]
        assert abs(player.slider.value - moment) < 0.02
    # past what is planned: the next leg, from its begin
    fake.set(player.slider, begins[-1])
    until(partial(at_leg, session, 3))
    assert session.frame.time == 0

    text = session.state().encode()
    state = TabState.decode(text, MeshSource())
    scenes = [leg.scene for leg in legs._legs[:3]]
    assert [leg.scene for leg in state.tasks] == scenes
    card = LegsCard(session.client.gui, lambda event: None)
    card.restore(state.tasks)
    card.see(session.frame)
    assert "Leg 4 of 6" in card.html()
    ends = [(leg.joints, leg.duration) for leg in legs._legs]
    assert [(leg.joints, leg.duration) for leg in card._legs] == ends
    # what tells another sequence is not taken for this one
    whole, number = state.tasks[0].scene, len(state.tasks)
    # the second leg does not end there
    aside = {name: at + 0.01 * (name == ends[0][0][0][0]) for name, at in ends[1][0]}
    turned = [[dict(ends[0][0]), ends[0][1]], [aside, 1.0], [dict(ends[2][0]), 1.0]]
    for data in (
        [number, turned],
        [number, []],
        [len(whole.tasks), [[{}, 1.0]] * 6],
        [number, [[{"a": "b"}, 1.0]] * 3],
    ):
        assert legs_of(whole, data) == ()
    card.restore(legs_of(whole, [number, [[{"elbow": 1.0}, 1.0]] * 3]))
    assert card.html() == ""
