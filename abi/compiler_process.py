"""A process that compiles the kernels that it is told, one after the other, and caches them."""

from __future__ import annotations

import gc
import importlib
import os
import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from abi.compiled import KERNELS, LOADING, Kernel

_MAIN = "from abi.compiler_process import compile_named; compile_named({})"
_ROOT = Path(__file__).resolve().parents[1]

_IDLE: int = getattr(subprocess, "IDLE_PRIORITY_CLASS", 0)
"""How Windows starts a process that works only while nobody else needs the processor."""


def start(gives_way: bool) -> subprocess.Popen[str] | None:
    """Start a process that compiles the kernels it is told; None if that is not possible."""
    paths = [str(_ROOT), os.environ.get("PYTHONPATH", "")]
    try:
        return subprocess.Popen(
            [sys.executable, "-P", "-c", _MAIN.format(gives_way)],
            env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            creationflags=_IDLE if gives_way else 0,
            process_group=0,  # a terminal interrupts all of the group in front
        )
    except OSError:
        return None


def compile_named(gives_way: bool) -> None:
    """Compile the kernels named on standard input, and print the name of each once it is cached.

    The main function of the other processes. When the one that started them ends, they end, too,
    but not before the kernels that they were told are cached: else a program that is shorter than
    its compilation would find nothing, however often it runs.

    Args:
        gives_way: whether to work only while nobody else needs the processor.
    """
    if gives_way:
        _give_way()
    for kernel in compile_each(_named(line.strip()) for line in sys.stdin):
        try:
            print(kernel.name, flush=True)
        except OSError:  # nobody waits for it any more
            sys.stdout = open(os.devnull, "w")  # noqa: SIM115
            _give_way()


def compile_each(kernels: Iterable[Kernel[..., Any]]) -> Iterator[Kernel[..., Any]]:
    """Compile kernels in a process that does nothing else, and yield each once it is cached."""
    _take_shortcuts()
    gc.disable()  # it would look through all that was compiled, again and again
    for kernel in kernels:
        kernel.compile()
        yield kernel
        gc.collect()
        gc.freeze()


def _named(name: str) -> Kernel[..., Any]:
    """The kernel of a name, of whose package no more is imported than it needs."""
    importlib.import_module(name.rpartition(".")[0])
    return KERNELS[name]


def _give_way() -> None:
    """Work only while nobody else needs the processor."""
    if hasattr(os, "nice"):
        os.nice(19)


def _take_shortcuts() -> None:
    """Import numba, and have it compile with less work."""
    with LOADING:
        from abi.compilation import shortcuts

        shortcuts.take()
