"""The web server: one session for each connected tab.

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

_ANY_ADDRESS = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}
"""Addresses that stand for all of this machine's, each with one that a browser can open."""


class Server:
    """The page at ``host``, and the tabs' sessions once it has a scene.

    Attributes:
        url: of the page, e.g. ``http://127.0.0.1:8080``.
        sessions: one a tab, by viser's client id.
    """

    def __init__(self, host: str, port: int, plain: bool, dark: bool) -> None:
        self._plain, self._dark = plain, dark
        self._lock = threading.Lock()
        self.sessions: dict[int, Session] = {}
        self.viser = viser.ViserServer(
            host=_usable_address(host), port=port, label="ABI visualiser", verbose=False
        )
        page.disable_sharing(self.viser)
        self.viser.gui.configure_theme(dark_mode=dark, show_logo=False, show_share_button=False)
        # shadows and surroundings take a weak machine seconds: each tab has them after its plan
        self.viser.scene.configure_default_lights(cast_shadow=False)
        self.viser.scene.configure_environment_map(hdri=None)
        self.url = f"http://{_url_host(host)}:{self.viser.get_port()}"

    def show(self, name: str, scene: Scene) -> None:
        """Open a session on the scene for every tab, present and future."""
        from app.camera import look_at
        from app.warm_up import WarmUp

        look_at(self.viser.initial_camera, scene)
        self.viser.on_client_disconnect(self._close_session)
        self.viser.on_client_connect(functools.partial(self._open_session, name, scene, WarmUp()))

    def stop(self) -> None:
        """End every session and close the port."""
        with self._lock:
            sessions, self.sessions = list(self.sessions.values()), {}
        for session in sessions:
            session.close()
        self.viser.stop()

    def _open_session(
        self, name: str, scene: Scene, warm_up: WarmUp, client: viser.ClientHandle
    ) -> None:
        from app.session import Session

        session = Session(client, name, scene, self._plain, self._dark, warm_up.planned)
        warm_up.add(client)
        with self._lock:
            if client.client_id in self.viser.get_clients():
                self.sessions[client.client_id] = session
                return
        session.close()

    def _close_session(self, client: viser.ClientHandle) -> None:
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
    announce: Callable[[str], object] = lambda url: None,
) -> Server:
    """Start serving and return at once.

    Args:
        host: address to listen on.
        port: 0 takes any free one; a busy one, the next free.
        scene: a shipped scene's name or a scene file.
        plain: no shadows and no environment map, for slow graphics and tests.
        dark: whether a new tab begins dark.
        announce: called with the URL as soon as there is a page to load.

    Raises:
        AbiError: the scene cannot be read, or ``host`` is no address of this machine.
    """
    # a tab may close in the middle of a frame; its session ends right after
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
    # the workers plan in Python: shorter turns let the event loop answer meanwhile
    sys.setswitchinterval(0.0005)
    # a file that may be wrong is read before there is a page
    loaded = None if scene == PAPER else _load(scene)
    server = Server(host, port, plain, dark)
    announce(server.url)
    server.show(scene, loaded or _load(scene))
    return server


def _usable_address(host: str) -> str:
    """An address to listen on, tried out, since viser would try 1,000 ports on a wrong one.

    It is ``host``; of a name with addresses that are not this machine's, such as ``::1`` without
    IPv6, the first that is.

    Raises:
        AbiError: no address of ``host`` is this machine's.
    """
    usable, refused = [], []
    try:
        addresses = socket.getaddrinfo(host, 0, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
    except (OSError, ValueError) as error:  # ValueError: cannot be a host's name
        addresses, refused = [], [error]
    for family, kind, protocol, _, address in addresses:
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


def _url_host(host: str) -> str:
    """``host`` as part of a URL."""
    if host in _ANY_ADDRESS:
        return _ANY_ADDRESS[host]
    return f"[{host}]" if ":" in host else host


def _load(name: str) -> Scene:
    from abi.scene.scene import load_scene

    return load_scene(name)
