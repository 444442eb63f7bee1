"""Students' functions in their process: what hangs, takes too much or breaks out does no harm."""

from __future__ import annotations

import contextlib
import math
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import abi.teach
from abi.errors import ArgumentError
from abi.teach.student_process import Limits, run

pytestmark = pytest.mark.slow
_SHORT = Limits(seconds=1.0, patience=600.0)
"""By the clock, that takes a busy machine minutes."""
_IMPATIENT = Limits(patience=4.0)


def _loop(x: float) -> float:
    while True:
        x += 1


def _sleep(x: float) -> None:
    time.sleep(60)


def _much(x: float) -> int:
    return len(bytearray(10**10))


def _exit(x: float) -> None:
    os._exit(0)


def _end(x: float) -> None:
    sys.exit(3)


def _fork(x: float) -> None:
    while True:
        os.fork()


def _start(x: float) -> None:
    subprocess.run(["true"], check=True)


def _ignores(x: float) -> None:
    import signal

    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGXCPU):
        signal.signal(number, signal.SIG_IGN)
    while True:
        try:
            _loop(x)
        except BaseException:
            continue


def _calls_c(x: float) -> float:
    import ctypes

    return float(ctypes.pythonapi.system(b"true"))


def _starts_unheard(x: float) -> float:
    sys.modules.pop("_posixsubprocess")
    import _posixsubprocess

    return float(_posixsubprocess.fork_exec())  # type: ignore[call-arg]


def _floods(x: float) -> str:
    return "x" * 20_000_000


def _recurses(x: float) -> float:
    return 1 + _recurses(x)


def _prints(x: float) -> float:
    print('{"trial": 0, "values": [4.0]}')
    for file in range(1, 9):
        with contextlib.suppress(OSError):
            os.write(file, b'{"trial": 0, "values": [4.0]}\n')
    return x


@pytest.mark.parametrize(
    ("function", "told"),
    [
        (_loop, "took more than"),
        (_ignores, "too much time"),
        (_much, "memory"),
        (_exit, "ended its process"),
        (_end, "ends the program"),
        (_fork, "may not use os.fork"),
        (_start, "may not use subprocess.Popen"),
        (_calls_c, "may not use ctypes"),
        (_starts_unheard, "may not use other programs"),
        (_floods, "returned more than"),
        (_recurses, "RecursionError"),
    ],
)
def test_it_is_told_what_happened(function: Callable[..., Any], told: str) -> None:
    answers = run(function, "f", "alone", [[[1.0]], [[2.0]]], _SHORT)
    assert told in answers.failure
    assert answers.began
    assert answers.values == ()


def test_what_does_nothing_is_not_waited_for() -> None:
    assert "by the clock" in run(_sleep, "f", "alone", [[[1.0]]], _IMPATIENT).failure


def test_it_reaches_no_server_of_this_machine() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]

        def connect(x: float) -> float:
            socket.create_connection(("127.0.0.1", port), timeout=2).close()
            return x

        answers = run(connect, "f", "alone", [[[1.0]]], _SHORT)
        server.setblocking(False)
        with pytest.raises(BlockingIOError):
            server.accept()
    assert "may not use socket" in answers.failure


def test_it_writes_no_file(tmp_path: Path) -> None:
    file = str(tmp_path / "written")

    def write(x: float) -> list[str]:
        import posix
        import sqlite3

        told = []
        ways = (Path.touch, sqlite3.connect, os.mknod, os.mkfifo, posix.mknod, posix.mkfifo)
        for way in ways:
            try:
                way(Path(file) if way is Path.touch else file)  # type: ignore[arg-type]
            except PermissionError as error:
                told.append(str(error))
        return told

    (((*told,),),) = run(write, "f", "alone", [[[1.0]]], _SHORT).values
    assert len(told) == 6
    assert all("an exercise may not use" in one for one in told)
    assert not Path(file).exists()


def test_what_it_prints_is_no_answer() -> None:
    assert run(_prints, "f", "alone", [[[1.0]], [[2.0]]], _SHORT).values == ([1.0], [2.0])


def test_what_was_answered_before_it_failed_counts() -> None:
    answers = run(lambda x: 1 / (2 - x), "f", "alone", [[[1.0]], [[3.0], [2.0]]], _SHORT)
    assert answers.values == ([1.0],)
    assert answers.call == 1
    assert "ZeroDivisionError" in answers.failure


def test_a_file_has_the_function(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text("import math\n\ndef heuristic(node, goal):\n    return math.dist(node, goal)\n")
    verdict = abi.teach.check("heuristic", file)
    assert verdict.passed
    assert verdict.seconds > 0
    file.write_text("def heuristic(node, goal):\n    return 1 / 0\n")
    assert (
        "ZeroDivisionError: division by zero (line 2)"
        in abi.teach.check("heuristic", file).sentence
    )
    file.write_text("def heuristic(node, goal)\n    return 1\n")
    assert "SyntaxError" in abi.teach.check("heuristic", file).sentence
    file.write_text("def another():\n    return 1\n")
    assert "no function heuristic" in abi.teach.check("heuristic", file).sentence
    assert not abi.teach.check("heuristic", file).passed


def test_many_at_once_do_not_hinder_each_other() -> None:
    verdicts: list[abi.teach.ExerciseVerdict] = []
    threads = [
        threading.Thread(target=lambda: verdicts.append(abi.teach.check("heuristic", math.dist)))
        for _ in range(4)
    ]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    assert [one.passed for one in verdicts] == [True] * 4


def test_what_is_no_function_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ArgumentError, match="exercise is 'nothing'"):
        abi.teach.check("nothing", math.dist)
    with pytest.raises(ArgumentError, match="a function"):
        abi.teach.check("heuristic", 3)  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="can be read"):
        abi.teach.check("heuristic", tmp_path / "none.py")
    lock = threading.Lock()
    with pytest.raises(ArgumentError, match="sent to another process"):
        abi.teach.check("heuristic", lambda node, goal: lock.locked())
