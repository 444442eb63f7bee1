from __future__ import annotations

import os
import shutil
from collections.abc import Generator, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, sync_playwright

import abi
from abi.scene.scene import load_scene
from app.server.server import Server, start
from app.state.appearance import PLAIN
from app.state.legend import SWITCHES
from app.tab.session import Session
from app.ui.page import uuid
from tests.browser import drawn
from tests.browser.page import FLAGS, Page

PAPER = load_scene("paper")

_HERE = Path(__file__).parent
_FLAGS = (*FLAGS, "--js-flags=--no-turbofan")
"""A page is closed again before what an optimising compiler costs has paid: a fifth of all."""
_PASSED = pytest.StashKey[bool]()
_NAMES = ("chromium", "chromium-browser", "google-chrome")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    paths = {path for path in {item.path for item in items} if _HERE in path.parents}
    for item in items:
        if item.path in paths:
            item.add_marker(pytest.mark.browser)
            # beside all the others a software renderer may be slower than any patience
            item.add_marker(pytest.mark.flaky(reruns=2))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    if report.when == "call":
        item.stash[_PASSED] = report.passed
    return report


def _executable() -> str:
    named = os.environ.get("CHROMIUM")
    for name in (named,) if named else _NAMES:
        if found := shutil.which(name):
            return found
    pytest.fail(
        f"No Chromium: looked for {named or ', '.join(_NAMES)}. Install chromium or set CHROMIUM "
        "to its path; 'make test' does the first, 'make check' leaves the browser out.",
        pytrace=False,
    )


@pytest.fixture(scope="session")
def chromium() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=_executable(), args=list(_FLAGS))
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def server() -> Iterator[Server]:
    # until it is, plans are slow and tell no times
    abi.compile()
    server = start(port=0, scene="paper", look=PLAIN)
    yield server
    server.stop()


class Tabs:
    """Opens tabs, ``tabs()`` or ``tabs("?pitch=0.5")``, whose sessions are in the server's."""

    def __init__(self, chromium: Browser, server: Server) -> None:
        self._chromium, self._server = chromium, server
        self._opened: list[Page] = []
        self._kept: Page | None = None

    def __call__(self, query: str = "") -> Page:
        known = set(self._server.sessions)
        page = Page(self._chromium, self._server.url.rstrip("/") + "/" + query)
        self._opened.append(page)
        self._begin(page, known)
        return page

    def reload(self, page: Page) -> None:
        """Reload a tab, which is then another client."""
        known = set(self._server.sessions)
        page.reload()
        self._begin(page, known)

    def leave_and_come_back(self, page: Page) -> None:
        """Open another page in a tab and press "back"; it is then another client."""
        known = set(self._server.sessions)
        page.leave_and_come_back()
        self._begin(page, known)

    def kept(self) -> Page:
        """The tab that was put back last, with what was planned as at first, or a new one."""
        page, self._kept = self._kept or self(), None
        session = self._server.sessions[page.client]
        if not page.is_open("Result"):
            page.click("Result")
        if session.playback.playing:
            page.click("Pause")
        if session.plan is None or session.plan.scene != PAPER:
            files = session.panels.files
            if files.choice.value == "paper":  # to press it would take the page ten times as long
                button, pressed = uuid(files.reset), {"value": True}
                page.send({"type": "GuiUpdateMessage", "uuid": button, "updates": pressed})
            else:
                page.click("Scene")
                page.choose("scene", "paper")
            page.until(lambda: session.plan.scene == PAPER, "the scene as loaded")  # type: ignore[union-attr]
            if not page.is_open("Result"):
                page.click("Result")
        page.close_notices()
        page.until(lambda: page.complaints() == [], "no complaint")
        page.until(lambda: drawn.shows(page, session.plan), "the first picture")
        page.settle()
        return page

    def put_back(self, page: Page, *, passed: bool) -> None:
        """Keep a tab for the next test unless it met an error or its switches are not as before.

        A test that did not pass may have left it in any state, with any size.
        """
        session = self._server.sessions[page.client]
        if passed and not page.errors and _is_as_opened(session):
            viewpoint = session._view.viewpoint
            if viewpoint._is_moved():  # to open another tab takes a hundred times as long
                viewpoint.show(PAPER)
                viewpoint.face(abi.plan(PAPER))
            self._kept = page
            return
        self._opened.remove(page)
        page.close()
        assert not page.errors, "\n".join(page.errors)

    def close(self) -> None:
        """Close the tabs and fail when one of them met an error."""
        for page in self._opened:
            page.close()
        errors = [error for page in self._opened for error in page.errors]
        assert not errors, "\n".join(errors)

    def _begin(self, page: Page, known: set[int]) -> None:
        sessions = self._server.sessions
        page.until(lambda: bool(set(sessions) - known), "a session for the new tab")
        (page.client,) = set(sessions) - known
        page.until(lambda: sessions[page.client].plan is not None, "the first plan")
        page.settle()


def _is_as_opened(session: Session) -> bool:
    """Check whether all that "Reset scene" leaves alone, but for the camera, is as in a new tab."""
    return (
        session.panels.layer_switches.shown() == {switch.name for switch in SWITCHES if switch.on}
        and not session.panels.layer_switches.dark.value
        and session.panels.stages.visited_nodes() == 0
        and not session.panels.theatre.on.value
        and session.playback.speed.value == "real time"
    )


@pytest.fixture
def tabs(chromium: Browser, server: Server) -> Iterator[Tabs]:
    """Opens tabs for one test."""
    tabs = Tabs(chromium, server)
    yield tabs
    tabs.close()


@pytest.fixture(scope="session")
def shared(chromium: Browser, server: Server) -> Iterator[Tabs]:
    """The tab that one test after the other uses."""
    shared = Tabs(chromium, server)
    yield shared
    shared.close()


@pytest.fixture
def page(shared: Tabs, request: pytest.FixtureRequest) -> Iterator[Page]:
    """A tab with the paper's scene, at rest, its right panel showing the result."""
    page = shared.kept()
    request.node.stash[_PASSED] = False
    yield page
    shared.put_back(page, passed=request.node.stash[_PASSED])


@pytest.fixture
def session(page: Page, server: Server) -> Session:
    """The session of ``page``."""
    return server.sessions[page.client]
