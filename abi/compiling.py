"""Compilation of all kernels in the background, kept from one run to the next.

Kernels that an earlier run has kept are loaded, in about a second. The others are compiled in a
process of their own, so that neither the plans nor the end of the program wait for it, and loaded
one by one as they come.
"""

from __future__ import annotations

import atexit
import importlib
import logging
import os
import pkgutil
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numba

from abi.compiled import KERNELS, Kernel

_log = logging.getLogger(__name__)

_PACKAGE = Path(__file__).resolve().parent

_GRACE = 0.2
"""Seconds before the first kernel is loaded: a program of one plan ends without waiting for it."""

_CHILD = "from abi.compiling import compile_named; compile_named()"


class _Compilation:
    """The one background compilation of a process.

    Attributes:
        loaded: set once all kernels that an earlier run has kept are loaded.
        done: set once all kernels run compiled that can.
        wanted: set once somebody waits for it, or the process ends.
    """

    def __init__(self) -> None:
        self.loaded = threading.Event()
        self.done = threading.Event()
        self.wanted = threading.Event()
        self._thread: threading.Thread | None = None
        self._child: subprocess.Popen[str] | None = None
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
        """Stop; takes as long as the kernel that is being loaded.

        A thread inside the compiler's library when the process ends could crash it.
        """
        self._ending = True
        if self._child is not None:
            self._child.kill()
        self.wanted.set()
        if self._thread is not None:
            self._thread.join()

    def _work(self) -> None:
        self.wanted.wait(_GRACE)
        try:
            off = numba.config.DISABLE_JIT  # type: ignore[attr-defined]
            kernels = [] if off else all_kernels()
            missing = [kernel for kernel in kernels if not self._load(kernel)]
            if not missing:
                return
            self.loaded.set()
            if not self._ending:
                self._from_child(missing)
            for kernel in missing:
                # where nothing can be kept, or no process started
                if not self._ending:
                    kernel.compile()
        except Exception:
            _log.exception("kernels stay uncompiled")
        finally:
            self.loaded.set()
            self.done.set()

    def _load(self, kernel: Kernel[..., Any]) -> bool:
        """Load a kernel if it was kept."""
        if not kernel.compiled and not self._ending and kernel.cached:
            kernel.compile()
        return kernel.compiled

    def _from_child(self, missing: list[Kernel[..., Any]]) -> None:
        """Let another process compile missing kernels, and load each when it is kept."""
        paths = [str(_PACKAGE.parent), os.environ.get("PYTHONPATH", "")]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
        try:
            self._child = subprocess.Popen(
                [sys.executable, "-P", "-c", _CHILD, *(kernel.name for kernel in missing)],
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
            )
        except OSError:
            return
        if self._ending:
            self._child.kill()
        assert self._child.stdout is not None
        with self._child:
            for line in self._child.stdout:
                self._load(KERNELS[line.strip()])


_compilation = _Compilation()


def all_kernels() -> list[Kernel[..., Any]]:
    """Kernels of all modules, whether imported before or not."""
    for module in pkgutil.walk_packages([str(_PACKAGE)], "abi."):
        if module.name.endswith("_kernels"):
            importlib.import_module(module.name)
    return list(KERNELS.values())


def compile() -> None:
    """Compile all kernels and wait for it: a second if an earlier run did, else a minute or a few.

    Plans are made without it too, slower at first: from the first one on kernels are compiled in
    the background.
    """
    _compilation.begin()
    _compilation.wanted.set()
    _compilation.done.wait()


def begin() -> None:
    """Start compiling in the background, once."""
    _compilation.begin()


def is_done() -> bool:
    """Whether all kernels run compiled."""
    return _compilation.done.is_set()


def wait_for_loading() -> None:
    """Wait until kernels that an earlier run kept are loaded; not for the compiler."""
    if _compilation._thread is not None:
        _compilation.wanted.set()
        _compilation.loaded.wait()


def compile_named() -> None:
    """Compile the kernels that the command line names, and print the name of each when it is kept.

    The main function of the other process, which ends with the one that started it.
    """
    all_kernels()
    for name in sys.argv[1:]:
        KERNELS[name].compile()
        print(name, flush=True)


def _end() -> None:
    _compilation.end()


def _after_fork() -> None:
    """Begin anew: a forked process does not have the thread."""
    global _compilation
    _compilation = _Compilation()
    for kernel in KERNELS.values():
        kernel.lock = threading.Lock()


atexit.register(_end)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)
