"""Tabs are apart from each other, from their own past, and from what hostile ones send."""

from __future__ import annotations

import math
import threading
from typing import Any

import pytest

import abi
from app.server.server import Server
from tests.app.fake_tab import FakeTab
from tests.browser import drawn
from tests.browser.conftest import Tabs
from tests.browser.page import Page

NAN = math.nan


def _threads(client: int) -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name == f"tab-{client}"]


def test_two_tabs_share_nothing_and_a_reload_ends_the_old_session(
    page: Page, tabs: Tabs, server: Server
) -> None:
    first, second = tabs(), page
    first.click("Pause")
    mine, other = server.sessions[first.client], server.sessions[second.client]
    kept = other.plan
    first.set_number("degree", 2)
    first.click("Layers")
    first.tick("arm", False)
    first.drag_arrow("/goal", 1, -1.5)
    first.until(
        lambda: mine.plan.scene.goal[1] < 5 and mine.plan.scene.spline.degree == 2,  # type: ignore[union-attr]
        "the plan of the first tab",
    )
    first.until(lambda: drawn.shows(first, mine.plan), "its picture")
    first.until(lambda: "/arm" not in first.shown(), "its arm to go")

    second.settle()
    assert other.plan is kept
    assert drawn.shows(second, abi.plan(abi.load_scene("paper")))
    assert second.position("/goal") == pytest.approx((6, 6, 6), abs=1e-9)
    assert "/arm" in second.shown()
    assert second.row("degree").locator("input:visible").input_value() == "4"

    old = first.client
    tabs.reload(first)
    assert first.client != old
    first.until(lambda: old not in server.sessions and not _threads(old), "the old session's end")
    fresh = server.sessions[first.client]
    assert len(_threads(first.client)) == 1
    first.set_number("degree", 3)
    first.until(lambda: fresh.plan.scene.spline.degree == 3, "the new session to work")  # type: ignore[union-attr]
    assert other.plan is kept


@pytest.mark.filterwarnings("ignore:Queued a .* on a closed connection")
def test_hostile_values_break_neither_their_tab_nor_another(page: Page, server: Server) -> None:
    mine = server.sessions[page.client]
    good = mine.plan
    known = set(server.sessions)
    fake = FakeTab(server.url)
    page.until(lambda: bool(set(server.sessions) - known), "the hostile tab's session")
    (number,) = set(server.sessions) - known
    hostile = server.sessions[number]
    page.until(lambda: hostile.plan is not None, "its plan")
    for handle in (
        hostile.panels.stages.fields["mesh.pitch"],
        hostile.panels.stages.fields["motion.speed"],
        hostile.playback.slider,
    ):
        for value in (NAN, math.inf, -1e308, "junk", None, [NAN]):
            fake.set(handle, value)
    fake.drag(hostile.panels.obstacles.gizmos[0], [NAN, NAN, NAN])
    fake.drag(hostile.panels.ends.gizmos["goal"], [1e308, NAN, 0.0])
    fake.close()
    page.until(lambda: number not in server.sessions and not _threads(number), "its end")
    assert mine.plan is good
    assert page.complaints() == []

    # The same through the page's own connection.
    def say(handle: Any, value: object) -> None:
        uuid = handle._impl.uuid
        page.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}})

    say(mine.panels.stages.fields["motion.speed"], NAN)
    page.reads("it is nan")
    shown = mine.playback.slider.value
    say(mine.playback.slider, NAN)
    say(mine.panels.stages.fields["motion.speed"], math.inf)
    page.reads("it is inf")
    page.until(lambda: mine.playback.slider.value == shown, "the good time again")
    assert mine.plan is good
    assert drawn.shows(page, good)

    (gizmo,) = drawn.obstacles(page)
    place = {
        "type": "TransformControlsUpdateMessage",
        "name": gizmo,
        "owner": mine.panels.obstacles.gizmos[0]._impl.api._owner_id,
        "wxyz": [1.0, 0.0, 0.0, 0.0],
    }
    say(mine.panels.stages.fields["motion.speed"], 4.0)
    page.send({**place, "position": [NAN, 3.0, 3.0]})
    page.reads("position of obstacle 1")
    assert mine.plan is good
    page.send({**place, "position": [3.0, 3.0, 2.5]})
    page.until(lambda: page.complaints() == [], "no complaint")
    page.until(lambda: mine.plan.scene.obstacles[0].position == (3.0, 3.0, 2.5), "a plan")  # type: ignore[union-attr]

    # And by hand, everything works as before.
    page.until(lambda: drawn.shows(page, mine.plan), "its picture")
    page.settle()
    page.scrub(0.5)
    assert good is not None
    assert good.profile is not None
    half = good.profile.duration / 2
    page.until(lambda: abs(mine.playback.slider.value - half) < 0.1, "the time")
    page.set_number("degree", 3)
    page.until(lambda: mine.plan.scene.spline.degree == 3, "a plan")  # type: ignore[union-attr]
    page.until(lambda: drawn.shows(page, mine.plan), "its picture")
    assert len(_threads(page.client)) == 1
