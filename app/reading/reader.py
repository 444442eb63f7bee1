"""Reads files from outside in a separate process, so that a crash or a hang does no harm.

The process is started with the first file or before, kept for the next one, and replaced if it has
ended.
"""

from __future__ import annotations

import atexit
import json
import logging
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

import msgspec
import numpy as np

from abi.arrays import FloatArray
from abi.certification.motion import Motion
from abi.errors import AbiError, SceneError
from abi.obstacles.triangle_mesh.surface import Surface
from abi.progress import CancelledError
from abi.robot.urdf.robot import Robot
from app.process.available_memory import memory_in_all
from app.reading import running_reader
from app.reading.reading import ReadingRequest, ReadingResult
from app.reading.running_reader import AT_ONCE, RunningReader, reading_memory

_log = logging.getLogger(__name__)
_LOOK = 0.05
"""Seconds between two checks whether a file is still wanted."""
_LONG = 2.0
"""Seconds after which a caller is told that it waits for other files."""

Stopped = threading.Event
"""Event that is set when a file is not wanted any more."""
Delayed = Callable[[], object]
"""Callback for a long wait for the files of others."""


def _ignore() -> None:
    """Default callback for a long wait: does nothing."""


class Reader:
    """Reads files from outside with a pool of processes, in the order in which they come.

    Who has several files read gives one after the other, so that nobody waits for more than one
    further file of each of the others.

    Attributes:
        lost: exit codes of processes that ended over a file; below 0 the signal that ended it.
        faults: errors in readers that are none of a file.
        memory: [bytes] for a file, beside what a process itself takes.
        open_files: most that may be open at once; what is open when reading begins stays so.
        seconds: of processor time for a file.
        patience: seconds that anybody waits for a file, and for others to be read before.
    """

    def __init__(
        self,
        memory: int | None = None,
        open_files: int = 0,
        seconds: int = 20,
        patience: float = 90.0,
    ) -> None:
        """Begin without a process; by default half of the machine's memory is left to others."""
        self.lost: list[int] = []
        self.faults: list[str] = []
        self.memory = reading_memory(memory_in_all()) if memory is None else memory
        self.open_files, self.seconds, self.patience = open_files, seconds, patience
        self._idle: list[RunningReader] = []
        self._lock = threading.Lock()
        self._line: list[threading.Event] = []  # one a file; set for those that may be read
        atexit.register(self.close)

    def warm(self) -> None:
        """Start a process if none is idle, since starting one takes seconds."""
        with self._lock:
            if not self._idle:
                self._idle.append(self._start())

    def mesh(
        self, content: bytes, name: str, stopped: Stopped | None = None, delayed: Delayed = _ignore
    ) -> Surface:
        """The repaired surface of a mesh file.

        Args:
            content: of the file.
            name: of the file.
            stopped: set when it is not wanted any more.
            delayed: called if it waits.

        Raises:
            SceneError: it is refused, or took too long or too much.
            CancelledError: ``stopped`` was set.
        """
        return self.read(ReadingRequest("mesh", name, content), stopped, delayed).surfaces[name]

    def arm(
        self, content: bytes, name: str, stopped: Stopped | None = None, delayed: Delayed = _ignore
    ) -> Robot:
        """The arm of a URDF, or of a zip with one and its meshes; arguments as for :meth:`mesh`.

        ``ROBOTS.zip/URDF`` as name is that one of the URDF files of the zip.

        Raises:
            AbiError: it is a zip with several URDF files, and none is named; has their names.
            SceneError: it is refused, or took too long or too much.
            CancelledError: ``stopped`` was set.
        """
        return self.read(ReadingRequest("arm", name, content), stopped, delayed).robots[name]

    def scene(
        self, content: bytes, name: str, stopped: Stopped | None = None, delayed: Delayed = _ignore
    ) -> tuple[object, Mapping[str, Robot | Surface]]:
        """Plain data of a scene file, and the meshes and robots packed with it, by name.

        Arguments are those of :meth:`mesh`.

        Raises:
            SceneError: it is refused, or took too long or too much.
            CancelledError: ``stopped`` was set.
        """
        answer = self.read(ReadingRequest("scene", name, content), stopped, delayed)
        return json.loads(answer.data), {**answer.robots, **answer.surfaces}

    def motion(
        self,
        content: bytes,
        name: str,
        slides: dict[str, bool],
        topic: str | None = None,
        stopped: Stopped | None = None,
        delayed: Delayed = _ignore,
    ) -> Motion:
        """The motion of a file; ``slides`` tells for each of the robot's joints whether it slides.

        ``topic`` is that of a trajectory in a bag. The other arguments are those of :meth:`mesh`.

        Raises:
            AbiError: what it holds is no motion; names row, joint and unit. Or it is a bag with
                several, and none is named; has their topics.
            SceneError: it took too long or too much.
            CancelledError: ``stopped`` was set.
        """
        answer = self.read(ReadingRequest("motion", name, content, slides, topic), stopped, delayed)
        return msgspec.convert(json.loads(answer.data), Motion, dec_hook=_array)

    def read(
        self, request: ReadingRequest, stopped: Stopped | None = None, delayed: Delayed = _ignore
    ) -> ReadingResult:
        """Successful answer to a request; arguments as for :meth:`mesh`.

        Raises:
            SceneError: it is refused, or took too long or too much.
            AbiError: it is to be a motion, and is none; or it has several robots or trajectories,
                and none is named: it has their names.
            CancelledError: ``stopped`` was set.
        """
        stopped = stopped or threading.Event()
        with self._place(request, stopped, delayed):
            answer, seconds = self._answer(request, stopped)
        if stopped.is_set():
            raise CancelledError
        if answer is None:
            _log.warning("reader lost: %s %r after %.1f s", request.kind, request.name, seconds)
            raise SceneError("file", request.name, "a file that takes less time and memory to read")
        if answer.fault:
            self.faults.append(answer.fault)
            _log.warning("reader fault: %s %r: %s", request.kind, request.name, answer.fault)
        if answer.refusal is not None:
            raise SceneError(*answer.refusal)
        if answer.wrong is not None:
            raise AbiError(*answer.wrong, answer.choices)
        return answer

    def close(self) -> None:
        """End the processes; the next file starts a new one."""
        with self._lock:
            idle, self._idle = self._idle, []
        for process in idle:
            process.kill()  # which has nothing to finish, and may be loading still
            running_reader.closed(process)

    @contextmanager
    def _place(self, request: ReadingRequest, stopped: Stopped, delayed: Delayed) -> Iterator[None]:
        """Wait until fewer than ``AT_ONCE`` files that came before are left, if it is wanted."""
        turn = threading.Event()
        with self._lock:
            self._line.append(turn)
            self._call()
        try:
            self._wait(turn, request, stopped, delayed)
            yield
        finally:
            with self._lock:
                self._line.remove(turn)
                self._call()

    def _call(self) -> None:
        for turn in self._line[:AT_ONCE]:
            turn.set()

    def _wait(
        self, turn: threading.Event, request: ReadingRequest, stopped: Stopped, delayed: Delayed
    ) -> None:
        """Wait for a turn while the file is wanted."""
        begin, is_told = time.monotonic(), False
        while not stopped.is_set():
            if turn.wait(_LOOK):
                return
            seconds = time.monotonic() - begin
            if seconds > self.patience:
                _log.warning(
                    "reader busy: %s %r waited %.0f s", request.kind, request.name, seconds
                )
                expected = "a moment in which the server reads fewer files; add it again then"
                raise SceneError("file", request.name, expected)
            if not is_told and seconds > _LONG:
                is_told = True
                _log.info("reader busy: %s %r waits", request.kind, request.name)
                delayed()
        raise CancelledError

    def _start(self) -> RunningReader:
        return running_reader.started(self.memory, self.open_files, self.seconds)

    def _answer(
        self, request: ReadingRequest, stopped: Stopped
    ) -> tuple[ReadingResult | None, float]:
        """Answer of a process, None if it ended, and the seconds that it took."""
        with self._lock:
            process = self._idle.pop() if self._idle else self._start()
        done = threading.Event()
        watch = threading.Thread(target=self._watch, args=(process, done, stopped), daemon=True)
        begin = time.monotonic()
        watch.start()
        try:
            answer = running_reader.answer_of(process, request)
        finally:
            done.set()
            watch.join()
        if answer is None:
            code = running_reader.closed(process)
            if not stopped.is_set():
                self.lost.append(code)
        else:
            with self._lock:
                self._idle.append(process)
        return answer, time.monotonic() - begin

    def _watch(
        self, process: RunningReader, done: threading.Event, stopped: threading.Event
    ) -> None:
        """Kill a process that takes too long or whose file is not wanted any more."""
        end = time.monotonic() + self.patience
        while not done.wait(_LOOK):
            if stopped.is_set() or time.monotonic() > end:
                process.kill()
                return


def _array(_kind: type, numbers: list[object]) -> FloatArray:
    return np.array(numbers, dtype=float)


READER = Reader()
"""The reader of this server."""
