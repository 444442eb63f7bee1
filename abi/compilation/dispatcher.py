"""Numba's dispatcher of a kernel, with a cache that is stamped with all that the kernel depends on.

This module imports numba, which takes longer than a first plan: so it is imported itself only when
the first kernel is to be compiled or loaded.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numba
from numba.core.compiler import CompilerBase, DefaultPassBuilder

from abi.compilation.borrowing import borrowing
from abi.compilation.helpers import declare_helpers
from abi.compilation.kernel_cache import KernelCache, ReadyKernels
from abi.compilation.kernel_folder import kernel_folder
from abi.compilation.kernel_stamp import fields_of, stamp


class _KernelCompiler(CompilerBase):
    """Numba's compiler of a kernel, which borrows its arguments and knows the helpers."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        declare_helpers()  # numba then looks for what is new
        super().__init__(*arguments, **options)  # type: ignore[no-untyped-call]

    def define_pipelines(self) -> list[Any]:
        """Numba's own passes and one more."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)  # type: ignore[no-untyped-call]
        return [borrowing(passes)]


_OPTIONS: dict[str, Any] = {
    "nogil": True,
    "error_model": "numpy",  # as that of the helpers; kernels do not divide by zero
    "no_cfunc_wrapper": True,  # for callers from C, of which there are none
    "pipeline_class": _KernelCompiler,
}

_MOST_FAILURES = 9


def jitted(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """Numba's own dispatcher of a function, not compiled yet.

    For the first one numba goes through Python's builtins, and fails if another thread adds to them
    just then, as a notebook does with each cell: it is asked again.
    """
    for _ in range(_MOST_FAILURES):
        with suppress(RuntimeError):
            return numba.njit(**options)(function)
    return numba.njit(**options)(function)


class Dispatcher:
    """A function, compiled for the types of one example.

    Attributes:
        of_numba: numba's own dispatcher, which checks the types of its arguments at each call.
    """

    def __init__(
        self, function: Callable[..., Any], example: tuple[Any, ...], options: dict[str, Any]
    ) -> None:
        options = _OPTIONS | options
        self._signature = tuple(map(numba.typeof, example))
        self.of_numba: Any = jitted(function, options)
        described = repr(sorted(options.items())) + fields_of(example)
        self._cache = self._cache_of(function, stamp(function, described))
        if self._cache is not None:
            self.of_numba._cache = self._cache

    @property
    def cached(self) -> bool:
        """Whether an earlier run cached the compiled form, or the wheel brought it."""
        return self._cache is not None and self._has(self._cache)

    def compile(self) -> None:
        """Compile the function, or load its cached form."""
        if self.of_numba.signatures:
            return
        if self._cache is not None:
            if self.cached:
                self._cache.note_use()
            else:
                self._cache.remove_unused()
        try:
            self.of_numba.compile(self._signature)
        except OSError:  # it is compiled, and cannot be kept: the disk is full
            if not self.of_numba.signatures:
                raise
        self.of_numba.disable_compile()

    def _cache_of(self, function: Callable[..., Any], stamp: str) -> KernelCache | None:
        """The wheel's cache if that has the compiled form, else the user's; None without any."""
        ready = ReadyKernels(function, stamp)
        if self._has(ready):
            return ready
        folder = kernel_folder()
        return None if folder is None else KernelCache(function, folder, stamp)

    def _has(self, cache: KernelCache) -> bool:
        return cache.has(self._signature, self.of_numba.targetctx.codegen())
