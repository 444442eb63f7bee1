"""A browser's tab without a browser: hundreds of them fit in one process, beside the server."""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
import struct
import time
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any

import msgspec
import numpy as np
import viser
import zstandard
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed
from websockets.protocol import State
from websockets.typing import Subprotocol

from abi.arrays import FloatArray

CURVE = "/curve/bspline"
GIZMO = "/obstacle_1"
_ANSWERS = "/answers/"
"""Beginning of the names of the balls of a class's answers."""
PERIOD = 0.05
"""Seconds between two messages of viser's page while a hand drags."""
CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [3.0, 3.0, 3.0],
    "fov": 1.3,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 600,
    "image_width": 800,
    "look_at": [0.0, 0.0, 0.0],
    "up_direction": [0.0, 0.0, 1.0],
}
_POLL = 0.02  # [s]
_TEXTS = 50
_REPORT, _REMEMBER = "abi.report(", "abi.remember("
"""Calls of the page: to report what it remembers, and to remember a text."""
_CALLS = (_REPORT.encode(), _REMEMBER.encode())
_TOLD = (
    CURVE.encode(),
    _ANSWERS.encode(),
    b"TransformControlsMessage",
    b"label",
    b"content",
    *_CALLS,
)
"""Bytes, one of which is in every message that a tab notes."""
_DECOMPRESSOR = zstandard.ZstdDecompressor()


class WebTab:
    """Client that speaks viser's protocol: it drags the first obstacle, and notes each new curve.

    Attributes:
        curves: when one came, [s] of the monotonic clock, and its points as they were sent.
        received: bytes so far.
        labels: ids of the widgets, by their labels.
        texts: HTML that was shown in the panels, the newest last.
        position: where the obstacle was dragged to last, (3,), [unit]; None before.
        remembered: text that the page keeps, and reports where it connects.
        query: of the page's address, which it reports.
        student: the name that its browser made up, which it reports; empty for none.
        balls: of a class's answers: when one came last, [s] of the monotonic clock, by its place.
    """

    def __init__(self, url: str, headers: dict[str, str] | None = None) -> None:
        """Begin unconnected, with the address of a page and headers of its requests."""
        self._address = url.replace("http", "ws", 1), headers
        self._owner: str | None = None
        self._connection: ClientConnection
        self._reading: asyncio.Task[None] | None = None
        self._awake = asyncio.Event()
        self._awake.set()
        self.curves: list[tuple[float, FloatArray]] = []
        self.received = 0
        self.labels: dict[str, str] = {}
        self.texts: deque[str] = deque(maxlen=_TEXTS)
        self.position: tuple[float, float, float] | None = None
        self.remembered = ""
        self.query: dict[str, str] = {}
        self.student = ""
        self.balls: dict[tuple[float, ...], float] = {}

    @classmethod
    async def open(cls, url: str, headers: dict[str, str] | None = None) -> WebTab:
        """Connect to the server at ``url``; the tab has its picture once :meth:`until` says so."""
        tab = cls(url, headers)
        await tab.connect()
        return tab

    async def connect(self) -> None:
        """Connect, or connect again as a page does that was cut off, with what it remembers."""
        if self._reading is not None:
            await self._reading
        self._owner = None
        self.curves.clear()
        self.labels.clear()
        address, headers = self._address
        self._connection = await connect(
            address,
            subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
            additional_headers=headers,
            max_size=None,
            compression=None,
            ping_interval=None,
        )
        await self.send(CAMERA)
        self._reading = asyncio.create_task(self._read())

    async def answers(self) -> bool:
        """Tell if the server answers, rather than having cut the tab off; reads all it had sent."""
        try:
            await (await self._connection.ping())
        except ConnectionClosed:
            return False
        return True

    @property
    def is_connected(self) -> bool:
        """Whether the connection is open, as far as has been read."""
        return self._connection.state is State.OPEN

    @property
    def drawn(self) -> bool:
        """Whether there is a curve, and an obstacle to drag."""
        return self._owner is not None and bool(self.curves)

    async def send(self, message: dict[str, Any]) -> None:
        """Send one message, as the page's msgpack."""
        await self._connection.send(msgspec.msgpack.encode(message))

    async def press(self, label: str) -> None:
        """Press the button with this label."""
        await self.type(label, True)

    async def type(self, label: str, value: str | bool) -> None:
        """Give the widget with this label a value."""
        update = {"uuid": self.labels[label], "updates": {"value": value}}
        await self.send({"type": "GuiUpdateMessage", **update})

    async def move(self, position: tuple[float, float, float]) -> None:
        """Move the obstacle there, as one step of a drag."""
        self.position = position
        message = {
            "type": "TransformControlsUpdateMessage",
            "name": GIZMO,
            "wxyz": [1.0, 0.0, 0.0, 0.0],
            "position": list(position),
            "owner": self._owner,
        }
        if not self.is_connected:
            await self.send(message)  # which says why it cannot
            return
        self._send_at_once(message)

    async def click(self, origin: FloatArray, direction: FloatArray) -> None:
        """Click in the scene, where a ray goes."""
        await self.send(
            {
                "type": "ScenePointerMessage",
                "event_type": "click",
                "ray_origin": origin.tolist(),
                "ray_direction": direction.tolist(),
                "screen_pos": [[0.5, 0.5]],
                "modifier": None,
            }
        )

    async def drag(self, seconds: float, phase: float) -> float:
        """Drag the obstacle around a circle from ``phase`` [rad] on; when the hand let go, [s]."""
        begin = last = time.monotonic()
        step = 0
        while last - begin < seconds:
            angle = phase + 0.07 * step
            await self.move((3 + 0.8 * math.cos(angle), 3 + 0.8 * math.sin(angle), 3.0))
            last, step = time.monotonic(), step + 1
            await asyncio.sleep(max(begin + step * PERIOD - last, 0.0))
        return last

    def freeze(self, on: bool) -> None:
        """Read no more, or read again.

        A frozen tab does not answer to pings, either: nothing is taken from its socket.
        """
        if on:
            self._awake.clear()
            self._connection.transport.pause_reading()
        else:
            self._connection.transport.resume_reading()
            self._awake.set()

    async def until(self, condition: Callable[[], bool], patience: float = 120.0) -> None:
        """Wait until ``condition()``.

        Raises:
            TimeoutError: it did not come in ``patience`` seconds.
        """
        async with asyncio.timeout(patience):
            while not condition():
                await asyncio.sleep(_POLL)

    async def shows(self, expected: FloatArray, patience: float = 120.0) -> float:
        """Time at which the shown curve came, if it is the ``expected`` one; else infinity."""
        try:
            await self.until(
                lambda: bool(self.curves) and is_same_curve(self.curves[-1][1], expected), patience
            )
        except TimeoutError:
            return math.inf
        return self.curves[-1][0]

    async def close(self) -> None:
        """Disconnect."""
        self.freeze(False)
        await self._connection.close()
        if self._reading is not None:
            await self._reading

    async def _read(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            while True:
                await self._awake.wait()
                frame = await self._connection.recv(decode=False)
                self.received += len(frame)
                self._note(frame)

    def _note(self, frame: bytes) -> None:
        raw = decompress(frame)
        if not any(told in raw for told in _TOLD):
            return
        content, arrays = decode(frame, raw)
        for message in content["messages"]:
            name = message.get("name")
            fields = message.get("props") or message.get("updates") or {}
            if name == CURVE and "points" in fields:
                points = arrays(fields["points"])
                if len(points):
                    self.curves.append((time.monotonic(), points))
            elif message["type"] == "SetPositionMessage" and str(name).startswith(_ANSWERS):
                self.balls[tuple(message["position"])] = time.monotonic()
            elif name == GIZMO and message["type"] == "TransformControlsMessage":
                self._owner = message["owner"]
            elif fields.get("label") and "uuid" in message:
                self.labels[fields["label"]] = message["uuid"]
            elif fields.get("content") and "uuid" in message:
                self.texts.append(fields["content"])
            elif message["type"] == "RunJavascriptMessage":
                self._run(message["source"])

    def _run(self, source: str) -> None:
        """Do what the page does that is told to report, or to remember: see ``page.js``."""
        if source.startswith(_REMEMBER):
            self.remembered = json.loads(source.removeprefix(_REMEMBER).removesuffix(")"))
        elif source.startswith(_REPORT) and self.is_connected:
            box = json.loads(source.removeprefix(_REPORT).removesuffix(")"))
            report = {"state": self.remembered, "lessons": "", "query": self.query, "dark": False}
            report["student"] = self.student
            update = {"uuid": box, "updates": {"value": json.dumps(report)}}
            self._send_at_once({"type": "GuiUpdateMessage", **update})

    def _send_at_once(self, message: dict[str, Any]) -> None:
        """Send without waiting: the moves of all hands would be most of what the tabs cost."""
        self._connection.protocol.send_binary(msgspec.msgpack.encode(message))
        self._connection.send_data()


def is_same_curve(points: FloatArray, expected: FloatArray) -> bool:
    """Check whether a curve is the expected one, as far as single precision tells."""
    return points.shape == expected.shape and np.allclose(points, expected, atol=1e-4)


def decompress(frame: bytes) -> bytes:
    """Messages of a frame of viser's protocol, packed, without their arrays."""
    length, packed = struct.unpack_from("<QQ", frame)
    return _DECOMPRESSOR.decompress(frame[16 : 16 + packed], max_output_size=length)


def decode(
    frame: bytes, raw: bytes | None = None
) -> tuple[dict[str, Any], Callable[[dict[str, Any]], FloatArray]]:
    """Content of a frame, and what turns its placeholders into arrays; ``raw`` if decompressed."""
    packed: int = struct.unpack_from("<Q", frame, 8)[0]
    content = msgspec.msgpack.decode(decompress(frame) if raw is None else raw)
    places, place = [], 16 + packed
    for size in content["binaryBufferLengths"]:
        place += -place % 8
        places.append((place, size))
        place += size
    return content, partial(_array, frame, places)


def _array(frame: bytes, places: list[tuple[int, int]], placeholder: dict[str, Any]) -> FloatArray:
    """The array that a placeholder stands for, at its place in the frame."""
    begin, size = places[placeholder["__binary_index"]]
    return np.frombuffer(frame[begin : begin + size], placeholder["dtype"])
