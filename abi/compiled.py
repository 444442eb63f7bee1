"""Kernels: inner loops that run as plain Python until they are compiled.

``@compiled(example=…)`` turns a function into a kernel and registers it; calls run the compiled
form as soon as there is one. :mod:`abi.compiling` compiles all kernels in the background of the
first plan. Helpers that kernels share are decorated with numba's ``register_jitable``.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, Generic, ParamSpec, TypeVar

import numba
import numpy as np
from numba.core import caching

from abi.arrays import read_only
from abi.compilation.borrowed import Borrowing
from abi.compilation.kernel_stamp import fields_of, stamp

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


class Kernel(Generic[_P, _R]):
    """A function that numba compiles, callable before and after.

    The compiled form stays in numba's cache (``NUMBA_CACHE_DIR``) until the function, or one that
    is compiled with it, changes; see :func:`abi.compilation.kernel_stamp.stamp`. It releases the
    interpreter's lock.

    Attributes:
        name: module and name of the function.
        py_func: the function as written.
        example: arguments of the types that it is compiled for, and of no others.
        lock: held while it is compiled or loaded.
        check_types: whether what is compiled from then on refuses other types; tests ask for it.
    """

    check_types: ClassVar[bool] = False

    def __init__(
        self,
        function: Callable[_P, _R],
        example: tuple[Any, ...],
        fallback: bool,
        options: dict[str, Any],
    ) -> None:
        self.name = f"{function.__module__}.{function.__qualname__}"
        self.py_func = function
        self.example = example
        self.lock = threading.Lock()
        self.__doc__ = function.__doc__
        self._options = {"nogil": True, "pipeline_class": Borrowing, **options}
        self._dispatcher: Any = None
        self._compiled: Any = None
        self._stale: tuple[Path, str, str] | None = None
        self._run: Callable[..., Any] = self.interpret if fallback else self._compile_and_run
        KERNELS[self.name] = self

    def __call__(self, *arguments: _P.args, **_: _P.kwargs) -> _R:
        """Run the function: compiled if it is, else as Python."""
        result: _R = self._run(*arguments)
        return result

    @property
    def compiled(self) -> bool:
        """Whether calls run compiled."""
        return self._run is self._compiled

    @property
    def cached(self) -> bool:
        """Whether an earlier run cached the compiled form; False if numba does not say."""
        dispatcher = self._numba_dispatcher()
        try:
            key = dispatcher._cache._index_key(self._signature(), dispatcher.targetctx.codegen())
            return key in dispatcher._cache._cache_file._load_index()
        except (AttributeError, OSError):
            return False

    def compile(self) -> None:
        """Compile the function, or load its cached form; calls run compiled from then on."""
        with self.lock:
            if self.compiled or numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
                return
            dispatcher = self._numba_dispatcher()
            if not dispatcher.signatures:
                if not self.cached:
                    _forget(self._stale)
                try:
                    dispatcher.compile(self._signature())
                except OSError:  # it is compiled, and cannot be kept: the disk is full
                    if not dispatcher.signatures:
                        raise
                dispatcher.disable_compile()
            form = dispatcher
            if not self.check_types:
                # to check them numba reads the names of all fields of named tuples at every call
                [form] = (made.entry_point for made in dispatcher.overloads.values())
            self._run = self._compiled = form

    def interpret(self, *arguments: Any) -> Any:
        """Run the function as Python, on lists, which it reads faster than arrays."""
        plain = tuple(map(_plain, arguments))
        with np.errstate(all="ignore"):  # as compiled
            result = self.py_func(*plain)  # type: ignore[call-arg]
        for array, values in zip(arguments, plain, strict=True):
            if isinstance(array, np.ndarray) and array.flags.writeable:
                array[:] = values
        return result

    def _compile_and_run(self, *arguments: Any) -> Any:
        self.compile()
        return self._run(*arguments) if self.compiled else self.interpret(*arguments)

    def _signature(self) -> tuple[Any, ...]:
        return tuple(map(numba.typeof, self.example))

    def _numba_dispatcher(self) -> Any:
        """numba's dispatcher, with a cache stamped with all that the function depends on."""
        if self._dispatcher is None:
            try:
                dispatcher = numba.njit(cache=True, **self._options)(self.py_func)
            except RuntimeError:  # there is no folder that can be written
                dispatcher = numba.njit(**self._options)(self.py_func)
            cache: Any = getattr(dispatcher, "_cache", None)
            if hasattr(cache, "_cache_file") and hasattr(cache, "_impl"):
                # a numba without these private names keeps its own stamp
                options = repr(sorted(self._options.items())) + fields_of(self.example)
                current = stamp(self.py_func, options)
                line = f"-{self.py_func.__code__.co_firstlineno}."
                name, version = cache._impl.filename_base.split(line, 1)
                # in the name, since an index of other sources may name classes that are gone
                cache._cache_file = caching.IndexDataCacheFile(  # type: ignore[no-untyped-call]
                    cache_path=cache._cache_path,
                    filename_base=f"{name}-{current[:16]}.{version}",
                    source_stamp=current,
                )
                folder = Path(cache._cache_path)
                self._stale = (folder, f"{name}-*.{version}*.nb?", current[:16])
            self._dispatcher = dispatcher
        return self._dispatcher


KERNELS: dict[str, Kernel[..., Any]] = {}
"""All kernels of the modules imported so far, by name, in the order of import."""


def compiled(
    example: tuple[Any, ...], fallback: bool = True, **options: Any
) -> Callable[[Callable[_P, _R]], Kernel[_P, _R]]:
    """Make a kernel of a function.

    Args:
        example: arguments of the types that it will be called with; their values do not matter.
        fallback: whether it runs as Python until it is compiled. If not, the first call waits for
            the compiler; use this for a function that would take longer as Python.
        options: further options of ``numba.njit``.
    """
    return partial(Kernel, example=example, fallback=fallback, options=options)


def _forget(stale: tuple[Path, str, str] | None) -> None:
    """Remove what was kept of other sources: the folder, a pattern, and what to leave."""
    if stale is None:
        return
    folder, pattern, current = stale
    for file in folder.glob(pattern):
        if current not in file.name:
            with suppress(OSError):
                file.unlink()


def _plain(value: Any) -> Any:
    """The value with arrays as lists, in tuples too."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple):
        inner = map(_plain, value)
        return type(value)(*inner) if hasattr(value, "_fields") else tuple(inner)
    return value
