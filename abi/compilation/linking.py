"""Helpers as libraries of numba's that are linked into a kernel once, whoever else calls them.

Numba's own library of a function brings along all that the function calls. So what many helpers
call would be copied from one to the next on all ways to the kernel.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from llvmlite.binding import Linkage  # type: ignore[import-untyped]
from numba.core.codegen import CPUCodeLibrary, JITCodeLibrary


class HelperLibrary(JITCodeLibrary):
    """A helper's code alone, neither optimised nor translated."""

    def finalize(self) -> None:
        """Make it ready to be linked."""
        for library in self._linking_libraries:
            self._reload_init.update(library._reload_init)
        self._finalize_dynamic_globals()  # type: ignore[no-untyped-call]
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == Linkage.external:
                function.linkage = Linkage.linkonce_odr
        self._shared_module = self._final_module
        self._finalized = True


def callers_first(libraries: Iterable[Any]) -> list[Any]:
    """Return libraries and all that the helpers among them call, each after all that call it.

    Of a library LLVM links only what is called by then.
    """
    found: dict[Any, None] = {}
    seen = set()

    def visit(library: Any) -> None:
        if library not in seen:
            seen.add(library)
            if isinstance(library, HelperLibrary):
                for called in library._linking_libraries:
                    visit(called)
            found[library] = None

    for library in libraries:
        visit(library)
    return list(found)[::-1]


_finalize: Any = CPUCodeLibrary.finalize


def _finalize_with_helpers(library: Any) -> None:
    called = library._linking_libraries
    if any(isinstance(one, HelperLibrary) for one in called):
        library._linking_libraries = callers_first(called)
    _finalize(library)


def link_what_helpers_call() -> None:
    """Have numba link with a helper what that calls, from now on."""
    CPUCodeLibrary.finalize = _finalize_with_helpers  # type: ignore[method-assign]
