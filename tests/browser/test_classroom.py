"""The page of a class's teacher."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser

from app.server.server import Server, start
from app.state.appearance import PLAIN
from app.teach.classroom import Classroom
from tests.browser.page import Page


@pytest.fixture
def room() -> Iterator[tuple[Server, Classroom]]:
    classroom = Classroom()
    running = start(port=0, scene="paper", classroom=classroom, look=PLAIN)
    yield running, classroom
    running.stop()


def _teaches(server: Server) -> bool:
    panels = (one._view.classroom for one in server.sessions.values())
    return any(panel is not None and panel.teaches for panel in panels)


def test_neither_address_nor_copied_link_has_the_teachers_secret(
    chromium: Browser, room: tuple[Server, Classroom]
) -> None:
    server, classroom = room
    page = Page(chromium, f"{server.url}/?teach={classroom.secret}&demo=0")
    page.until(lambda: _teaches(server), "a teacher")
    # the class sees the address on the projector
    page.until(lambda: classroom.secret not in page.tab.url, "an address without the secret")
    assert "demo=0" in page.tab.url

    # a browser without a window has no clipboard that can be relied on
    page.tab.evaluate("navigator.clipboard.writeText = text => { window.copied = text; }")
    page.click("Scene")
    page.click("Copy link")
    page.until(lambda: "state=" in page.tab.evaluate("window.copied ?? ''"), "the link")
    assert "teach" not in page.tab.evaluate("window.copied")

    page.tab.reload()
    page.until(lambda: len(server.sessions) == 1 and _teaches(server), "the same teacher again")
    assert page.errors == []
    page.close()

    student = Page(chromium, server.url)
    student.until(lambda: len(server.sessions) == 1 and not _teaches(server), "a student alone")
    (session,) = server.sessions.values()
    student.until(lambda: session.plan is not None, "a plan")
    assert not _teaches(server)
    student.close()
