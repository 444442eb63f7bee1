"""Compilation of all kernels in the background, cached from one run to the next.

Kernels that an earlier run has cached are loaded, which takes about a second. The others are
compiled in separate processes, so that neither plans nor the end of the program have to wait, and
are loaded one by one as they are ready. First come those that plans spend most time in. These are
compiled for the next program even if this one ends.
"""

from __future__ import annotations

import atexit
import importlib
import itertools
import logging
import math
import os
import pkgutil
import subprocess
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from abi import compiler_process, progress
from abi.compilation.kernel_folder import is_anything_kept, kernel_folder
from abi.compiled import KERNELS, LOADING, Kernel, is_off
from abi.errors import AbiError

_log = logging.getLogger(__name__)

_PACKAGE = Path(__file__).resolve().parent

_PROCESSORS = (
    len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
)
"""Number of processors that this process may use."""

_GRACE = 0.2
"""Seconds before the first kernel is loaded: a program of one plan ends without waiting for it."""

_PATIENCE = 0.1
"""Seconds that a plan waits for kernels to be loaded even if they have hardly run as Python."""

_WORTH_WAITING = 2.0
"""Part of the time in Python that a plan waits for kernels to be loaded: beside the thread that
loads them, Python takes about that much longer.
"""

_BEARABLE = 0.2
"""Seconds in Python, of all plans of several threads, after which these wait for kept kernels."""

_LONGEST = 10.0
"""Seconds after which they do not wait any longer."""

_WORTHWHILE = 1.0
"""Seconds in Python after which the kernels that took them are compiled though the program ends."""

_MOST_PROCESSES = 4
"""Processes that compile: each takes a quarter of a gigabyte, and more are hardly faster."""

_UNASKED_PROCESSES = 2
"""Processes that compile, at most, where nobody has asked for more."""


_TOLD = 2.0
"""Seconds between two sentences on how far the compilation is."""
_SURE = 0.1
"""Share of the kernels from which the time that is left can be told."""
_MINUTES = 90.0
"""Seconds from which a time is told in minutes."""


class _Compilation:
    """The one background compilation of a process.

    Attributes:
        loaded: set once the kernels that plans have called are loaded, as far as an earlier run has
            kept them; all kernels where none has been called.
        kept: set once all kernels are loaded that an earlier run has kept.
        done: set once all kernels run compiled that can.
        wanted: set once somebody waits for what plans have called, or the process ends.
        awaited: set once somebody waits for all that were kept, or the process ends.
        spare: processors on which it works only as long as nobody else does; as many as there are
            but one, unless whoever waits for it says so.
    """

    def __init__(self) -> None:
        self.loaded = threading.Event()
        self.kept = threading.Event()
        self.done = threading.Event()
        self.wanted = threading.Event()
        self.awaited = threading.Event()
        self.spare = _PROCESSORS - 1
        self._thread: threading.Thread | None = None
        self._missing: tuple[Kernel[..., Any], ...] = ()
        self._waiting: list[Kernel[..., Any]] = []
        self._children: list[subprocess.Popen[str]] = []
        self._begun = 0.0
        self._lock = threading.Lock()
        self._ending = False

    def begin(self) -> None:
        """Start the thread, once."""
        if self._thread is not None:
            return
        with self._lock:
            if self._thread is None and not self._ending:
                self._thread = threading.Thread(target=self._work, name="compilation", daemon=True)
                self._thread.start()

    def end(self) -> None:
        """Load nothing from now on; takes as long as the kernel that is being loaded.

        A thread inside the compiler's library when the process ends could crash it. Other processes
        end by themselves, once they have cached what they compile: the next run will find it.
        """
        self._ending = True
        self.wanted.set()
        self.awaited.set()
        self._leave_the_rest()
        LOADING.acquire()  # and never released

    def _leave_the_rest(self) -> None:
        """Have other processes compile what this one has run as Python, if that took it long."""
        with self._lock:
            needed = [kernel for kernel in self._waiting if kernel.need]
            if not self._children or sum(kernel.need for kernel in needed) < _WORTHWHILE:
                return
            needed.sort(key=_urgency, reverse=True)
            for kernel, child in zip(needed, itertools.cycle(self._children), strict=False):
                with suppress(OSError, ValueError):  # it has ended
                    print(kernel.name, file=child.stdin, flush=True)

    def share_done(self) -> float | None:
        """Part of what no earlier run has cached that is compiled by now, from 0 to 1.

        None while nothing is being compiled.
        """
        if not self._missing or self.done.is_set():
            return None
        done = sum(kernel.size for kernel in self._missing if kernel.compiled)
        return done / sum(kernel.size for kernel in self._missing)

    def time_left(self) -> str:
        """The time until all is compiled, in words; empty while that cannot be told."""
        return _time_left(self.share_done(), time.monotonic() - self._begun)

    def _work(self) -> None:
        self.wanted.wait(_GRACE)
        try:
            if self._ending or is_off():
                return
            missing = self._load_what_is_kept() if is_anything_kept() else all_kernels()
            self.loaded.set()
            self.kept.set()
            if not missing:
                return
            self._missing, self._begun = tuple(missing), time.monotonic()
            if kernel_folder() is not None:
                self._from_children(missing)
            for kernel in missing:
                # where nothing can be kept, or no process started
                if not self._ending:
                    kernel.compile()
        except Exception:
            _log.exception("kernels stay uncompiled")
        finally:
            self.loaded.set()
            self.kept.set()
            self.done.set()

    def _load_what_is_kept(self) -> list[Kernel[..., Any]]:
        """Load the kernels that an earlier run has kept, and return the others."""
        # what the next plan is likely to call does not wait for the rest
        needed = [kernel for kernel in KERNELS.values() if kernel.need]
        loaded = [self._load(kernel) for kernel in needed]
        if needed and all(loaded):
            self.loaded.set()
        return [kernel for kernel in all_kernels() if not self._load_by_the_way(kernel)]

    def _load(self, kernel: Kernel[..., Any]) -> bool:
        """Load a kernel if it was kept."""
        if not kernel.compiled and not self._ending and kernel.cached:
            kernel.compile()
        return kernel.compiled

    def _load_by_the_way(self, kernel: Kernel[..., Any]) -> bool:
        """Load a kernel if it was kept, and leave plans as much time as that took.

        A plan's thread waits for this one, which is busy with Python, after each of its kernels.
        """
        begin = time.perf_counter()
        loaded = self._load(kernel)
        if self.loaded.is_set():  # else plans may wait for it
            self.awaited.wait(time.perf_counter() - begin)
        return loaded

    def _from_children(self, missing: list[Kernel[..., Any]]) -> None:
        """Let other processes compile missing kernels, and load each when it is cached."""
        undisturbed = max(_PROCESSORS - self.spare, 1)
        count = min(max(undisturbed, _UNASKED_PROCESSES), _PROCESSORS, _MOST_PROCESSES)
        self._waiting = list(missing)
        events = [threading.Event() for _ in missing]
        for kernel, event in zip(missing, events, strict=True):
            kernel.elsewhere = event
        threads = []
        for k in range(min(count, len(missing))):
            child = compiler_process.start(k >= undisturbed)
            if child is None:
                break
            with self._lock:
                self._children.append(child)
            # the first is told before the second: what a plan waits for does not give way
            first = None
            with suppress(BrokenPipeError):  # it has ended
                first = self._tell_next(child)
            threads.append(threading.Thread(target=self._from, args=(child, first), daemon=True))
            threads[-1].start()
        for thread in threads:
            thread.join()
        for event in events:  # of what no process has come to
            event.set()

    def _from(self, child: subprocess.Popen[str], kernel: Kernel[..., Any] | None) -> None:
        """Let a process compile the kernel that it was told, and others until none is left."""
        assert child.stdout is not None
        # a killed child breaks the pipe twice: what it was not told is written again at the end
        with suppress(BrokenPipeError), child:
            while kernel is not None:
                try:
                    if child.stdout.readline().strip() != kernel.name:
                        return
                finally:
                    _let_be(kernel)
                if not self._load(kernel):  # it could not be cached, nor could others
                    return
                kernel = self._tell_next(child)

    def _tell_next(self, child: subprocess.Popen[str]) -> Kernel[..., Any] | None:
        """Tell a process the kernel that comes next; None if none is left or this process ends."""
        with self._lock:
            if self._ending or not self._waiting:
                return None
            # neighbours share helpers, which each process compiles: they begin at both ends
            is_second = child in self._children[1::2]
            waiting = self._waiting[::-1] if is_second else self._waiting
            # the one that is waited for, is foreseen, or has run longest as Python for its size
            kernel = max(waiting, key=_urgency)
            self._waiting.remove(kernel)
            try:
                print(kernel.name, file=child.stdin, flush=True)
            except BrokenPipeError:
                _let_be(kernel)
                raise
            return kernel


def _let_be(kernel: Kernel[..., Any]) -> None:
    """Let nobody wait any longer for the process that was to compile a kernel."""
    assert kernel.elsewhere is not None
    kernel.elsewhere.set()


def _urgency(kernel: Kernel[..., Any]) -> tuple[bool, int, float]:
    """Whether a call waits for a kernel; its rank; and its time as Python, beside its size."""
    return kernel.need == math.inf, kernel.foreseen, kernel.need / kernel.size


def _time_left(share: float | None, spent: float) -> str:
    """Words for the time that is left after some time [s] has led to a share of the work."""
    if share is None or share < _SURE:
        return ""
    left = spent * (1 / share - 1)
    if left > _MINUTES:
        return f"{left / 60:.0f} minutes"
    return f"{max(math.ceil(left / 10), 1) * 10} s"


_compilation = _Compilation()


def all_kernels() -> list[Kernel[..., Any]]:
    """Import all modules with kernels and return every kernel."""
    for module in pkgutil.walk_packages([str(_PACKAGE)], "abi."):
        if module.name.endswith("_kernels"):
            with LOADING:
                importlib.import_module(module.name)
    return list(KERNELS.values())


def compile(spare: int = 0) -> None:
    """Compile all inner loops and wait until that is done.

    It takes about a second if an earlier run has cached them, otherwise one minute or a few. Plans
    do not need it: from the first plan on the inner loops are compiled in the background, and until
    they are ready they run as plain Python, with the same results.

    Args:
        spare: number of processors to use only as long as other programs do not need them.

    Raises:
        AbiError: ``spare`` is no such number.
    """
    if not isinstance(spare, int) or spare < 0:
        raise AbiError(f"spare is {spare!r}; expected a whole number of processors, at least 0.")
    begin(spare)
    while not is_done():
        progress.tell(_words(share_done(), time_left()))
        progress.wait(_compilation.done, _TOLD)


def _words(share: float | None, left: str) -> str:
    """What is told of the compilation while somebody waits for it."""
    words = "compiling the program, once on this machine"
    return f"{words}: {share:.0%} done, about {left} left" if left else words


def begin(spare: int | None = None) -> None:
    """Start compiling in the background, once; at once if ``spare`` says who is waiting for it."""
    if spare is not None:
        _compilation.spare = spare
    _compilation.begin()
    if spare is not None:
        _compilation.awaited.set()
        _compilation.wanted.set()


def foresee(kernels: Sequence[Kernel[..., Any]]) -> None:
    """Start compiling in the background, at once, with what a plan will run for long, in order."""
    for rank, kernel in enumerate(reversed(kernels), start=1):
        kernel.foreseen = rank
    begin()
    _compilation.wanted.set()


def wait(timeout: float) -> bool:
    """Wait until all kernels run compiled, but at most ``timeout`` [s]; whether they do."""
    return _compilation.done.wait(timeout)


def share_done() -> float | None:
    """Part of what is to be compiled that is, from 0 to 1; None while nothing is being compiled."""
    return _compilation.share_done()


def time_left() -> str:
    """The time until all is compiled, in words; empty while too little is done to tell it."""
    return _compilation.time_left()


def is_done() -> bool:
    """Check whether all kernels run compiled."""
    return _compilation.done.is_set()


def wait_for_loading() -> None:
    """Wait until kernels that plans have called are loaded, but not for the compiler.

    Nor longer than twice what these have run as Python so far: a plan that takes less without them
    does not wait for them. Where none has been called, it waits for all.
    """
    if _compilation._thread is not None and not _compilation.loaded.is_set():
        _compilation.wanted.set()
        needs = [kernel.need for kernel in KERNELS.values() if 0 < kernel.need < math.inf]
        progress.wait(
            _compilation.loaded, max(_WORTH_WAITING * sum(needs), _PATIENCE) if needs else None
        )


def wait_for_kept() -> None:
    """Wait until all kernels are loaded that an earlier run has kept, once plans took long without.

    For plans of several threads: while these run kernels as Python, they take the interpreter from
    the thread that loads, and all of them are slow for many times as long.
    """
    if _compilation.kept.is_set() or not _is_long():
        return
    begin()
    _compilation.awaited.set()
    _compilation.wanted.set()
    progress.wait(_compilation.kept, _LONGEST)


def _is_long() -> bool:
    """Check whether kernels have run as Python for long."""
    return sum(kernel.need for kernel in KERNELS.values() if kernel.need < math.inf) > _BEARABLE


def _after_fork() -> None:
    """Begin anew: a forked process does not have the threads."""
    global _compilation
    _compilation = _Compilation()
    for kernel in KERNELS.values():
        kernel.elsewhere = None


atexit.register(lambda: _compilation.end())  # of this process, forked or not
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)
