"""The web server: a tab connects and gets a session, a tab leaves and its session ends."""

from __future__ import annotations

import sys
import threading
import warnings

import viser

from abi.scene import Scene, load_scene
from app import page
from app.session import Session, look_at
from app.warm_up import WarmUp


class Server:
    """A running visualiser.

    Attributes:
        url: where it is, e.g. ``http://127.0.0.1:8080``.
        sessions: one a tab, by viser's client id.
    """

    def __init__(
        self, host: str, port: int, name: str, scene: Scene, plain: bool, dark: bool
    ) -> None:
        self._name, self._scene, self._dark = name, scene, dark
        self._lock = threading.Lock()
        self.sessions: dict[int, Session] = {}
        self._warm_up = WarmUp()
        self.viser = viser.ViserServer(host=host, port=port, label="ABI visualiser", verbose=False)
        page.refuse_sharing(self.viser)
        self.viser.gui.configure_theme(dark_mode=dark, show_logo=False, show_share_button=False)
        look_at(self.viser.initial_camera, scene)
        if plain:
            self.viser.scene.configure_default_lights(cast_shadow=False)
            self.viser.scene.configure_environment_map(hdri=None)
        self.viser.on_client_connect(self._connected)
        self.viser.on_client_disconnect(self._left)
        self.url = f"http://{'127.0.0.1' if host == '0.0.0.0' else host}:{self.viser.get_port()}"

    def stop(self) -> None:
        """End every session and close the port."""
        with self._lock:
            sessions, self.sessions = list(self.sessions.values()), {}
        for session in sessions:
            session.close()
        self.viser.stop()

    def _connected(self, client: viser.ClientHandle) -> None:
        session = Session(client, self._name, self._scene, self._dark, self._warm_up.planned)
        self._warm_up.greet(client)
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
    scene: str = "paper",
    plain: bool = False,
    dark: bool = False,
) -> Server:
    """Start serving and return at once.

    Args:
        host: address to listen on.
        port: 0 takes any free one; a busy one, the next free.
        scene: a shipped scene's name or a scene file.
        plain: no shadows and no environment map, for slow graphics and tests.
        dark: whether a new tab begins dark.

    Raises:
        SceneError: the scene cannot be read.
    """
    loaded = load_scene(scene)
    # A tab that leaves in the middle of a frame is no news; its session is told right after.
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
    # The worker threads plan in Python; shorter turns keep the event loop answering meanwhile.
    sys.setswitchinterval(0.0005)
    server = Server(host, port, scene, loaded, plain, dark)
    return server
