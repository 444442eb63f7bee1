"""Both forms of the kernels, for tests that compare them: as Python, and compiled."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from abi import compiling

_T = TypeVar("_T")


@contextmanager
def kernels_as(compiled: bool) -> Iterator[None]:
    """Run all kernels compiled, or as Python, whatever else the process has done."""
    kernels = compiling.all_kernels()
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
