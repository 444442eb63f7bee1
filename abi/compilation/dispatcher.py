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
from abi.compilation.kernel_cache import KernelCache
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


def make_dispatcher(
    function: Callable[..., Any], example: tuple[Any, ...], options: dict[str, Any]
) -> Any:
    """Numba's dispatcher of a function, with a file of its compiled form for one example's types.

    It is not compiled yet, and checks the types of its arguments at each call.
    """
    options = _OPTIONS | options
    dispatcher = jitted(function, options)
    described = repr(sorted(options.items())) + fields_of(example) + repr(_types(example))
    codegen = dispatcher.targetctx.codegen()
    cache = KernelCache.of(function, stamp(function, described), codegen)
    if cache is not None:
        dispatcher._cache = cache
    return dispatcher


def is_kept(dispatcher: Any) -> bool:
    """Check whether an earlier run kept the compiled form, or the wheel brought it."""
    return isinstance(dispatcher._cache, KernelCache) and dispatcher._cache.file.exists()


def compile_once(dispatcher: Any, example: tuple[Any, ...]) -> None:
    """Compile a function for the types of an example, or load its kept form."""
    if dispatcher.signatures:
        return
    cache = dispatcher._cache
    if isinstance(cache, KernelCache):
        if is_kept(dispatcher):
            cache.note_use()
        else:
            cache.remove_unused()
    try:
        dispatcher.compile(_types(example))
    except OSError:  # it is compiled, and cannot be kept: the disk is full
        if not dispatcher.signatures:
            raise
    dispatcher.disable_compile()


def _types(example: tuple[Any, ...]) -> tuple[Any, ...]:
    """Numba's types of arguments."""
    return tuple(map(numba.typeof, example))
