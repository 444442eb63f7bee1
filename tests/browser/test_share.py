"""Sharing what is on the screen; and a plot that is clicked."""

from __future__ import annotations

from app.server.server import Server
from app.tab.session import Session
from tests.browser.conftest import Tabs
from tests.browser.page import Page
from tests.browser.texts import texts


def test_a_challenge_link_opens_elsewhere(
    page: Page, session: Session, tabs: Tabs, server: Server
) -> None:
    # a browser without a window has no clipboard that can be relied on
    page.tab.evaluate("navigator.clipboard.writeText = text => { window.copied = text; }")
    page.set_number("spacing [cm]", 1.1)
    page.until(lambda: session.frame.plan.scene.mesh.pitch == 1.1 and session.resting, "the plan")
    page.click("Scene")
    page.choose("challenge", "keep the quadratic clear")
    page.click("Copy challenge link")
    page.until(lambda: "state=" in page.tab.evaluate("window.copied ?? ''"), "the link")
    page.reads("The link is ready")
    contrasts = [text.contrast for text in texts(page) if text.text.startswith("Paste it where")]
    assert contrasts
    assert min(contrasts) >= 4.5  # WCAG 2.1, 1.4.3
    link = str(page.tab.evaluate("window.copied"))

    other = tabs("?" + link[link.index("state=") :])
    opened = server.sessions[other.client]
    other.reads("keep the quadratic clear of all obstacles")
    assert opened.plan is not None
    assert opened.plan.scene == session.frame.plan.scene
    assert session.plan is not None
    assert opened.plan.path is not None
    assert session.plan.path is not None
    assert opened.plan.path.length == session.plan.path.length

    # a click into the middle of a plot over time goes there
    other.click("Result")
    over = other.tab.locator(".u-over").first
    over.click()
    duration = opened.frame.duration
    other.until(
        lambda: not opened.playback.playing and abs(opened.frame.time - duration / 2) < 0.1,
        "the time that was clicked",
    )
