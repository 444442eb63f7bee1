"""The page under the guard's rules: the token's way in, and no script but its own."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser

from app.guard.policy import policy_for
from app.server.server import Server, start
from app.state.appearance import PLAIN
from tests.browser.page import Page


@pytest.fixture
def locked() -> Iterator[Server]:
    running = start(
        port=0, scene="paper", policy=policy_for("127.0.0.1", "open sesame"), look=PLAIN
    )
    yield running
    running.stop()


def test_the_link_shows_the_page_and_what_is_slipped_into_it_does_not_run(
    chromium: Browser, locked: Server
) -> None:
    visitor = chromium.new_context().new_page()
    visitor.goto(locked.url)
    assert "The link is not complete" in visitor.inner_text("body")
    visitor.context.close()

    page = Page(chromium, locked.link)
    page.until(lambda: bool(locked.sessions), "a session")
    (session,) = locked.sessions.values()
    page.until(lambda: session.plan is not None, "a plan")
    assert "token" not in page.tab.url
    assert page.tab.evaluate("document.cookie") == ""
    assert page.errors == []

    slipped = "window.slipped = true"
    session.client.gui.add_html(
        f'<img src="data:," onerror="{slipped}"><details open ontoggle="{slipped}">x</details>'
        f'<iframe srcdoc="<script>parent.{slipped}</script>"></iframe>'
        '<img src="https://elsewhere.example/beacon.png">'
    )
    page.until(lambda: len(page.errors) >= 4, "four refusals")
    assert all("Content Security Policy" in error for error in page.errors)
    assert page.tab.evaluate("window.slipped") is None
    page.close()
