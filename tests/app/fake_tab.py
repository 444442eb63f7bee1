"""A browser tab without a browser: just enough of viser's protocol for a session to begin."""

from __future__ import annotations

import asyncio
import contextlib
import json
import socket
import threading
import uuid
from collections.abc import Callable
from dataclasses import asdict
from typing import Any, TypeVar

import msgspec
import numpy as np
import pytest
import viser
from viser import _messages
from viser.infra import ClientId
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from abi.arrays import FloatArray
from app.server.server import Server
from app.tab.session import Session
from app.ui import page
from app.ui.page_area import PageArea
from benchmarks.web_tab import CAMERA

_Layer = TypeVar("_Layer")

WAIT = 60.0  # [s]


def until(condition: Callable[[], bool], patience: float = WAIT) -> None:
    """Wait for another thread until ``condition()``; fail after ``patience`` seconds."""
    pause = threading.Event()
    for _ in range(int(patience / 0.01)):
        if condition():
            return
        pause.wait(0.01)
    raise AssertionError("did not happen in time")


def layer(session: Session, kind: type[_Layer]) -> _Layer:
    """The session's layer of that kind."""
    (match,) = (layer for layer in session._view.layers.values() if isinstance(layer, kind))
    return match


def drawn_node(session: Session, name: str) -> Any:
    """The node of that name in the session's scene."""
    return session.client.scene._handle_from_node_name[name]


def labelled(session: Session, label: str) -> Any:
    """The widget of that label in the session's panels."""
    widgets = session.client.gui._gui_input_handle_from_uuid.values()
    return next(one for one in widgets if getattr(one, "label", None) == label)


def comparison_table(session: Session) -> Any:
    """The table of all searches, which is the first that the studies add to their tab."""
    children = session.panels.layout.search._children.values()
    texts = [one for one in children if isinstance(one, viser.GuiHtmlHandle)]
    return sorted(texts, key=lambda one: one.order)[-2]


def texts_in(container: Any) -> list[str]:
    """The texts right in a tab or folder of the page, as HTML, in their order."""
    children = container._children.values()
    return [one.content for one in children if isinstance(one, viser.GuiHtmlHandle)]


def accept(fake: FakeTab, session: Session, label: str) -> None:
    """Press the button over the scene that makes the change of that label, once it is offered."""
    messages = session.panels.messages
    until(lambda: label in messages._offers)
    fake.set(messages._accepts[list(messages._offers).index(label)], True)


def drawn_points(cloud: viser.PointCloudHandle) -> FloatArray:
    """The points (n, 3) as they were drawn last, [unit], world."""
    return np.asarray(cloud.points, float)


def notified(monkeypatch: pytest.MonkeyPatch, session: Session) -> list[tuple[str, str]]:
    """Title and body of each notification from now on, none of which is sent."""
    told: list[tuple[str, str]] = []
    monkeypatch.setattr(
        session.client, "add_notification", lambda title, body, **_: told.append((title, body))
    )
    return told


def heard(monkeypatch: pytest.MonkeyPatch, function: page.Function) -> list[Any]:
    """Argument of each call of a page's function from now on, none of which is sent."""
    calls: list[Any] = []
    send = page.call

    def call(client: viser.ClientHandle, name: page.Function, *arguments: object) -> None:
        if name == function:
            calls.extend(arguments)
        else:
            send(client, name, *arguments)

    monkeypatch.setattr(page, "call", call)
    return calls


def open_plots(tab: FakeTab, session: Session) -> None:
    """Tell the session that the tab with the plots is open."""
    tab.set(labelled(session, "area"), json.dumps(asdict(PageArea(plots=True))))


def send_file(session: Session, button: Any, name: str, content: bytes) -> None:
    """Send a file in one part, as a page does, and wait until the server has it."""
    transfer, number = uuid.uuid4().hex, session.client.client_id
    begin = _messages.FileTransferStartUpload(
        page.uuid(button), transfer, name, "", 1, len(content)
    )
    part = _messages.FileTransferPart(page.uuid(button), transfer, 0, content)
    interface = session.client.gui._websock_interface
    loop = session.client._viser_server._websock_server._background_event_loop
    assert loop is not None
    for message in (begin, part):
        heard = interface._handle_incoming_message(ClientId(number), message)
        asyncio.run_coroutine_threadsafe(heard, loop).result(WAIT)


def opened(server: Server, patience: float = WAIT) -> tuple[FakeTab, Session]:
    """A new tab and its session, once that has a plan."""
    known = set(server.sessions)
    fake = FakeTab(server.url)
    until(lambda: bool(set(server.sessions) - known))
    (number,) = set(server.sessions) - known
    session = server.sessions[number]
    until(lambda: session.plan is not None or session._fault is not None, patience)
    assert session._fault is None, session._fault
    return fake, session


class FakeTab:
    """Client that sends a page's messages, and counts and drops what it receives."""

    def __init__(self, url: str, headers: dict[str, str] | None = None, greet: bool = True) -> None:
        self._socket: ClientConnection = connect(
            url.replace("http", "ws", 1),
            subprotocols=[f"viser-v{viser.__version__}"],  # type: ignore[list-item]
            additional_headers=headers,
            max_size=None,
            compression=None,
        )
        if greet:
            self.send(CAMERA)
        self.received = 0
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def send(self, message: dict[str, Any]) -> None:
        """Send one message, as the page's msgpack."""
        self._socket.send(msgspec.msgpack.encode(message))

    def send_raw(self, frame: bytes | str) -> None:
        """Send a frame as it is."""
        self._socket.send(frame)

    def set(self, handle: Any, value: Any) -> None:
        """Type or drag ``value`` into a widget."""
        uuid = handle._impl.uuid
        self.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}})

    def click(self, origin: FloatArray, direction: FloatArray) -> None:
        """Click in the scene, where a ray goes."""
        self.send(
            {
                "type": "ScenePointerMessage",
                "event_type": "click",
                "ray_origin": origin.tolist(),
                "ray_direction": direction.tolist(),
                "screen_pos": [[0.5, 0.5]],
                "modifier": None,
            }
        )

    def drag(self, gizmo: Any, position: list[float]) -> None:
        """Move a gizmo there, as one step of a drag."""
        self.send(
            {
                "type": "TransformControlsUpdateMessage",
                "name": gizmo._impl.name,
                "wxyz": [float(number) for number in gizmo.wxyz],
                "position": position,
                "owner": gizmo._impl.api._owner_id,
            }
        )

    def hold(self, gizmo: Any) -> None:
        """Take a gizmo's handle into the hand."""
        self._grip("Start", gizmo)

    def let_go(self, gizmo: Any) -> None:
        """Let go of a gizmo's handle."""
        self._grip("End", gizmo)

    def _grip(self, phase: str, gizmo: Any) -> None:
        kind = f"TransformControlsDrag{phase}Message"
        self.send({"type": kind, "name": gizmo._impl.name, "owner": gizmo._impl.api._owner_id})

    def look(self, camera: Any, width: int, position: Any = None) -> None:
        """Report the camera, by default where it was put, in a picture of such a width [px]."""
        position = camera.position if position is None else position
        view = {
            "position": [float(x) for x in position],
            "look_at": [float(x) for x in camera.look_at],
            "image_width": width,
        }
        self.send({**CAMERA, **view})

    def close(self) -> None:
        """Disconnect."""
        self._socket.close()
        self._reader.join(timeout=5)

    def cut(self) -> None:
        """Vanish without a word, as a laptop whose lid is closed."""
        with contextlib.suppress(OSError):
            self._socket.socket.shutdown(socket.SHUT_RDWR)
        self._reader.join(timeout=5)

    def _read(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            for raw in self._socket:
                self.received += len(raw)
