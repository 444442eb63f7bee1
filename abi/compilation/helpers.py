"""Numba's compiler of helpers, which does with each of them no more than a kernel needs.

Numba compiles a function anew for each set of options of its callers, optimises it by itself, and
translates it with all that it calls into machine code. A helper is linked into kernels, which are
optimised and translated as a whole. So here it is compiled once for each combination of types, and
ends as the code that numba has made of it. That halves the time that all kernels take. It borrows
its arguments as a kernel does, because numba would count each array of a tuple at every call.

This rests on parts of numba that it may change in any version, so it is done only with versions
that the tests have seen. With another one helpers are compiled as numba does by itself.
"""

from __future__ import annotations

from collections.abc import Callable
from inspect import unwrap
from typing import Any, cast

import numba
from numba import _dynfunc  # type: ignore[attr-defined]
from numba.core import types
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.extending import register_jitable

from abi.compilation.borrowing import borrowing
from abi.compilation.jitable import UNDECLARED, options_of
from abi.compilation.linking import HelperLibrary, link_what_helpers_call

VERSIONS = ("0.68",)
"""Versions of numba with which the tests have seen that it works."""


def declare_helpers() -> None:
    """Tell numba of the functions that kernels call, before it compiles anything that calls one."""
    while UNDECLARED:
        function = UNDECLARED.popleft()
        declare(function, options_of(function))


def declare(function: Callable[..., Any], options: dict[str, Any]) -> None:
    """Let kernels call a function, which stays as it is.

    Args:
        function: a function that numba can compile.
        options: those of :func:`numba.extending.register_jitable`.
    """
    if is_known() and "inline" not in options:  # that is done before anything is compiled
        jit = numba.njit(**(PIPELINE | _OPTIONS | options))
        _JITTED[function] = jit(unwrap(function))
        template = type(function.__name__, (_Calls,), {"key": function, "known": {}})
        infer_global(function, types.Function(template))  # type: ignore[no-untyped-call]
    else:
        register_jitable(**options)(function) if options else register_jitable(function)


def is_known(version: str = numba.__version__) -> bool:
    """Check whether a version of numba is one that the tests have seen."""
    return version.rpartition(".")[0] in VERSIONS


_OPTIONS: dict[str, Any] = {
    "no_cpython_wrapper": True,
    "error_model": "numpy",
    "forceinline": False,  # a helper would inherit it from its caller
}


_JITTED: dict[Callable[..., Any], Any] = {}
"""Numba's dispatcher of each helper."""


class _Calls(AbstractTemplate):
    """Types of a helper's calls; each combination is compiled when it is first met."""

    key: Callable[..., Any]
    known: dict[Any, Any]

    def generic(self, arguments: Any, keywords: Any) -> Any:
        given = *arguments, *keywords.items()
        if given not in self.known:  # numba asks several times for each call
            kind = types.Dispatcher(_JITTED[type(self).key])
            self.known[given] = kind.get_call_type(self.context, arguments, keywords)
        return self.known[given]

    def get_impl_key(self, signature: Any) -> Any:
        return _JITTED[type(self).key].get_overload(signature.args)


class _HelperCompiler(CompilerBase):
    def define_pipelines(self) -> list[Any]:
        link_what_helpers_call()
        state, library = self.state, cast(Any, HelperLibrary)
        state.library = library(state.targetctx.codegen(), state.func_id.func_qualname)
        # of a context for this function alone
        state.targetctx.get_executable = _without_code
        passes = DefaultPassBuilder.define_nopython_pipeline(state)  # type: ignore[no-untyped-call]
        return [borrowing(passes)]


def _without_code(library: HelperLibrary, description: Any, environment: Any) -> Any:
    """Numba's object of a compiled function, by which it finds the helper; it cannot be called."""
    name, nowhere = description.qualname, 0
    module = description.lookup_module()
    return _dynfunc.make_function(module, name, "", nowhere, environment, (library,))


PIPELINE: dict[str, Any] = {"pipeline_class": _HelperCompiler, "no_cfunc_wrapper": True}
"""Options with which numba compiles a function as a helper."""
