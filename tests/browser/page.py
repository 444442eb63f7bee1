"""The page of a viser 1.1.1 server, used as a person would, and its contents.

viser draws only when asked and exposes its scene on ``window``; both are used here to wait for what
is on screen instead of for a number of seconds.
"""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from playwright.sync_api import Browser, ConsoleMessage, FilePayload, Locator
from playwright.sync_api import Page as Tab

Point: TypeAlias = tuple[float, float]

FLAGS = (
    # WebGL without a graphics card ...
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    # ... for the scene alone: the panels are drawn sooner without it ...
    "--disable-gpu-compositing",
    "--disable-gpu-rasterization",
    # Each window would load a page for what is typed into the address, a sixth of opening a tab; as
    # the last such flag is the one that counts, with those of Playwright's that matter here.
    "--disable-features=WebUIOmniboxPopup,WebUIOmniboxAimPopup,DestroyProfileOnBrowserClose,"
    "HttpsUpgrades,HttpsFirstBalancedModeAutoEnable,MediaRouter,PaintHolding,"
    "ThirdPartyStoragePartitioning,OptimizationHints,NetworkTimeServiceQuerying,AimEnabled,"
    "PreconnectToSearch",
    # ... and not a word to the network.
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-quic",
    "--disable-sync",
    "--no-first-run",
)
PATIENCE = 60.0  # [s]; the first frames in software GL compile shaders for seconds
_FIRST_PAUSE, _LONGEST_PAUSE = 20.0, 150.0  # [ms] between two looks
_CLICKS = 12
# Pixels of the scene for one of the page: few, since each takes time. Fixed, since viser otherwise
# resizes the canvas when drawing is slow.
_RATIO = 0.05

# In software a picture takes as long as ten steps of a test, and few look at it: the page does
# all that it does for one but the last step, the graphics card's. ``window.draws`` has that done.
# A canvas that is not even cleared is not put on the screen again, either.
_UNDRAWN = """for (const name of ["clear", "drawArrays", "drawElements", "drawRangeElements",
    "drawArraysInstanced", "drawElementsInstanced"]) {
  const draw = WebGL2RenderingContext.prototype[name];
  WebGL2RenderingContext.prototype[name] = function (...numbers) {
    if (window.draws) draw.apply(this, numbers);
  };
}"""

_READY = """() => {
  const viser = window.__viserMutable;
  return !!(viser && viser.camera && viser.canvas && window.__viserTestpoints?.rendererInfo);
}"""

# Resolves to "" when nothing is left to draw: no message waits, and three new frames in a row had
# the same content, however much an arm that plays moves in them and lengthens its trace. Otherwise,
# when time is up, to what was seen last.
_SETTLE = """async milliseconds => {
  const viser = window.__viserMutable, gl = window.__viserTestpoints.rendererInfo;
  const end = performance.now() + milliseconds;
  let frame = gl.render.frame, before = "no frame", equal = 0;
  while (performance.now() < end) {
    viser.requestRender();
    await new Promise(wake => setTimeout(wake, 10));
    if (gl.render.frame === frame) continue;
    frame = gl.render.frame;
    const waiting = viser.messageQueue.length;
    const now = JSON.stringify({textures: gl.memory.textures, calls: gl.render.calls,
      nodes: Object.keys(viser.nodeRefFromName).length, waiting});
    equal = now === before && waiting === 0 ? equal + 1 : 0;
    before = now;
    if (equal === 2) return "";
  }
  return before;
}"""

_FRAMES = """async count => {
  const viser = window.__viserMutable, gl = window.__viserTestpoints.rendererInfo;
  for (const last = gl.render.frame + count; gl.render.frame < last;) {
    viser.requestRender();
    await new Promise(requestAnimationFrame);
  }
}"""

# The scene as it is drawn for once: what WebGL complains of (0: nothing), and grey for each pixel,
# as the code of a letter.
_PICTURE = """async () => {
  const viser = window.__viserMutable, {render} = window.__viserTestpoints.rendererInfo;
  const gl = viser.canvas.getContext("webgl2");
  const [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
  const pixels = new Uint8Array(4 * width * height);
  window.draws = true;
  for (let drawn = 0, frame = render.frame; drawn < 3; frame = render.frame) {
    viser.requestRender();
    await new Promise(requestAnimationFrame);
    if (render.frame === frame) continue;
    drawn++;
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  }
  window.draws = false;
  const greys = Array.from({length: width * height}, (_, k) =>
    String.fromCharCode(pixels[4 * k] + pixels[4 * k + 1] + pixels[4 * k + 2]));
  return [gl.getError(), greys.join("")];
}"""

_PIXEL = """([name, point]) => {
  const {camera, canvas, nodeRefFromName} = window.__viserMutable;
  const node = nodeRefFromName[name];
  if (!node) return null;
  node.updateWorldMatrix(true, false);
  camera.updateMatrixWorld();
  const seen = node.position.clone().set(...point).applyMatrix4(node.matrixWorld).project(camera);
  const box = canvas.getBoundingClientRect();
  return [box.left + box.width * (1 + seen.x) / 2, box.top + box.height * (1 - seen.y) / 2];
}"""

_FREE = "([x, y]) => document.elementFromPoint(x, y) === window.__viserMutable.canvas"

_CLOSE_NOTICES = """() => {
  for (const notice of document.querySelectorAll(".mantine-Notification-root"))
    notice.querySelector("button")?.click();
}"""

_COVER = "([x, y]) => document.elementFromPoint(x, y)?.outerHTML.slice(0, 300)"

_PROPS = """name => {
  const node = window.__viserSceneTree.getState()[name];
  const plain = (key, value) => ArrayBuffer.isView(value) ? Array.from(value) : value;
  return node ? JSON.parse(JSON.stringify(node.message.props, plain)) : null;
}"""

# Pairs of whether a node is seen, by the page's own account, and as it is drawn.
_SEEN = """() => {
  const state = window.__viserSceneTree.getState(), nodes = window.__viserMutable.nodeRefFromName;
  const drawn = node => !node || (node.visible && drawn(node.parent));
  return Object.entries(state).filter(([name]) => name && nodes[name])
    .map(([name, {effectiveVisibility}]) => [name, effectiveVisibility, drawn(nodes[name])]);
}"""

_INK = """name => {
  let length = 0;
  window.__viserMutable.nodeRefFromName[name]?.traverse(part => {
    if (!part.isLineSegments) return;
    const {index, attributes: {position: {array}}} = part.geometry;
    for (let k = 0; k < index.count; k += 2) {
      const [from, to] = [3 * index.array[k], 3 * index.array[k + 1]];
      length += Math.hypot(...[0, 1, 2].map(axis => array[to + axis] - array[from + axis]));
    }
  });
  return length;
}"""

_TRIANGLES = """name => {
  let corners = 0;
  window.__viserMutable.nodeRefFromName[name]?.traverse(part => {
    if (part.isMesh) corners = Math.max(corners, part.geometry.index?.count ?? 0);
  });
  return corners / 3;
}"""

_IS_OPEN = """name => [...document.querySelectorAll("[role=tab][aria-selected=true]")]
  .some(tab => tab.textContent.trim() === name && tab.checkVisibility())"""

_TYPE = "name => window.__viserSceneTree.getState()[name].message.type"

_SEND = "message => window.__viserMutable.sendMessage(message)"

_PLAYER = "#abi-overlay input[type=range]"

_POSITION = """name => {
  const nodes = window.__viserMutable.nodeRefFromName;
  if (!nodes[name]) return null;
  const [world, node] = [nodes[""], nodes[name]];
  world.updateWorldMatrix(true, false);
  node.updateWorldMatrix(true, false);
  const origin = node.position.clone().set(0, 0, 0).applyMatrix4(node.matrixWorld);
  return world.worldToLocal(origin).toArray();
}"""

# Pose of every node in the world, as a matrix, column by column.
_POSES = """() => {
  const nodes = window.__viserMutable.nodeRefFromName, world = nodes[""];
  world.updateWorldMatrix(true, true);
  const inverse = world.matrixWorld.clone().invert();
  return Object.entries(nodes).filter(([name, node]) => name && node)
    .map(([name, node]) => [name, inverse.clone().multiply(node.matrixWorld).toArray()]);
}"""


class Page:
    """One tab with its own storage, 1280x720 unless told otherwise, connected when built.

    ``errors`` collects what the page threw or logged as an error; ``client`` is the id under which
    the server knows the tab, for whoever opened it to set; ``connections`` counts how often it has
    connected.

    Unless it ``draws``, its pictures of the scene stay empty but for :meth:`picture`.
    """

    def __init__(
        self, browser: Browser, url: str, width: int = 1280, height: int = 720, draws: bool = False
    ) -> None:
        self.errors: list[str] = []
        self.client = -1
        self.connections = 0
        self._connected = False
        context = browser.new_context(viewport={"width": width, "height": height})
        if not draws:
            context.add_init_script(_UNDRAWN)
        self.tab: Tab = context.new_page()
        self.tab.set_default_timeout(1000 * PATIENCE)
        # what folds and fades does so at once
        animations = context.new_cdp_session(self.tab)
        animations.send("Animation.enable")
        animations.send("Animation.setPlaybackRate", {"playbackRate": 50})
        self.tab.on("console", self._hear)
        self.tab.on("pageerror", lambda error: self.errors.append(str(error)))
        demo = "" if "demo=" in url else "&demo=0"
        self.tab.goto(url + ("&" if "?" in url else "?") + f"fixedDpr={_RATIO}{demo}")
        self._connect()

    def reload(self) -> None:
        """Load the page anew, as a person would; ``client`` is then out of date."""
        self._connected = False
        self.tab.reload()
        self._connect()

    def leave_and_come_back(self) -> None:
        """Open another page and press "back"; ``client`` is then out of date."""
        self.tab.goto("about:blank")
        self._connected = False
        self.tab.go_back()
        self._connect()

    def _connect(self) -> None:
        self.tab.wait_for_function(_READY)
        self.until(lambda: self._connected, "the page to connect")

    def _hear(self, message: ConsoleMessage) -> None:
        if message.text.startswith("Connected!"):
            self._connected = True
            self.connections += 1
        # the gizmo's library logs this on every press, without effect
        if message.type == "error" and "preventDefault inside passive" not in message.text:
            self.errors.append(message.text)

    def close(self) -> None:
        """Close the tab, as a person would."""
        self.tab.context.close()

    # Waiting

    def until(self, condition: Callable[[], bool], what: str, seconds: float = PATIENCE) -> None:
        """Keep the page running until ``condition()``; fail naming ``what`` after ``seconds``."""
        end, pause = time.monotonic() + seconds, _FIRST_PAUSE
        while not condition():
            assert time.monotonic() < end, f"waited {seconds:g} s for {what}"
            self.tab.wait_for_timeout(pause)
            pause = min(1.25 * pause, _LONGEST_PAUSE)  # to ask takes time from what is waited for

    def node(self, name: str) -> None:
        """Wait until the scene has the node."""
        self.until(lambda: self.tab.evaluate(_POSITION, name) is not None, f"node {name}")

    def settle(self, seconds: float = PATIENCE) -> None:
        """Wait until all that has arrived is on screen; closes the notice about software WebGL."""
        seen = self.tab.evaluate(_SETTLE, 1000 * seconds)
        assert seen == "", f"the page still changes: {seen}"
        notice = self.tab.locator("#webgl-software-rendering")
        if notice.is_visible():
            notice.get_by_role("button").click()
            notice.wait_for(state="detached")

    # The scene

    def props(self, name: str) -> dict[str, Any]:
        """Properties of a node as the browser has them; arrays are flat lists."""
        props = self.tab.evaluate(_PROPS, name)
        assert props is not None, f"no node {name}"
        return dict(props)

    def points(self, name: str) -> NDArray[np.float64]:
        """The points of a line set, (n, 2, 3), or of a point cloud, (n, 3), [unit]."""
        flat = np.array(self.props(name)["points"], dtype=float)
        lines = self.tab.evaluate(_TYPE, name) == "LineSegmentsMessage"
        return flat.reshape(-1, 2, 3) if lines else flat.reshape(-1, 3)

    def triangles(self, name: str) -> int:
        """Number of triangles of a node's mesh."""
        return int(self.tab.evaluate(_TRIANGLES, name))

    def ink(self, name: str) -> float:
        """Length of all lines that the meshes under a node draw, [unit]."""
        return float(self.tab.evaluate(_INK, name))

    def names(self) -> set[str]:
        """Every node of the scene that exists, except viser's own axes, which are off."""
        return {name for name, _, _ in self.tab.evaluate(_SEEN)} - {"/WorldAxes"}

    def shown(self) -> set[str]:
        """Every node of the scene that can be seen, by the page's account and as drawn."""
        return {name for name, visible, drawn in self.tab.evaluate(_SEEN) if visible and drawn}

    def position(self, name: str) -> tuple[float, float, float]:
        """Position of a node in the world, [unit]; a dragged gizmo's as the hand left it."""
        position = self.tab.evaluate(_POSITION, name)
        assert position is not None, f"no node {name}"
        x, y, z = position
        return (x, y, z)

    def poses(self) -> dict[str, NDArray[np.float64]]:
        """Pose of every node in the world, (4, 4), [unit]."""
        found = self.tab.evaluate(_POSES)
        return {name: np.reshape(numbers, (4, 4)).T for name, numbers in found}

    def pixel(self, name: str, point: Sequence[float] = (0.0, 0.0, 0.0)) -> Point:
        """Place on the page, [px], of ``point`` in the frame of the node, [unit]."""
        pixel = self.tab.evaluate(_PIXEL, [name, list(point)])
        assert pixel is not None, f"no node {name}"
        x, y = pixel
        return (x, y)

    def is_free(self, pixel: Point) -> bool:
        """Check whether the canvas itself is at ``pixel``: no panel or notice lies over it."""
        return bool(self.tab.evaluate(_FREE, list(pixel)))

    def drag(
        self,
        start: Point,
        end: Point,
        steps: int = 8,
        midway: Callable[[], None] | None = None,
    ) -> None:
        """Press the mouse at ``start``, move it to ``end`` in ``steps``, release it.

        ``midway`` is called after half the steps, while the mouse is down and still.
        """
        for pixel in (start, end):
            self._await_free(pixel)
        mouse = self.tab.mouse
        mouse.move(*start)
        self.frames(3)  # what is under the mouse is found while drawing
        mouse.down()
        self.frames(2)
        for step in range(1, steps + 1):
            part = step / steps
            mouse.move(start[0] + part * (end[0] - start[0]), start[1] + part * (end[1] - start[1]))
            self.frames(1)
            if midway is not None and 2 * step == steps:
                midway()
        mouse.up()

    def _await_free(self, pixel: Point) -> None:
        """Wait until the canvas is at ``pixel``: a notice that lies over it goes after a while."""
        if not self.is_free(pixel):
            cover = self.tab.evaluate(_COVER, list(pixel))
            self.until(lambda: self.is_free(pixel), f"free canvas at {pixel}, not {cover}")

    def drag_arrow(
        self, gizmo: str, axis: int, distance: float, midway: Callable[[], None] | None = None
    ) -> None:
        """Pull an arrow of transform controls along its local ``axis`` (0, 1, 2) by ``distance``.

        The arrow is gripped near its tip, since what is clickable and nearer to the eye, such as an
        obstacle's body, takes the mouse from its shaft.
        """
        self.choose_body(gizmo)
        grip = [0.0, 0.0, 0.0]
        grip[axis] = 0.85 * float(self.props(gizmo)["scale"])
        start = self.pixel(gizmo, grip)
        grip[axis] += distance
        self.drag(start, self.pixel(gizmo, grip), midway=midway)

    def choose_body(self, gizmo: str) -> None:
        """Click what a gizmo moves until it has arrows, as the camera may move under a click."""
        for _ in range(_CLICKS):
            if not self._lacks_arrows(gizmo):
                return
            # anew each time: the camera may still be on its way
            self.until(lambda: self.is_free(self.pixel(gizmo)), f"{gizmo} not to be covered")
            self.tab.mouse.move(*self.pixel(gizmo))
            self.frames(3)
            self.tab.mouse.down()
            self.frames(2)
            self.tab.mouse.up()
            end = time.monotonic() + PATIENCE / _CLICKS
            while self._lacks_arrows(gizmo) and time.monotonic() < end:
                self.tab.wait_for_timeout(20)
            self.frames(3)
        assert not self._lacks_arrows(gizmo), f"{gizmo} was clicked, and has no arrows"

    def _lacks_arrows(self, gizmo: str) -> bool:
        return bool(self.props(gizmo)["disable_axes"])

    def picture(self) -> NDArray[np.uint16]:
        """The scene's picture, drawn for once: the sum of red, green and blue for each pixel."""
        error, greys = self.tab.evaluate(_PICTURE)
        assert error == 0, f"WebGL error {error}"
        return np.frombuffer(greys.encode("utf-16-le"), dtype=np.uint16)

    def frames(self, count: int) -> None:
        """Let the page draw that many frames."""
        self.tab.evaluate(_FRAMES, count)

    # The panels

    def row(self, label: str) -> Locator:
        """The visible widget with that label."""
        text = re.compile(rf"^\s*{re.escape(label)}\s*$")
        label_element = self.tab.locator("label").filter(has_text=text, visible=True)
        return label_element.locator(
            "xpath=ancestor::*[contains(concat(' ', @class, ' '), ' mantine-Flex-root ')][1]"
        )

    def set_number(self, label: str, value: float | str, index: int = 0) -> None:
        """Type into a number, a slider's box, a text or, by ``index``, one box of a vector.

        As a person does, once the page stands still: a box that is drawn anew that very moment may
        lose what is typed.
        """
        self.settle()
        box = self.row(label).locator("input:visible").nth(index)
        box.fill(str(value))
        box.press("Tab")

    def scrub(self, part: float) -> None:
        """Press the track of the player's slider at ``part`` (0 to 1) of its length."""
        box = self.tab.locator(_PLAYER).bounding_box()
        assert box is not None, "the player is not on screen"
        self.tab.mouse.click(box["x"] + part * box["width"], box["y"] + box["height"] / 2)

    def set_time(self, time: float) -> None:
        """Set the player's slider to ``time`` [s]."""
        self.tab.locator(_PLAYER).fill(str(time))

    def time(self) -> float:
        """The time that the player shows, [s]."""
        return float(self.tab.locator("#abi-overlay output").inner_text().split(" of ")[0])

    def choose(self, label: str, option: str) -> None:
        """Pick an option of a dropdown, or press one button of a group."""
        row = self.row(label)
        dropdown = row.get_by_role("combobox")
        if dropdown.count():
            dropdown.click()
            self.tab.get_by_role("option", name=option, exact=True).click()
        else:
            row.get_by_role("button", name=option, exact=True).click()

    def tick(self, label: str, on: bool) -> None:
        """Check or uncheck a box."""
        self.row(label).locator("input[type=checkbox]").set_checked(on)

    def click(self, name: str) -> None:
        """Click the visible button or the panel's tab of that name."""
        # asked by roles, the page looks at the style of all that is above each button
        text = re.compile(rf"^\s*{re.escape(name)}\s*$")
        written = self.tab.locator("button, [role=tab]").filter(has_text=text, visible=True)
        label = json.dumps(name, ensure_ascii=False)
        told = self.tab.locator(f"button[aria-label={label}]").filter(visible=True)
        written.or_(told).click()

    def is_open(self, name: str) -> bool:
        """Check whether the panel's tab of that name is the one that is shown."""
        return bool(self.tab.evaluate(_IS_OPEN, name))

    def upload(self, button: str, name: str, content: bytes) -> None:
        """Click an upload button and choose a file."""
        self.upload_all(button, {name: content})

    def upload_all(self, button: str, files: dict[str, bytes]) -> None:
        """Click an upload button and choose files, by their names."""
        with self.tab.expect_file_chooser() as chooser:
            self.click(button)
        chosen: list[FilePayload] = [
            {"name": name, "mimeType": "application/octet-stream", "buffer": content}
            for name, content in files.items()
        ]
        chooser.value.set_files(chosen)

    def text(self) -> str:
        """Everything that can be read on the page."""
        return self.tab.locator("body").inner_text().replace("\N{NO-BREAK SPACE}", " ")

    def reads(self, text: str) -> None:
        """Wait until ``text`` stands on the page."""
        self.until(lambda: text in self.text(), repr(text))

    def close_notices(self) -> None:
        """Close what pops up, which may stay until somebody does."""
        self.tab.evaluate(_CLOSE_NOTICES)

    def complaints(self) -> list[str]:
        """The sentences that say what is wrong."""
        return [line for line in self.text().splitlines() if line.startswith("✗ ")]

    def send(self, message: dict[str, Any]) -> None:
        """Send what the page itself would never send, over its own connection."""
        self.tab.evaluate(_SEND, message)
