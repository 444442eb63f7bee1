"""A tab of the running application for taking pictures: what it shows is chosen here."""

from __future__ import annotations

import io
import math
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

from PIL import Image
from playwright.sync_api import Browser

from abi.scene.scene import Scene
from app.server.server import Server, start
from app.state.appearance import Appearance
from app.tab.session import Session
from tests.browser.page import Page

WIDTH, HEIGHT = 1280, 720
PATIENCE = 600.0
"""Seconds: every pixel is drawn here, on machines without a graphics card, too."""
_EDGES = """() => {
  const {left, right} = window.__viserMutable.canvas.getBoundingClientRect();
  return [left, right];
}"""


class Visit:
    """One tab, drawn and at rest, with the arm standing still."""

    def __init__(self, page: Page, session: Session) -> None:
        self.page, self.session = page, session

    def show(self, *layers: str) -> None:
        """Show these layers and no others, by their names in the Layers tab's table."""
        boxes = self.session.panels.layer_switches.boxes
        unknown = set(layers) - set(boxes)
        assert not unknown, f"no layer {unknown}"
        for name, box in boxes.items():
            box.value = name in layers
        self.follow()

    def search(self, percent: int) -> None:
        """Colour the nodes that the search has looked at by then."""
        slider = self.session.panels.stages.visited
        slider.value = round(percent / 100 * slider.max)
        self.follow()

    def time(self, part: float) -> None:
        """Put the arm where it is after ``part`` (0 to 1) of its motion."""
        plan = self.session.plan
        assert plan is not None
        assert plan.profile is not None
        self.session.playback.slider.value = round(part * plan.profile.duration, 2)
        self.follow()

    def darken(self, dark: bool) -> None:
        """Show the page in dark or light colours."""
        self.session.panels.layer_switches.dark.value = dark
        self.follow()

    def resize(self, width: int, height: int) -> None:
        """Give the page another size, [px], of another height, and wait until all has followed."""
        tab, camera = self.page.tab, self.session.client.camera
        if tab.viewport_size == {"width": width, "height": height}:
            return
        told = camera.image_height
        tab.set_viewport_size({"width": width, "height": height})
        self.page.until(lambda: camera.image_height != told, "the new size", PATIENCE)
        self.follow()

    def look(self, position: tuple[float, float, float], at: tuple[float, float, float]) -> None:
        """Put the camera somewhere, [unit], world."""
        with self.session.client.atomic():
            self.session.client.camera.position = position
            self.session.client.camera.look_at = at

    def hide_overlay(self) -> None:
        """Take away what is written over the scene, which no stage is about."""
        self.page.tab.add_style_tag(content="#abi-overlay { display: none !important }")

    def follow(self) -> None:
        """Let the session see what was changed, and wait until the page shows it."""
        self.session.wake(SimpleNamespace(client=self.session.client))
        self.rest()

    def rest(self) -> None:
        """Wait until the plan is whole and drawn."""
        self.page.until(lambda: self.session.resting, "the plan at rest", PATIENCE)
        self.page.settle(PATIENCE)
        assert "This did not work" not in self.page.text(), "the page tells of a fault: see its log"

    def picture(self, panels: bool = True) -> Image.Image:
        """Picture of the tab, or only of the scene between the panels."""
        image = Image.open(io.BytesIO(self.page.tab.screenshot())).convert("RGB")
        if panels:
            return image
        left, right = self.page.tab.evaluate(_EDGES)
        return image.crop((math.ceil(left), 0, math.floor(right), image.height))


@contextmanager
def visit(
    browser: Browser,
    scene: Scene | str,
    width: int = WIDTH,
    height: int = HEIGHT,
    dark: bool = True,
    ratio: float = 1.0,
) -> Iterator[Visit]:
    """The scene, or the shipped one of that name, in a tab of a server of its own.

    Args:
        browser: to open the tab in.
        scene: to show.
        width: of the page, [px].
        height: of the page, [px].
        dark: whether its colours are dark.
        ratio: pixels of the scene for one of the page.
    """
    server = _server(scene, dark)
    # of two ratios in an address the first counts: every pixel, where tests take few
    page = Page(browser, f"{server.url}/?fixedDpr={ratio}", width, height, draws=True)
    page.tab.set_default_timeout(1000 * PATIENCE)
    try:
        page.until(lambda: len(server.sessions) == 1, "a session")
        (session,) = server.sessions.values()
        visited = Visit(page, session)
        page.until(lambda: session.plan is not None, "a plan", PATIENCE)
        if session.plan is not None and session.plan.motion is not None:
            page.click("Pause")
        # now, instead of when the hand has rested for a while
        session.client.scene.configure_default_lights()
        session.client.scene.configure_environment_map()
        visited.rest()
        yield visited
    finally:
        page.close()
        server.stop()


def _server(scene: Scene | str, dark: bool) -> Server:
    look = Appearance(plain=True, dark=dark)
    if isinstance(scene, str):
        return start(port=0, scene=scene, look=look)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.json"
        scene.save(file)
        return start(port=0, scene=str(file), look=look)
