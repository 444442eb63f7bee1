"""While the page plays, the server draws only when other links of the arm are to be red."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import pytest

from abi.arm_planning.motion.arm_clearance import ArmClearance, Contact
from abi.planner.planner import Planner
from abi.scene.scene import load_scene
from app.layers.arm.arm import ArmLayer
from app.panels import playback
from app.panels.playback import SPEEDS, PlaybackPanel
from app.state.frame import Frame
from app.tab.session import Session
from app.ui import page
from app.ui.overlay import Overlay
from tests.app.fake_tab import FakeTab

_DURATION = 3.0
_STEP = 0.0073  # [s]
_ROUNDS = 3


def _clearance(*stretches: tuple[str, float, float]) -> ArmClearance:
    contacts = tuple(Contact(link, 0, first, last, first, 0.1) for link, first, last in stretches)
    none: Any = None
    return ArmClearance(none, 0.0, 0.0, 0.0, "", -1, contacts, none)


def _panel(session: Session, clearance: ArmClearance | None, speed: str) -> PlaybackPanel:
    client = session.client
    panel = PlaybackPanel(client.gui, Overlay(client), lambda event: None)
    panel.speed.value = speed  # type: ignore[misc]
    panel.mark(clearance, _DURATION)
    return panel


@pytest.mark.slow
@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize(
    "clearance",
    [
        _clearance(("forearm", 1.0, 1.5)),
        _clearance(("forearm", 0.0, 0.3), ("slide", 0.25, 2.0), ("slide", 2.8, 3.0)),
        _clearance(("wrist", 2.9, 3.0)),
    ],
)
def test_links_are_red_when_they_touch_with_few_pictures(
    tab: tuple[FakeTab, Session],
    clearance: ArmClearance,
    speed: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _, session = tab
    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr(playback, "time", SimpleNamespace(monotonic=lambda: clock.now))
    seldom, often = _panel(session, clearance, speed), _panel(session, clearance, speed)
    period = _DURATION / SPEEDS[speed] + playback._PAUSE_AT_END
    drawn = clearance.touching(seldom.advance(_DURATION))
    often.advance(_DURATION)
    pictures = 1
    while clock.now < _ROUNDS * period:
        clock.now += _STEP
        time = often.advance(_DURATION)
        left = seldom.until_contact(_DURATION)
        assert left is not None
        if left <= 0:
            drawn = clearance.touching(seldom.advance(_DURATION))
            pictures += 1
        assert drawn == clearance.touching(time) or any(
            0 <= time - contact.last <= playback._JUST for contact in clearance.contacts
        )
    assert pictures <= 1 + _ROUNDS * (1 + 2 * len(clearance.contacts))


def test_an_arm_that_touches_nothing_needs_no_picture(tab: tuple[FakeTab, Session]) -> None:
    _, session = tab
    for clearance in (None, _clearance()):
        assert _panel(session, clearance, "real time").until_contact(_DURATION) is None


def test_the_page_goes_to_the_moment_at_which_links_turn_red(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made = Planner(compile=False)(load_scene("paper"))
    contact = Contact("forearm", 0, 1.0, 1.5, 1.2, 0.1)
    assert made.arm_clearance is not None
    clearance = replace(made.arm_clearance, contacts=(contact,))
    shown = frozenset({"arm"})
    first = Frame(replace(made, arm_clearance=clearance), shown=shown, playing=True)
    told: list[tuple[str, float]] = []

    def call(_: object, function: str, *arguments: Any) -> None:
        if function in ("play", "seek"):
            (told_of,) = arguments
            told.append((function, told_of["time"] if function == "play" else told_of))

    monkeypatch.setattr(page, "call", call)
    layer = ArmLayer(MagicMock())
    moments = (0.0, 0.5, 1.1, 1.3, 1.6, 0.0)
    for time in moments:
        layer(replace(first, time=time))
    assert told == [("play", 0.0), ("seek", 1.1), ("seek", 1.6)]
    # another motion begins at its own moment
    other = replace(first.plan, motion=replace(made.motion))  # type: ignore[type-var]
    layer(replace(first, plan=other, time=1.2))
    assert told[3:] == [("play", 1.2)]


def test_the_clock_never_passes_the_end_of_a_motion_that_became_shorter(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    _, session = tab
    panel = _panel(session, None, "real time")
    told: list[tuple[float, float]] = []
    monkeypatch.setattr(
        panel._overlay, "set_clock", lambda time, end, playing, before: told.append((time, end))
    )
    panel.restore(2.78, False)
    for duration in (2.781, 2.75, 2.7499, 2.6, 3.0, 0.0):
        panel.advance(duration)
        time, end = told[-1]
        assert time <= end
        assert panel.slider.value <= end
