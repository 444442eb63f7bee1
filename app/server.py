"""The web server: a tab connects and gets a session, a tab leaves and its session ends.

The page takes a second to load, and so does the method. What needs the method is imported where it
is used, so that both load at once.
"""

from __future__ import annotations

import functools
import socket
import sys
import threading
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING

import viser

from app import page

if TYPE_CHECKING:
    from abi.scene.scene import Scene
    from app.session import Session
    from app.warm_up import WarmUp

PAPER = "paper"

_ALL = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}
"""Addresses that mean every one of this machine's, and one that a browser can be given."""


class Server:
    """A page that anyone on ``host`` can load, and once it shows a scene, a visualiser.

    Attributes:
        url: where it is, e.g. ``http://127.0.0.1:8080``.
        sessions: one a tab, by viser's client id.
    """

    def __init__(self, host: str, port: int, plain: bool, dark: bool) -> None:
        self._plain, self._dark = plain, dark
        self._lock = threading.Lock()
        self.sessions: dict[int, Session] = {}
        self.viser = viser.ViserServer(
            host=_listening(host), port=port, label="ABI visualiser", verbose=False
        )
        page.refuse_sharing(self.viser)
        self.viser.gui.configure_theme(dark_mode=dark, show_logo=False, show_share_button=False)
        # shadows and surroundings take a weak machine seconds: each tab has them after its plan
        self.viser.scene.configure_default_lights(cast_shadow=False)
        self.viser.scene.configure_environment_map(hdri=None)
        self.url = f"http://{_named(host)}:{self.viser.get_port()}"

    def show(self, name: str, scene: Scene) -> None:
        """Give every tab the scene, those that wait already and those to come."""
        from app.camera import look_at
        from app.warm_up import WarmUp

        look_at(self.viser.initial_camera, scene)
        self.viser.on_client_disconnect(self._left)
        self.viser.on_client_connect(functools.partial(self._came, name, scene, WarmUp()))

    def stop(self) -> None:
        """End every session and close the port."""
        with self._lock:
            sessions, self.sessions = list(self.sessions.values()), {}
        for session in sessions:
            session.close()
        self.viser.stop()

    def _came(self, name: str, scene: Scene, warm_up: WarmUp, client: viser.ClientHandle) -> None:
        from app.session import Session

        session = Session(client, name, scene, self._plain, self._dark, warm_up.planned)
        warm_up.greet(client)
        with self._lock:
            if client.client_id in self.viser.get_clients():
                self.sessions[client.client_id] = session
                return
        session.close()

    def _left(self, client: viser.ClientHandle) -> None:
        with self._lock:
            session = self.sessions.pop(client.client_id, None)
        if session is not None:
            session.close()


def start(
    host: str = "127.0.0.1",
    port: int = 8080,
    scene: str = PAPER,
    plain: bool = False,
    dark: bool = False,
    opened: Callable[[str], object] = lambda url: None,
) -> Server:
    """Start serving and return at once.

    Args:
        host: address to listen on.
        port: 0 takes any free one; a busy one, the next free.
        scene: a shipped scene's name or a scene file.
        plain: no shadows and no environment map, for slow graphics and tests.
        dark: whether a new tab begins dark.
        opened: told the address as soon as there is a page to load.

    Raises:
        AbiError: the scene cannot be read, or ``host`` is no address of this machine.
    """
    # A tab that leaves in the middle of a frame is no news; its session is told right after.
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
    # The worker threads plan in Python; shorter turns keep the event loop answering meanwhile.
    sys.setswitchinterval(0.0005)
    # what may be wrong is read before there is a page
    read = None if scene == PAPER else _read(scene)
    server = Server(host, port, plain, dark)
    opened(server.url)
    server.show(scene, read or _read(scene))
    return server


def _listening(host: str) -> str:
    """``host`` once something has listened on it, for viser would try 1,000 ports on any.

    Where only some of a name's addresses are this machine's, as ``::1`` is not without IPv6, it is
    the first that is: with all of them no port would do.

    Raises:
        AbiError: none is.
    """
    usable, refused = [], []
    try:
        found = socket.getaddrinfo(host, 0, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
    except (OSError, ValueError) as error:  # what can be no name at all is a ValueError
        found, refused = [], [error]
    for family, kind, protocol, _, address in found:
        try:
            with socket.socket(family, kind, protocol) as probe:
                probe.bind(address)
        except OSError as error:
            refused.append(error)
        else:
            usable.append(str(address[0]))
    if usable:
        return usable[0] if refused else host
    from abi.errors import AbiError

    reason = (getattr(refused[0], "strerror", None) or "no name of a host").lower()
    expected = "an address of this machine, such as 127.0.0.1, or 0.0.0.0 for all of them"
    raise AbiError(f"--host is {host!r}; expected {expected} ({reason}).")


def _named(host: str) -> str:
    """How an address on this machine is written in a URL."""
    if host in _ALL:
        return _ALL[host]
    return f"[{host}]" if ":" in host else host


def _read(name: str) -> Scene:
    from abi.scene.scene import load_scene

    return load_scene(name)
