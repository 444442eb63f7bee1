"""Compiled kernels in files, by numba's cache."""

from __future__ import annotations

import pickle
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from llvmlite.binding import parse_assembly  # type: ignore[import-untyped]
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.runtime.nrt import rtsys

from abi.compilation.kernel_folder import READY

_KEPT = 30 * 24 * 3600.0
"""Seconds after which a file that nobody has used is removed: another clone may use it."""

_BROKEN = (OSError, EOFError, ValueError, AttributeError, ImportError, pickle.UnpicklingError)
"""What reading a file raises that was cut off, or that something else has written."""

_DAY = 24 * 3600.0
"""Seconds after which the use of a file is noted anew."""


class KernelCache(FunctionCache):
    """Numba's cache of one function, in that folder, in files named by a stamp."""

    def __init__(self, function: Callable[..., Any], folder: Path, stamp: str) -> None:
        self._impl_class: Any = partial(_Implementation, folder, stamp)
        self._folder, self._stamp = folder, stamp
        super().__init__(function)  # type: ignore[no-untyped-call]

    def has(self, signature: tuple[Any, ...], codegen: Any) -> bool:
        """Check whether the compiled form for these types is kept."""
        file: Any = self._cache_file
        try:
            name = file._load_index().get(self._index_key(signature, codegen))  # type: ignore[no-untyped-call]
        except _BROKEN:
            self._remove()
            return False
        return name is not None and (self._folder / name).exists()

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Load a compiled form; None if it is not kept, or its file is damaged.

        Numba would import all that it can compile first, which takes longer than the loading.
        """
        rtsys.initialize(context)
        try:
            with self._guard_against_spurious_io_errors():
                return self._load_overload(signature, context)  # type: ignore[no-untyped-call]
        except _BROKEN:
            self._remove()
            return None

    def note_use(self) -> None:
        """Keep the function's files for another while."""
        for file in self._files():
            with suppress(OSError):
                if _age(file) > _DAY:
                    file.touch()

    def remove_unused(self) -> None:
        """Remove files of any kernel that nobody has used for long."""
        for file in self._folder.glob("*.nb?"):
            with suppress(OSError):
                if _age(file) > _KEPT:
                    file.unlink()

    def _files(self) -> Iterator[Path]:
        return self._folder.glob(f"*-{self._stamp[:16]}.*.nb?")

    def _remove(self) -> None:
        for file in self._files():
            with suppress(OSError):
                file.unlink()


def _age(file: Path) -> float:
    """Seconds since a file was written, or its use was noted."""
    return time.time() - file.stat().st_mtime


class ReadyKernels(KernelCache):
    """Compiled forms that a wheel brings, for any processor of its platform; nothing is written."""

    def __init__(self, function: Callable[..., Any], stamp: str) -> None:
        super().__init__(function, READY, stamp)

    def save_overload(self, _signature: Any, _compiled: Any) -> None:
        """Keep nothing."""

    def _index_key(self, signature: Any, codegen: Any) -> Any:
        return super()._index_key(signature, _AnyProcessor(codegen))  # type: ignore[no-untyped-call]

    def _remove(self) -> None:
        pass


class _AnyProcessor:
    """Numba's code generator, as an index names it that was written for any processor."""

    def __init__(self, codegen: Any) -> None:
        self._codegen = codegen

    def magic_tuple(self) -> tuple[str, str, str]:
        platform, _, _ = self._codegen.magic_tuple()
        return platform, "generic", ""


class _Implementation(CompileResultCacheImpl):
    def __init__(self, folder: Path, stamp: str, function: Callable[..., Any]) -> None:
        self._locator_classes: list[Any] = [_Locator(folder, stamp)]
        super().__init__(function)  # type: ignore[no-untyped-call]

    def reduce(self, compiled: Any) -> Any:
        """What is kept: machine code, and what else it needs.

        Not LLVM's code, from which numba would compile what calls a kernel, which nothing does; nor
        the environments of helpers that hold no constants: the modules of all would be imported.
        """
        kept = super().reduce(compiled)  # type: ignore[no-untyped-call]
        (name, kind, (machine_code, _)), *rest, environments = kept
        entry = compiled.fndesc.llvm_cpython_wrapper_name
        named = parse_assembly(f'define void @"{entry}"() {{ unreachable }}').as_bitcode()
        needed = tuple(one for one in environments if one.consts)
        return (name, kind, (machine_code, named)), *rest, needed


class _Locator:
    """What numba asks for the place of a function's files."""

    def __init__(self, folder: Path, stamp: str) -> None:
        self._folder, self._stamp = folder, stamp
        self._py_file = ""

    def from_function(self, _function: Callable[..., Any], file: str) -> _Locator:
        self._py_file = file  # numba's warnings name it
        return self

    def get_cache_path(self) -> str:
        return str(self._folder)

    def ensure_cache_path(self) -> None:
        self._folder.mkdir(parents=True, exist_ok=True)

    def get_source_stamp(self) -> str:
        return self._stamp

    def get_disambiguator(self) -> str:
        """Part of the files' names: in an index of other sources may be classes that are gone."""
        return self._stamp[:16]
