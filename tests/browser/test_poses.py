"""The page's own poses of links, obstacles and ends are those of the plan."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser

from app.server.server import Server, start
from app.state.appearance import PLAIN
from benchmarks.poses import Step, Walker, misplaced, walk
from tests.browser.page import Page
from tests.thorough import of_each_kind

_KITCHEN = ("scene", "kitchen-ur5e")
_ORDERS: dict[str, list[Step]] = {
    "another unit": [_KITCHEN, ("play", ""), ("scene", "paper"), ("play", ""), ("arm", "UR5e")],
    "another arm, and back": [("arm", "Franka Panda"), ("arm", "UR5e"), ("button", "undo")],
    "under way": [_KITCHEN, ("play", ""), ("arm", "xArm7"), ("play", ""), ("arm", "UR5e")],
    "again": [("scene", "paper"), ("arm", "UR5e"), _KITCHEN, ("reload", ""), ("arm", "UR5e")],
}


@pytest.fixture(scope="module")
def walker(chromium: Browser, server: Server) -> Iterator[Walker]:
    """A tab for all orders, of a server of its own, so that it can tell its sessions apart."""
    own = start(port=0, scene="paper", look=PLAIN)  # after the shared one, which has all compiled
    page = Page(chromium, own.url)
    yield Walker(page, own)
    page.close()
    own.stop()


@pytest.mark.slow
@pytest.mark.parametrize("order", of_each_kind(_ORDERS, "another unit"))
def test_the_arm_stands_where_it_is_planned(walker: Walker, order: str) -> None:
    assert not misplaced(walker.page, walker.session)
    assert not walk(walker, _ORDERS[order])
    assert not walker.page.errors
