"""Runs a student's function in a separate process with limits of time and memory."""

from __future__ import annotations

import contextlib
import inspect
import json
import math
import os
import secrets
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import cloudpickle

from abi.errors import ArgumentError

_ROOT = Path(__file__).resolve().parents[2]
_SINGLE = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
_KEPT = ("HOME", "LANG", "LD_LIBRARY_PATH", "PATH", "SYSTEMROOT", "TEMP", "TMPDIR")
_LARGEST_FILE = 1_000_000
"""Most bytes of a student's file."""
_OUT_OF_TIME = -signal.SIGXCPU if hasattr(signal, "SIGXCPU") else None
"""Exit code of a process that exceeded its processor time."""
_ENDED = "it ended its process, or took too much time or memory"


@dataclass(frozen=True)
class Limits:
    """Limits of a student's function.

    Attributes:
        seconds: of processor time, for all trials together, its start included.
        patience: [s] by the clock, which go by on a busy machine while it does little.
        memory: [bytes], beside what the process itself takes.
        answer: [bytes] of all that it returns, as text.
    """

    seconds: float = 8.0
    patience: float = 30.0
    memory: int = 500_000_000
    answer: int = 8_000_000


@dataclass(frozen=True)
class Answers:
    """What a student's function returned.

    Attributes:
        values: of each trial that it finished, in order, one for each call.
        call: number of the call in the next trial that failed, and why; empty without a failure.
        failure: why it failed, as the rest of a sentence; empty where it did not.
        began: whether the function could be loaded.
    """

    values: tuple[list[Any], ...]
    call: int = 0
    failure: str = ""
    began: bool = True


Student = Callable[..., Any] | str | Path
"""A function, or the file that has it."""


def run(
    student: Student, name: str, caller: str, trials: Sequence[Any], limits: Limits | None = None
) -> Answers:
    """Run a student's function on trials, in a process that is killed at its time limit.

    Args:
        student: the function, or the file that has one of that name.
        name: of the function, in a file.
        caller: in :data:`abi.teach.callers.CALLERS`.
        trials: the calls of each, with their arguments as plain data.
        limits: of time, memory and answers.

    Raises:
        ArgumentError: it is no function, the file cannot be read, or a function cannot be sent.
    """
    limits = limits or Limits()
    word = secrets.token_hex()
    job = json.dumps({**job_of(student, name, caller, trials), "word": word}).encode()
    numbers = (limits.memory, limits.answer, math.ceil(limits.seconds))
    failure = _ENDED
    with tempfile.TemporaryFile() as answers, tempfile.TemporaryDirectory() as folder:
        process = subprocess.Popen(
            [sys.executable, "-m", "abi.teach.student_main", *map(str, numbers)],
            cwd=folder,
            env=_environment(),
            stdin=subprocess.PIPE,
            stdout=answers,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        try:
            process.communicate(job, timeout=limits.patience)
            if process.returncode == _OUT_OF_TIME:
                failure = f"it took more than {limits.seconds:g} s"
        except subprocess.TimeoutExpired:
            failure = f"it took more than {limits.patience:g} s by the clock"
        except OSError:  # it ended before it had read its job
            pass
        finally:
            _end(process)
        answers.seek(0)
        written = answers.read(limits.answer)
    if len(written) == limits.answer:
        failure = f"it returned more than {limits.answer:,} letters"
    own = [line for line in written.splitlines() if line.startswith(word.encode())]
    return read([line[len(word) :] for line in own], len(trials), failure)


def _environment() -> dict[str, str]:
    """Environment of the process, without the server's secrets."""
    paths = [str(_ROOT), *(path for path in sys.path if path)]
    kept = {name: os.environ[name] for name in _KEPT if name in os.environ}
    return {**kept, "PYTHONPATH": os.pathsep.join(paths), **dict.fromkeys(_SINGLE, "1")}


def job_of(student: Student, name: str, caller: str, trials: Sequence[Any]) -> dict[str, Any]:
    """The job as plain data for the process; arguments and errors as for :func:`run`."""
    return {**_sent(student, name), "caller": caller, "trials": list(trials)}


def _sent(student: Student, name: str) -> dict[str, Any]:
    """The student's function in a form that the process can load."""
    if isinstance(student, (str, Path)):
        try:
            with open(student, encoding="utf-8") as file:
                source = file.read(_LARGEST_FILE)
        except (OSError, UnicodeDecodeError) as error:
            raise ArgumentError("file", str(student), "a Python file that can be read") from error
        return {"source": source, "file": str(student), "name": name}
    if not callable(student):
        raise ArgumentError("function", student, "a function, or the name of a file that has it")
    module = inspect.getmodule(student)
    try:
        with _by_value(module):
            return {"pickle": cloudpickle.dumps(student).hex(), "name": name}
    except Exception as error:
        wanted = f"one that can be sent to another process; {type(error).__name__}: {error}"
        raise ArgumentError("function", student, wanted) from None


@contextlib.contextmanager
def _by_value(module: ModuleType | None) -> Iterator[None]:
    """Pickle a module's functions by value, as the process need not find its file."""
    own = module is not None and module.__name__ not in ("__main__", "builtins", "math")
    own = own and getattr(module, "__file__", None) is not None
    if not own or module is None or module.__name__ in cloudpickle.list_registry_pickle_by_value():
        yield
        return
    cloudpickle.register_pickle_by_value(module)
    try:
        yield
    finally:
        cloudpickle.unregister_pickle_by_value(module)


def _end(process: subprocess.Popen[bytes]) -> None:
    """Kill the process and its children, also those that it has left behind."""
    with contextlib.suppress(OSError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
    process.kill()
    process.wait()


def read(lines: Iterable[bytes], trials: int, failure: str = _ENDED) -> Answers:
    """Parse the answers in the process's output, whose last line may be truncated.

    Args:
        lines: each one answer as JSON.
        trials: number of trials that it was to answer.
        failure: why it did not answer them all, where it does not say that itself.
    """
    values: list[list[Any]] = []
    began = False
    for line in lines:
        try:
            data = json.loads(line)
        except ValueError:
            break
        if "error" in data:
            return Answers(tuple(values), data.get("call", 0), data["error"], data["trial"] >= 0)
        if data["trial"] >= 0:
            values.append(data["values"])
        began = True
    if len(values) == trials:
        return Answers(tuple(values))
    return Answers(tuple(values), 0, failure, began)
