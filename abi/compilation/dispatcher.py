"""Numba's dispatcher of a kernel, with a cache that is stamped with all that the kernel depends on.

Numba is imported here alone, and that takes longer than a first plan: so this module is imported
only when the first kernel is to be compiled or loaded.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numba
from numba.core import caching
from numba.extending import register_jitable

from abi.compilation.borrowing import Borrowing
from abi.compilation.jitable import UNDECLARED, options_of
from abi.compilation.kernel_stamp import fields_of, stamp


def is_off() -> bool:
    """Check whether numba was told to compile nothing (``NUMBA_DISABLE_JIT``)."""
    return bool(numba.config.DISABLE_JIT)  # type: ignore[attr-defined]


class Dispatcher:
    """A function, compiled for the types of one example.

    Attributes:
        of_numba: numba's own dispatcher, which checks the types of its arguments at each call.
    """

    def __init__(
        self, function: Callable[..., Any], example: tuple[Any, ...], options: dict[str, Any]
    ) -> None:
        declare_helpers()
        options = {"nogil": True, "pipeline_class": Borrowing, **options}
        self._signature = tuple(map(numba.typeof, example))
        self._stale: tuple[Path, str, str] | None = None
        try:
            self.of_numba: Any = numba.njit(cache=True, **options)(function)
        except RuntimeError:  # there is no folder that can be written
            self.of_numba = numba.njit(**options)(function)
        cache = getattr(self.of_numba, "_cache", None)
        if hasattr(cache, "_cache_file") and hasattr(cache, "_impl"):
            # a numba without these private names keeps its own stamp
            self._stamp(cache, stamp(function, repr(sorted(options.items())) + fields_of(example)))

    @property
    def cached(self) -> bool:
        """Whether an earlier run cached the compiled form; False if numba does not say."""
        try:
            cache = self.of_numba._cache
            key = cache._index_key(self._signature, self.of_numba.targetctx.codegen())
            return key in cache._cache_file._load_index()
        except (AttributeError, OSError):
            return False

    def compile(self) -> None:
        """Compile the function, or load its cached form."""
        if self.of_numba.signatures:
            return
        if not self.cached:
            self._forget_stale()
        try:
            self.of_numba.compile(self._signature)
        except OSError:  # it is compiled, and cannot be kept: the disk is full
            if not self.of_numba.signatures:
                raise
        self.of_numba.disable_compile()

    def _stamp(self, cache: Any, current: str) -> None:
        line = f"-{self.of_numba.py_func.__code__.co_firstlineno}."
        name, version = cache._impl.filename_base.split(line, 1)
        # in the name, since an index of other sources may name classes that are gone
        cache._cache_file = caching.IndexDataCacheFile(  # type: ignore[no-untyped-call]
            cache_path=cache._cache_path,
            filename_base=f"{name}-{current[:16]}.{version}",
            source_stamp=current,
        )
        self._stale = Path(cache._cache_path), f"{name}-*.{version}*.nb?", current[:16]

    def _forget_stale(self) -> None:
        """Remove what was kept of other sources."""
        if self._stale is None:
            return
        folder, pattern, current = self._stale
        for file in folder.glob(pattern):
            if current not in file.name:
                with suppress(OSError):
                    file.unlink()


def declare_helpers() -> None:
    """Tell numba of the functions that kernels call; for who compiles one without a kernel, too."""
    while UNDECLARED:
        function = UNDECLARED.popleft()
        options = options_of(function)
        register_jitable(**options)(function) if options else register_jitable(function)
