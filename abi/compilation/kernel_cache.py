"""Compiled kernels in files, one for each kernel, as it is written now, and kind of processor."""

from __future__ import annotations

import hashlib
import pickle
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from llvmlite.binding import parse_assembly  # type: ignore[import-untyped]
from numba.core.compiler import CompileResult
from numba.core.runtime.nrt import rtsys
from numba.core.serialize import dumps

from abi.atomic_file import replace_file
from abi.compilation.kernel_folder import READY, kernel_folder

_KEPT = 30 * 24 * 3600.0
"""Seconds after which a file that nobody has used is removed: another clone may use it."""

_BROKEN = (OSError, EOFError, ValueError, AttributeError, ImportError, pickle.UnpicklingError)
"""What reading a file raises that was cut off, or that something else has written."""

_DAY = 24 * 3600.0
"""Seconds after which the use of a file is noted anew."""


class KernelCache:
    """The file of a kernel's compiled form, from which numba's dispatcher takes it.

    Attributes:
        file: where the form is kept, or will be.
    """

    def __init__(self, file: Path) -> None:
        self.file = file

    @classmethod
    def of(cls, function: Callable[..., Any], stamp: str, codegen: Any) -> KernelCache | None:
        """The file that a wheel brings, else the user's; None if no folder can be written.

        Args:
            function: the kernel as it is written.
            stamp: a hash of all that its compiled form depends on but the processor.
            codegen: numba's code generator, which knows the processor.
        """
        platform, *processor = codegen.magic_tuple()
        ready = READY / _name(function, stamp, platform, "generic", "")
        if ready.exists():
            return cls(ready)
        folder = kernel_folder()
        return (
            None if folder is None else cls(folder / _name(function, stamp, platform, *processor))
        )

    def load_overload(self, _signature: Any, context: Any) -> Any:
        """Load the compiled form; None if it is not kept, or its file is damaged.

        Numba would import all that it can compile first, which takes longer than the loading.
        """
        rtsys.initialize(context)
        try:
            kept = pickle.loads(self.file.read_bytes())
            return CompileResult._rebuild(context, *kept)  # type: ignore[no-untyped-call]
        except _BROKEN:
            if self._is_of_user:
                with suppress(OSError):
                    self.file.unlink()
            return None

    def save_overload(self, _signature: Any, compiled: Any) -> None:
        """Keep a compiled form: machine code, and what else it needs.

        Not LLVM's code, from which numba would compile what calls a kernel, which nothing does; nor
        the environments of helpers that hold no constants: the modules of all would be imported.

        Raises:
            OSError: the file cannot be written.
        """
        if not self._is_of_user:
            return
        assert not compiled.library.has_dynamic_globals  # addresses of this process
        (name, kind, (machine_code, _)), *rest, environments = compiled._reduce()
        entry = compiled.fndesc.llvm_cpython_wrapper_name
        named = parse_assembly(f'define void @"{entry}"() {{ unreachable }}').as_bitcode()
        needed = tuple(one for one in environments if one.consts)
        kept = (name, kind, (machine_code, named)), *rest, needed
        self.file.parent.mkdir(parents=True, exist_ok=True)
        replace_file(self.file, dumps(kept))  # type: ignore[no-untyped-call]

    def note_use(self) -> None:
        """Keep the file for another while."""
        with suppress(OSError):
            if _age(self.file) > _DAY:
                self.file.touch()

    def remove_unused(self) -> None:
        """Remove files of any kernel in this folder that nobody has used for long."""
        for file in self.file.parent.glob("*.nb?"):
            with suppress(OSError):
                if _age(file) > _KEPT:
                    file.unlink()

    @property
    def _is_of_user(self) -> bool:
        """Whether it may be written: what a wheel has brought stays as it is."""
        return self.file.parent != READY


def _name(function: Callable[..., Any], stamp: str, *processor: str) -> str:
    """Name of a kernel's file: of which kernel, as it is written, for which processor."""
    module = function.__module__.rpartition(".")[2]
    kernel = f"{module}.{function.__qualname__}".replace("<", "").replace(">", "")
    key = hashlib.sha256(repr((stamp, processor)).encode()).hexdigest()
    return f"{kernel}-{key[:32]}.py{sys.version_info[0]}{sys.version_info[1]}{sys.abiflags}.nbc"


def _age(file: Path) -> float:
    """Seconds since a file was written, or its use was noted."""
    return time.time() - file.stat().st_mtime
