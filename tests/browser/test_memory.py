"""A tab's picture comes back after a reload, "back", a new server, and by a link."""

from __future__ import annotations

import numpy as np
import pytest
from playwright.sync_api import Browser

import abi
from app.server.server import Server, start
from app.state.appearance import PLAIN
from app.tab.session import Session
from tests.abi import meshes
from tests.browser import drawn
from tests.browser.conftest import Tabs
from tests.browser.page import Page
from tests.thorough import THOROUGH, of_each_kind

_STORED = "sessionStorage.getItem('abi-tab')"


def _edit(page: Page, session: Session, degree: int) -> abi.Scene:
    """Change the scene, the layers, the camera and the time; the scene as it is then."""
    page.click("Layers")
    page.tick("arm", False)
    page.click("Result")
    page.set_number("degree", degree)
    page.drag((800.0, 560.0), (750.0, 540.0))
    page.until(lambda: session.plan.scene.spline.degree == degree, "the degree")  # type: ignore[union-attr]
    page.click("Pause")
    page.set_time(1.5)
    page.until(lambda: session.frame.time == pytest.approx(1.5), "the time")
    _is_kept(page, session)
    assert session.plan is not None
    return session.plan.scene


def _is_kept(page: Page, session: Session) -> None:
    page.until(
        lambda: page.tab.evaluate(_STORED) == session.state().encode(), "the page to remember"
    )


def _is_back(page: Page, session: Session, scene: abi.Scene, camera: drawn.Points) -> None:
    page.until(lambda: session.plan is not None and session.plan.scene == scene, "the scene")
    page.until(lambda: drawn.shows(page, session.plan), "its picture")
    page.until(lambda: "/arm" not in page.shown(), "no arm")
    assert session.frame.time == pytest.approx(1.5)
    assert not session.playback.playing
    page.until(lambda: np.allclose(session.client.camera.position, camera, rtol=1e-4), "its camera")


def test_what_cannot_be_brought_back_is_told(tabs: Tabs, server: Server) -> None:
    page = tabs("?state=nonsense")
    page.reads("The link cannot be opened")
    session = server.sessions[page.client]
    assert session.plan is not None
    assert session.plan.scene == abi.load_scene("paper")

    page.click("Pause")  # what goes on is remembered anew all the time
    page.until(lambda: session.resting, "rest")
    _is_kept(page, session)
    page.tab.evaluate("sessionStorage.setItem('abi-tab', 'x'.repeat(abi.LONGEST + 1))")
    student = page.tab.evaluate("localStorage.getItem('abi-student')")
    assert len(student) >= 16
    tabs.reload(page)
    page.tab.get_by_text("Not brought back").wait_for()
    assert page.tab.evaluate("localStorage.getItem('abi-student')") == student
    assert server.sessions[page.client]._fault is None


def test_reload_and_back_and_a_link_bring_everything_back(tabs: Tabs, server: Server) -> None:
    page = tabs()
    session = server.sessions[page.client]
    scene = _edit(page, session, 2)
    camera = np.array(session.client.camera.position)
    ways = {"reload": tabs.reload, "back": tabs.leave_and_come_back}
    for way in of_each_kind(ways, "back"):  # other tests reload
        again = ways[way]
        again(page)
        session = server.sessions[page.client]
        _is_back(page, session, scene, camera)

    # by a link, in a tab of its own; what is changed after that is not the link's any more
    other = tabs(f"?state={session.state().encode()}")
    session = server.sessions[other.client]
    _is_back(other, session, scene, camera)
    assert "state" not in other.tab.url
    other.set_number("degree", 5)
    other.until(lambda: session.plan.scene.spline.degree == 5, "another degree")  # type: ignore[union-attr]
    other.click("Scene")
    vertices, faces = meshes.bumpy(2)
    other.upload("Add a mesh (STL, OBJ, GLB …)", "bumpy.stl", meshes.stl((0.6 * vertices, faces)))
    other.until(lambda: len(session.plan.scene.obstacles) == 2, "the mesh")  # type: ignore[union-attr]
    other.until(lambda: session.resting, "the plan at rest")
    _is_kept(other, session)
    assert session.plan is not None
    scene = session.plan.scene
    assert scene.spline.degree == 5
    tabs.reload(other)
    session = server.sessions[other.client]
    other.until(lambda: session.plan.scene == scene, "the scene with its mesh")  # type: ignore[union-attr]
    other.until(lambda: len(drawn.obstacles(other)) == 2, "both obstacles")


@pytest.mark.skipif(not THOROUGH, reason="test_restarts has a server killed and started again")
def test_another_server_at_the_same_address_shows_the_same(chromium: Browser) -> None:
    server = start(port=0, scene="paper", look=PLAIN)
    page = Page(chromium, server.url + "/")
    try:
        page.until(lambda: bool(server.sessions), "a session")
        (session,) = server.sessions.values()
        page.until(lambda: session.plan is not None, "the first plan")
        scene = _edit(page, session, 3)
        camera = np.array(session.client.camera.position)
        port = server.viser.get_port()
        server.stop()
        server = start(port=port, scene="paper", look=PLAIN)
        page.until(lambda: bool(server.sessions), "the page to connect again")
        (session,) = server.sessions.values()
        _is_back(page, session, scene, camera)
    finally:
        page.close()
        server.stop()
