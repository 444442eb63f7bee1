"""The process that runs a student's function: it may not write, start programs or use a network.

:mod:`abi.teach.student_process` starts it. It imports nothing of the package but the programs that
call the function, so that it is ready at once. The limits keep mistakes from doing harm and cheap
mischief from succeeding; they are no wall against somebody who wants to break out.
"""

from __future__ import annotations

import contextlib
import importlib
import itertools
import json
import os
import pickle
import sys
import traceback
from collections.abc import Callable, Iterator
from types import CodeType
from typing import Any, TextIO

from abi.teach.callers import CALLERS

_REFUSED = frozenset(
    {
        "ctypes.call_function",
        "ctypes.dlopen",
        "ctypes.dlsym",
        "ctypes.dlsym/handle",
        "os.chmod",
        "os.chown",
        "os.exec",
        "os.fork",
        "os.forkpty",
        "os.kill",
    }
    | {"os.killpg", "os.link", "os.mkdir", "os.posix_spawn", "os.remove", "os.rename", "os.rmdir"}
    | {"os.spawn", "os.startfile", "os.symlink", "os.system", "os.truncate", "os.utime"}
    | {"shutil.rmtree", "signal.pthread_kill", "sqlite3.connect", "subprocess.Popen"}
    | {"winreg.CreateKey"}
)
"""Audit events that no exercise needs."""
_UNHEARD = "mkfifo", "mknod"
"""Functions of ``os`` that make files without an audit event."""
_STARTER = "_posixsubprocess"
"""A part of :mod:`subprocess` that starts programs without an audit event."""
_NETWORK = "socket."
_WRITTEN = "files to write to"
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_NEW_USER_AND_NETWORK = 0x10000000 | 0x40000000  # CLONE_NEWUSER, CLONE_NEWNET


def main() -> None:
    """Run the job from standard input, and print one line of answer for each call.

    Each line begins with the job's word, which no function is told: what else it writes is none.
    The command line has the limits: memory in bytes, bytes of the answers, and processor time in
    seconds.
    """
    memory, answer, seconds = map(int, sys.argv[1:])
    job = json.loads(sys.stdin.buffer.read())
    word = job.pop("word")
    # what the student prints must not stand among the answers
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    silence = os.open(os.devnull, os.O_RDWR)
    for standard in (0, 1, 2):
        os.dup2(silence, standard)
    import ctypes  # so that libraries which import it can, too

    import numpy  # noqa: F401  # before its many files count

    _leave_the_network(ctypes)
    _restrict(memory, answer, seconds)
    with contextlib.suppress(ImportError):
        import subprocess

        setattr(importlib.import_module(_STARTER), "fork_exec", _start_no_program)  # noqa: B010
        setattr(subprocess, "_fork_exec", _start_no_program)  # noqa: B010
    sys.addaudithook(_refuse)
    for module, name in itertools.product((os, sys.modules[os.name]), _UNHEARD):
        if hasattr(module, name):
            setattr(module, name, _make_no_file)
    for answer_line in answers_of(job):
        _write(answers, word, answer_line)


def answers_of(job: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """The answers of a job, one for each trial, until one fails."""
    try:
        function = _function(job)
    except BaseException as error:
        yield {"trial": -1, "error": _told(error, job.get("file", ""))}
        return
    code = getattr(function, "__code__", None)
    file = code.co_filename if isinstance(code, CodeType) else job.get("file", "")
    yield {"trial": -1, "ready": True}
    call = CALLERS[job["caller"]]
    for number, trial in enumerate(job["trials"]):
        values: list[Any] = []
        try:
            for arguments in trial:
                values.append(_plain(call(function, arguments)))
        except BaseException as error:
            yield {"trial": number, "call": len(values), "error": _told(error, file)}
            return
        yield {"trial": number, "values": values}


def _function(job: dict[str, Any]) -> Callable[..., Any]:
    """Load the student's function from a pickle or from a file's text."""
    if "pickle" in job:
        function = pickle.loads(bytes.fromhex(job["pickle"]))
    else:
        names: dict[str, Any] = {"__name__": "exercise", "__file__": job["file"]}
        exec(compile(job["source"], job["file"], "exec"), names)
        if job["name"] not in names:
            raise NameError(f"the file has no function {job['name']}")
        function = names[job["name"]]
    if not callable(function):
        raise TypeError(f"{job['name']} is no function")
    return function  # type: ignore[no-any-return]


def _plain(value: Any) -> Any:
    """Convert a value for JSON: numpy's numbers and arrays to Python's."""
    if isinstance(value, int) and abs(value) > sys.float_info.max:
        raise OverflowError("it returns a whole number that no float can hold")
    if isinstance(value, (bool, int, float, str)) or value is None:
        return value
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(part) for part in value]
    if isinstance(value, dict):
        return {str(key): _plain(part) for key, part in value.items()}
    raise TypeError(f"it returns a {type(value).__name__}, not numbers")


def _told(error: BaseException, file: str) -> str:
    """The error in one line, with the line of the student's code that raised it."""
    place = ""
    with contextlib.suppress(Exception):
        own = [frame for frame in traceback.extract_tb(error.__traceback__) if _is_in(frame, file)]
        number = own[-1].lineno if own else getattr(error, "lineno", None)
        place = f" (line {number})" if number is not None else ""
    if isinstance(error, MemoryError):
        return f"it needs more memory than it may have{place}"
    if isinstance(error, SystemExit):
        return f"it ends the program{place}"
    text = str(error).splitlines()[0][:200] if str(error) else ""
    return f"{type(error).__name__}{': ' if text else ''}{text}{place}"


def _is_in(frame: traceback.FrameSummary, file: str) -> bool:
    return frame.filename == file


def _write(answers: TextIO, word: str, line: dict[str, Any]) -> None:
    answers.write(f"{word}{json.dumps(line)}\n")
    answers.flush()


def _leave_the_network(ctypes: Any) -> None:
    """Move to an isolated network namespace, if Linux allows that to any user."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).unshare(_NEW_USER_AND_NETWORK)


def _restrict(memory: int, answer: int, seconds: int) -> None:
    """Limit memory to ``memory`` more bytes, answers to ``answer`` bytes, and time to ``seconds``.

    Whoever ignores the signal at the end of the time is ended a second later. Where the system has
    no such limits, as Windows, whoever waits still limits the time.
    """
    with contextlib.suppress(ImportError):
        import resource

        with contextlib.suppress(OSError), open("/proc/self/oom_score_adj", "w") as score:
            score.write("1000")
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (answer, answer))
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
        with contextlib.suppress(OSError), open("/proc/self/statm") as statm:
            most = memory + int(statm.read().split()[0]) * resource.getpagesize()
            resource.setrlimit(resource.RLIMIT_AS, (most, most))


def _refuse(event: str, arguments: tuple[Any, ...]) -> None:
    """Audit hook that refuses what no exercise needs."""
    if event == "open":
        _, mode, flags = arguments
        writes = isinstance(mode, str) and any(letter in mode for letter in "wax+")
        if not writes and not (isinstance(flags, int) and flags & _WRITING):
            return
    elif event == "import" and arguments[0] == _STARTER:  # anew, without what was changed in it
        _start_no_program()
    elif event not in _REFUSED and not event.startswith(_NETWORK):
        return
    raise PermissionError(f"an exercise may not use {_WRITTEN if event == 'open' else event}")


def _make_no_file(*_: Any, **__: Any) -> None:
    raise PermissionError(f"an exercise may not use {_WRITTEN}")


def _start_no_program(*_: Any, **__: Any) -> None:
    raise PermissionError("an exercise may not use other programs")


if __name__ == "__main__":
    main()
