"""The search for a base as a person uses it: found, looked at, taken, undone."""

from __future__ import annotations

import re

import abi
from app.tab.session import Session
from tests.browser.page import Page


def test_the_arm_is_put_where_the_way_is_shortest(page: Page, session: Session) -> None:
    page.click("Scene")
    page.choose("scene", "find-a-base")
    scene = abi.load_scene("find-a-base")
    page.until(lambda: session.frame.plan.scene == scene, "the scene")
    page.reads("the upper arm touches obstacle 1 at the start")
    page.reads("“Find a base” tries many other places for the arm's base.")
    assert "/bases/tiles" not in page.names()
    page.click("Find a base")
    page.reads("Trying other places")
    page.tab.get_by_role("button", name="Stop", exact=True).wait_for()
    page.until(lambda: "/base_region/box" in page.shown(), "the region")
    page.until(lambda: "/bases/tiles" in page.shown(), "the heat map")
    page.reads("Put the arm there")
    page.until(lambda: session.frame.bases is not None and session.frame.bases.is_done, "its end")
    found = session.frame.bases
    assert found is not None
    assert found.best is not None
    page.tab.get_by_text("6 · Arm").first.click()
    folder = page.tab.get_by_text("Find a base", exact=True)
    folder.and_(page.tab.locator(":not(#abi-overlay *)")).first.click()
    page.reads("Put the arm here")
    page.reads(f"of {len(found.trials)} places have a certified plan")
    counts = re.findall(r"(\d+) × ", page.text())
    assert sum(map(int, counts)) == sum(list(found.faults.values())[:4])

    page.click("Put the arm there")
    page.until(lambda: session.frame.plan.error is None, "a plan")
    page.reads("proven clear ✓")
    assert page.complaints() == []
    assert session.frame.plan.scene.arm.base == found.best.base
    assert "/bases/best" in page.shown()
    page.click("Undo")
    page.until(lambda: session.frame.plan.scene == scene, "the base as it was")
    assert not page.errors
