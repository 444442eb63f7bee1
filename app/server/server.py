"""The web server: one session for each connected tab.

The page takes a second to load, and so does the method. Code that needs the method imports it where
it is used, so that both load at the same time.
"""

from __future__ import annotations

import contextlib
import functools
import socket
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import viser

from app.guard import guarded_server, token
from app.guard.guard import Guard
from app.guard.policy import Policy, policy_for
from app.guard.porter import Porter
from app.guard.side_door import SideDoor
from app.process.available_memory import memory_in_all
from app.server.address import ensure_port, listening_url, usable_address
from app.state.appearance import OPENING, Appearance
from app.ui import notices, page

if TYPE_CHECKING:
    from pathlib import Path

    from abi.scene.scene import Scene
    from app.process.memory_budget import MemoryBudget
    from app.server.warm_up import WarmUp
    from app.shared.shared_plans import SharedPlans
    from app.tab.session import Session
    from app.teach.classroom import Classroom
    from app.teach.exercise_watch import ExerciseWatch
    from app.teach.lesson import Lessons, Library

_AS_THE_SYSTEM = Appearance()
_FAREWELL = 0.2
"""Seconds to tell the tabs that the server stops."""
_LONGEST_OPENING = 2.0
"""Seconds that stopping waits for tabs that are being opened."""


_DEMOS = 3
"""Most tabs that show the demonstration at once, as it plans continuously."""


class Server:
    """The page at ``host``, and the sessions of the tabs once there is a scene.

    Attributes:
        url: of the page, e.g. ``http://127.0.0.1:8080``.
        link: the same with the token, where one is needed.
        guard: what lets visitors in.
        sessions: one a tab, by viser's client id.
    """

    def __init__(
        self,
        host: str,
        port: int,
        look: Appearance = _AS_THE_SYSTEM,
        policy: Policy | None = None,
        entrance: Porter | SideDoor | None = None,
    ) -> None:
        """Open the port, or the side door; arguments as for :func:`start`."""
        self._look = look
        self._tabs = threading.Condition()
        self._being_opened = 0
        self.sessions: dict[int, Session] = {}
        self.classroom: Classroom | None = None
        self.exercise: ExerciseWatch | None = None
        self.guard = Guard(policy or policy_for(host), entrance)
        usable = host if isinstance(entrance, SideDoor) else usable_address(host, port)
        self.viser = guarded_server.build(self.guard, usable, port, "ABI visualiser")
        ensure_port(self.viser, port)
        page.disable_sharing(self.viser)
        self.viser.gui.configure_theme(
            dark_mode=bool(look.dark), show_logo=False, show_share_button=False
        )
        # shadows and surroundings take a weak machine seconds: each tab has them after its plan
        self.viser.scene.configure_default_lights(cast_shadow=False)
        self.viser.scene.configure_environment_map(hdri=None)
        self.url = listening_url(host, self.viser.get_port())
        self.link = token.link(self.url, self.guard.policy.token)

    def show(self, name: str, scene: Scene, library: Library) -> None:
        """Open a session on the scene for every tab, present and future."""
        from app.camera.camera import look_at
        from app.server.warm_up import WarmUp

        look_at(self.viser.initial_camera, scene)
        warm_up = WarmUp(scene, self.opening)
        self.viser.on_client_disconnect(self._close_session)
        self.viser.on_client_connect(
            functools.partial(self._open_session, name, scene, library, warm_up)
        )
        self.guard.ready = True

    @functools.cached_property
    def budget(self) -> MemoryBudget:
        """Memory for the tabs of this process."""
        from app.process.memory_budget import SMALL, MemoryBudget, memory_for_tabs

        entrance = self.guard.entrance
        processes = 1 if entrance is None else entrance.processes
        return MemoryBudget(memory_for_tabs(memory_in_all(), processes), SMALL)

    @functools.cached_property
    def opening(self) -> SharedPlans:
        """First plans of tabs, shared as the tabs of a class open with the same scene."""
        from app.shared.shared_plans import SharedPlans

        return SharedPlans()

    def meet(self, channel: socket.socket) -> None:
        """Share tabs with the process at the other end of a channel."""
        porter = self.guard.entrance
        assert isinstance(porter, Porter)
        with contextlib.suppress(RuntimeError):  # the server has stopped
            page.run_on_loop(self.viser, functools.partial(porter.meet, channel))

    def stop(self) -> None:
        """Notify every tab, end its session and close the port."""
        self.guard.ready = False
        if self.exercise is not None:
            self.exercise.close()
        with self._tabs:  # a tab that is being opened is told, too
            self._tabs.wait_for(lambda: not self._being_opened, _LONGEST_OPENING)
            sessions, self.sessions = list(self.sessions.values()), {}
        for session in sessions:
            session.close()
            notices.notify_end(session.client)
        if sessions:
            threading.Event().wait(_FAREWELL)
        page.run_on_loop(self.viser, self.guard.hang_up)
        self.viser.stop()

    def _open_session(
        self,
        name: str,
        scene: Scene,
        library: Library,
        warm_up: WarmUp,
        client: viser.ClientHandle,
    ) -> None:
        from app.process.turns import PATIENT, TURNS
        from app.tab.session import Session

        with self._awaited(), TURNS.turn(client, PATIENT):
            alone = len(self.sessions) < _DEMOS
            look = replace(self._look, demo=self._look.demo and alone)
            session = Session(
                client,
                name,
                scene,
                look,
                warm_up.planned,
                library,
                self.budget,
                self.opening,
                self.classroom,
                self.exercise,
            )
            warm_up.add(client)
            with self._tabs:
                if client.client_id in self.viser.get_clients():
                    self.sessions[client.client_id] = session
                    return
            session.close()

    @contextlib.contextmanager
    def _awaited(self) -> Iterator[None]:
        """Make :meth:`stop` wait for a tab that is being opened."""
        with self._tabs:
            self._being_opened += 1
        try:
            yield
        finally:
            with self._tabs:
                self._being_opened -= 1
                self._tabs.notify_all()

    def _close_session(self, client: viser.ClientHandle) -> None:
        with self._tabs:
            session = self.sessions.pop(client.client_id, None)
        if session is not None:
            session.close()


def start(
    scene: str = OPENING,
    host: str = "127.0.0.1",
    port: int = 8080,
    look: Appearance = _AS_THE_SYSTEM,
    policy: Policy | None = None,
    lessons: Path | None = None,
    classroom: Classroom | None = None,
    exercise: Path | None = None,
    announce: Callable[[str], object] | None = None,
    entrance: Porter | SideDoor | None = None,
) -> Server:
    """Start serving and return at once.

    Args:
        scene: a shipped scene's name or a scene file.
        host: a name or an address of this machine.
        port: where to listen; 0 takes any free one.
        look: how a new tab begins.
        policy: rules for visitors; by default those of :func:`app.guard.policy.policy_for`.
        lessons: a folder with lessons of one's own, besides the shipped ones.
        classroom: the class that its tabs join; None for tabs that know nothing of each other.
        exercise: a student's file, whose functions are checked whenever it is saved.
        announce: called with the link as soon as there is a page to load.
        entrance: by which connections come in where several processes serve the address; None
            where this one is alone.

    Raises:
        AbiError: the scene or a lesson cannot be read, the host is no address of this machine, or
            another program has the port.
    """
    # a tab may close in the middle of a frame; its session ends right after
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
    # the workers plan in Python: shorter turns let the event loop answer meanwhile
    sys.setswitchinterval(0.0005)
    # a file that may be wrong is read before there is a page
    loaded = None if scene == OPENING else _load(scene)
    lesson_library = _library(lessons)
    server = Server(host, port, look, policy, entrance)
    server.classroom = classroom
    server.exercise = _watch(exercise)
    if announce is not None:
        announce(server.link)
    server.show(scene, loaded or _load(scene), lesson_library)
    return server


def _watch(exercise: Path | None) -> ExerciseWatch | None:
    if exercise is None:
        return None
    from app.teach.exercise_watch import ExerciseWatch

    return ExerciseWatch(exercise)


def _load(name: str) -> Scene:
    from app.reading.local_scene import load_local

    return load_local(name)


def _library(folder: Path | None) -> Library:
    if folder is None:
        return _shipped_lessons
    from app.state.legend import SWITCHES
    from app.teach.lesson_file import library

    return library(folder, {switch.name for switch in SWITCHES})


_reading = threading.Lock()


def _shipped_lessons() -> Lessons:
    """The shipped lessons, read once; tabs that open together wait for the first."""
    with _reading:
        return _read_lessons()


@functools.cache
def _read_lessons() -> Lessons:
    from app.teach.lesson_file import load_lessons

    return load_lessons()
