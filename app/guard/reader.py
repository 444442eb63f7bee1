"""Reader of files from outside, in a separate process, so that a crash or a hang does no harm.

The process is started with the first file or before, kept for the next one, and replaced if it has
ended.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import logging
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import BinaryIO, NamedTuple

import msgspec

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.obstacles.triangle_mesh.surface import Surface
from abi.robot.robot import Robot
from abi.robot.robot_files import load_robot
from app.guard.process_memory import memory_in_all
from app.guard.reader_process import READY, receive, send
from app.guard.reading import Answer, Job
from app.guard.reading_places import ReadingPlaces, Ticket

_log = logging.getLogger(__name__)
_ROOT = Path(__file__).resolve().parents[2]
_PROCESSES = 2
"""Files that are read at once, at most; others wait."""
_MOST_MEMORY = 2_000_000_000
_LOOK = 0.05
"""Seconds between two looks at whether a file is still wanted."""
_LONG = 2.0
"""Seconds after which whoever waits for a place is told so."""
_GRACE = 0.5
"""Seconds for a process to end by itself."""
_SINGLE = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS")


def reading_memory(memory: int | None) -> int:
    """Bytes that one file may take, so that those read at once leave half of all to the server.

    Args:
        memory: [bytes] of the machine or the container; None where nobody tells.
    """
    return _MOST_MEMORY if memory is None else min(_MOST_MEMORY, memory // (2 * _PROCESSES))


class Limits(NamedTuple):
    """Limits of the process that reads a file.

    Attributes:
        memory: [bytes], beside what the process itself takes.
        files: that may be open at once; what is open when reading begins stays so.
        seconds: of processor time.
        patience: seconds that anybody waits for it, and for a place before.
    """

    memory: int = reading_memory(memory_in_all())
    files: int = 0
    seconds: int = 20
    patience: float = 90.0


class StoppedError(Exception):
    """Raised where a file is not wanted any more."""


class _Process:
    """A running reader process."""

    def __init__(self, limits: Limits) -> None:
        paths = [str(_ROOT), os.environ.get("PYTHONPATH", "")]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
        environment |= dict.fromkeys(_SINGLE, "1")
        numbers = map(str, (limits.memory, limits.files, limits.seconds))
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "app.guard.reader_process", *numbers],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._jobs: BinaryIO = self._process.stdin  # type: ignore[assignment]
        self._answers: BinaryIO = self._process.stdout  # type: ignore[assignment]
        self._ready = False

    def read(self, job: Job) -> Answer | None:
        """The answer to a job; None where the process ended."""
        try:
            if not self._ready:
                self._ready = receive(self._answers) == READY
            send(self._jobs, msgspec.msgpack.encode(job))
            content = receive(self._answers)
        except OSError:
            return None
        return None if content is None else msgspec.msgpack.decode(content, type=Answer)

    def kill(self) -> None:
        """End it at once."""
        self._process.kill()

    def close(self) -> int:
        """End it and free what it held; its exit code."""
        with contextlib.suppress(OSError):  # what was still to be written
            self._jobs.close()
        if not self._ready:  # it would go on loading first
            self._process.kill()
        try:
            self._process.wait(_GRACE)
        except subprocess.TimeoutExpired:
            self._process.kill()
        self._answers.close()
        return self._process.wait()


class Reader:
    """Reader of files from outside.

    Attributes:
        lost: exit codes of processes that ended over a file; below 0 the signal that ended it.
        faults: errors in readers that are none of a file.
    """

    def __init__(self, limits: Limits | None = None) -> None:
        self.limits = limits or Limits()
        self.lost: list[int] = []
        self.faults: list[str] = []
        self._idle: list[_Process] = []
        self._lock = threading.Lock()
        self._places = ReadingPlaces(_PROCESSES)
        atexit.register(self.close)

    def warm(self) -> None:
        """Start a process if none is idle: the first file need not wait seconds for it then."""
        with self._lock:
            if not self._idle:
                self._idle.append(_Process(self.limits))

    def mesh(
        self,
        content: bytes,
        name: str,
        stopped: threading.Event | None = None,
        delayed: Callable[[], object] = lambda: None,
    ) -> Surface:
        """The repaired surface of a mesh file.

        Args:
            content: of the file.
            name: of the file.
            stopped: set when it is not wanted any more; files with the same one are read one after
                the other.
            delayed: called once if files of others keep it waiting for long.

        Raises:
            SceneError: it is refused, or took too long or too much.
            StoppedError: ``stopped`` was set.
        """
        return self.read(Job("mesh", name, content), stopped, delayed).surfaces[name].surface()

    def arm(
        self,
        content: bytes,
        name: str,
        stopped: threading.Event | None = None,
        delayed: Callable[[], object] = lambda: None,
    ) -> Robot:
        """The arm of a URDF, or of a zip with one and its meshes; arguments as for :meth:`mesh`.

        Raises:
            SceneError: it is refused, or took too long or too much.
            StoppedError: ``stopped`` was set.
        """
        archive = self.read(Job("arm", name, content), stopped, delayed).archives[name]
        return load_robot(name, MeshSource({name: archive}))

    def scene(
        self,
        content: bytes,
        name: str,
        stopped: threading.Event | None = None,
        delayed: Callable[[], object] = lambda: None,
    ) -> tuple[object, Mapping[str, bytes | Surface]]:
        """Plain data of a scene file, and the files that came with it, by name.

        Arguments are those of :meth:`mesh`.

        Raises:
            SceneError: it is refused, or took too long or too much.
            StoppedError: ``stopped`` was set.
        """
        answer = self.read(Job("scene", name, content), stopped, delayed)
        surfaces = {file: one.surface() for file, one in answer.surfaces.items()}
        return json.loads(answer.data), {**answer.archives, **surfaces}

    def read(
        self,
        job: Job,
        stopped: threading.Event | None = None,
        delayed: Callable[[], object] = lambda: None,
    ) -> Answer:
        """The answer to a job that is no refusal; arguments as for :meth:`mesh`.

        Raises:
            SceneError: it is refused, or took too long or too much.
            StoppedError: ``stopped`` was set.
        """
        stopped = stopped or threading.Event()
        ticket = self._places.queue(stopped)
        try:
            self._wait(ticket, job, stopped, delayed)
            answer, seconds = self._answer(job, stopped)
        finally:
            self._places.give_back(ticket)
        if stopped.is_set():
            raise StoppedError
        if answer is None:
            _log.warning("reader lost: %s %r after %.1f s", job.kind, job.name, seconds)
            raise SceneError("file", job.name, "a file that takes less time and memory to read")
        if answer.fault:
            self.faults.append(answer.fault)
            _log.warning("reader fault: %s %r: %s", job.kind, job.name, answer.fault)
        if answer.refusal is not None:
            refusal = answer.refusal
            raise SceneError(refusal.field, refusal.value, refusal.expected)
        return answer

    def close(self) -> None:
        """End the processes; the next file starts one anew."""
        with self._lock:
            idle, self._idle = self._idle, []
        for process in idle:
            process.close()

    def _wait(
        self, ticket: Ticket, job: Job, stopped: threading.Event, delayed: Callable[[], object]
    ) -> None:
        """Wait for a place, no longer than the file is wanted."""
        begin, is_told = time.monotonic(), False
        while not stopped.is_set():
            if self._places.wait(ticket, _LOOK):
                return
            seconds = time.monotonic() - begin
            if seconds > self.limits.patience:
                _log.warning("reader busy: %s %r waited %.0f s", job.kind, job.name, seconds)
                expected = "a moment in which the server reads fewer files; add it again then"
                raise SceneError("file", job.name, expected)
            if not is_told and seconds > _LONG:
                is_told = True
                _log.info("reader busy: %s %r waits", job.kind, job.name)
                delayed()
        raise StoppedError

    def _answer(self, job: Job, stopped: threading.Event) -> tuple[Answer | None, float]:
        """Answer of a process, None where it ended; and the seconds that it took."""
        with self._lock:
            process = self._idle.pop() if self._idle else _Process(self.limits)
        done = threading.Event()
        watch = threading.Thread(target=self._watch, args=(process, done, stopped), daemon=True)
        begin = time.monotonic()
        watch.start()
        try:
            answer = process.read(job)
        finally:
            done.set()
            watch.join()
        if answer is None:
            code = process.close()
            if not stopped.is_set():
                self.lost.append(code)
        else:
            with self._lock:
                self._idle.append(process)
        return answer, time.monotonic() - begin

    def _watch(self, process: _Process, done: threading.Event, stopped: threading.Event) -> None:
        """End a process that takes too long, or whose file is not wanted."""
        end = time.monotonic() + self.limits.patience
        while not done.wait(_LOOK):
            if stopped.is_set() or time.monotonic() > end:
                process.kill()
                return


READER = Reader()
"""The server's."""
