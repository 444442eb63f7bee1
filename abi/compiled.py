"""Kernels: inner loops that run as plain Python until they are compiled.

``@compiled(example=…)`` turns a function into a kernel and registers it; calls run the compiled
form as soon as there is one. :mod:`abi.compiling` compiles all kernels in the background of the
first plan. Helpers that kernels share are decorated with :func:`abi.compilation.jitable.jitable`.
"""

from __future__ import annotations

import math
import os
import threading
import time
from collections.abc import Callable
from contextvars import ContextVar
from functools import cached_property, partial
from typing import Any, Generic, ParamSpec, TypeVar

import numpy as np

from abi import progress
from abi.arrays import read_only
from abi.compilation.callees import code_size
from abi.compilation.plain import as_lists

_P = ParamSpec("_P")
_R = TypeVar("_R")

FLOATS = read_only(np.zeros(1))
"""Example of numbers that are read, flat."""
IDS = read_only(np.zeros(1, np.int32))
"""Example of ids or of bits that are read, flat."""
FLAGS = read_only(np.zeros(1, np.bool_))
"""Example of flags that are read, flat."""
NEW_FLOATS = np.zeros(1)
"""Example of numbers that the kernel writes, flat."""
NEW_IDS = np.zeros(1, np.int32)
"""Example of ids or of bits that the kernel writes, flat."""
NEW_FLAGS = np.zeros(1, np.bool_)
"""Example of flags that the kernel writes, flat."""


LOADING = threading.RLock()
"""Held while kernels or numba are imported, or numba loads or compiles. A fork waits for it: in the
new process nobody would ever release what they hold meanwhile.
"""

if hasattr(os, "register_at_fork"):
    os.register_at_fork(
        before=LOADING.acquire,
        after_in_parent=LOADING.release,
        after_in_child=LOADING.release,
    )


_interpreted_calls: ContextVar[int] = ContextVar("interpreted_calls", default=0)
"""How many calls of kernels this thread has run as Python."""


class Kernel(Generic[_P, _R]):
    """A function that numba compiles, callable before and after.

    The compiled form is kept (:func:`abi.compilation.kernel_folder.kernel_folder`) until the
    function, or one that is compiled with it, changes; see
    :func:`abi.compilation.kernel_stamp.stamp`. It releases the interpreter's lock. It raises
    ``TypeError`` for arrays of another type, number of dimensions or layout than those of the
    example, and for arrays that it would write but must not.

    Attributes:
        name: module and name of the function.
        py_func: the function as written.
        example: arguments of the types that it is compiled for, and of no others.
        elsewhere: while another process is to compile it: set once that is done, or has failed.
        foreseen: rank among those that the plan under way will run for long; 0: it is not foreseen.
    """

    def __init__(
        self,
        function: Callable[_P, _R],
        example: tuple[Any, ...],
        fallback: bool,
        in_numpy: Callable[..., Any] | None,
        options: dict[str, Any],
    ) -> None:
        self.name = f"{function.__module__}.{function.__qualname__}"
        self.py_func = function
        self.example = example
        self.elsewhere: threading.Event | None = None
        self.foreseen = 0
        self.__doc__ = function.__doc__
        self._in_numpy = in_numpy
        self._interpreted, self._begun = 0.0, math.inf
        self._options = options
        self._of_numba: Any = None
        self._compiled: Any = None
        self._run: Callable[..., Any] = self.interpret if fallback else self._compile_and_run
        KERNELS[self.name] = self

    def __call__(self, *arguments: _P.args, **_: _P.kwargs) -> _R:
        """Run the function: compiled if it is, else as Python."""
        progress.check()
        result: _R = self._run(*arguments)
        return result

    @property
    def compiled(self) -> bool:
        """Whether calls run compiled."""
        return self._run is self._compiled

    @cached_property
    def size(self) -> int:
        """Bytes of Python code that are compiled for it."""
        return code_size(self.py_func)

    @property
    def need(self) -> float:
        """Time that it has run as Python, [s]; infinite while a call waits for the compiler."""
        return self._interpreted + max(time.perf_counter() - self._begun, 0.0)

    @property
    def of_numba(self) -> Any:
        """Numba's dispatcher of it, made when it is first asked for."""
        with LOADING:
            if self._of_numba is None:
                from abi.compilation.dispatcher import make_dispatcher

                self._of_numba = make_dispatcher(self.py_func, self.example, self._options)
            return self._of_numba

    @property
    def cached(self) -> bool:
        """Whether an earlier run cached the compiled form."""
        with LOADING:
            from abi.compilation.dispatcher import is_kept

            return is_kept(self.of_numba)

    def compile(self) -> None:
        """Compile the function, or load its cached form; calls run compiled from then on.

        Where another process is to compile it, it does so next, and this one waits.
        """
        if is_off():
            return
        elsewhere = self.elsewhere
        if elsewhere is not None and not elsewhere.is_set():
            self._interpreted = math.inf
            progress.wait(elsewhere)
        with LOADING:
            if self.compiled:
                return
            from abi.compilation.dispatcher import compile_once

            compile_once(self.of_numba, self.example)
            self._run = self._compiled = self.of_numba

    def interpret(self, *arguments: Any) -> Any:
        """Run the function as Python, or its form in numpy if it has one."""
        _interpreted_calls.set(_interpreted_calls.get() + 1)
        self._begun = begun = time.perf_counter()
        with np.errstate(all="ignore"):  # as compiled
            result = (self._in_numpy or self._on_lists)(*arguments)
        self._begun = math.inf
        self._interpreted += time.perf_counter() - begun
        return result

    def _on_lists(self, *arguments: Any) -> Any:
        """Run the function on lists, which Python reads faster than arrays."""
        plain = tuple(map(as_lists, arguments))
        result = self.py_func(*plain)  # type: ignore[call-arg]
        for array, values in zip(arguments, plain, strict=True):
            if isinstance(array, np.ndarray) and array.flags.writeable:
                array[:] = values
        return result

    def _compile_and_run(self, *arguments: Any) -> Any:
        self.compile()
        return self._run(*arguments) if self.compiled else self.interpret(*arguments)


KERNELS: dict[str, Kernel[..., Any]] = {}
"""All kernels of the modules imported so far, by name, in the order of import."""


def compiled(
    example: tuple[Any, ...],
    fallback: bool = True,
    in_numpy: Callable[..., Any] | None = None,
    **options: Any,
) -> Callable[[Callable[_P, _R]], Kernel[_P, _R]]:
    """Make a kernel of a function.

    Args:
        example: arguments of the types that it will be called with; their values do not matter.
        fallback: whether it runs as Python until it is compiled. If not, the first call waits for
            the compiler; use this for a function that would take longer as Python.
        in_numpy: another form of the function that computes the same of whole arrays, bit by bit,
            in less time than Python's loops; it runs until the function is compiled.
        options: further options of ``numba.njit``.
    """
    return partial(Kernel, example=example, fallback=fallback, in_numpy=in_numpy, options=options)


def interpreted_calls() -> int:
    """Count the calls of kernels that this thread has run as Python."""
    return _interpreted_calls.get()


def is_off() -> bool:
    """Check whether nothing is to be compiled (``NUMBA_DISABLE_JIT``)."""
    return os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")
