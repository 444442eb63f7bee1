"""Both forms of the kernels, for tests that compare them: as Python, and compiled."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, TypeVar

from abi import compiling
from abi.compiled import Kernel

_T = TypeVar("_T")


@cache
def _kernels() -> list[Kernel[..., Any]]:
    """All kernels; to look for their modules takes longer than many a test."""
    return compiling.all_kernels()


@contextmanager
def kernels_as(compiled: bool) -> Iterator[None]:
    """Run all kernels compiled, or as Python, whatever else the process has done."""
    kernels = _kernels()
    before = [(kernel, kernel._run) for kernel in kernels]
    for kernel in kernels:
        if compiled:
            kernel.compile()
        else:
            kernel._run = kernel.interpret
    try:
        yield
    finally:
        for kernel, run in before:
            kernel._run = run


def plain(work: Callable[[], _T]) -> _T:
    """Do some work with kernels as Python."""
    with kernels_as(compiled=False):
        return work()


def compiled(work: Callable[[], _T]) -> _T:
    """Do some work with kernels compiled."""
    with kernels_as(compiled=True):
        return work()
