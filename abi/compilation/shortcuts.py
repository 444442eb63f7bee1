"""Shortcuts through numba's compiler, which change nothing of what kernels compute.

Of the time that numba takes for kernels, it spends half on questions that it has answered before,
on answers that nobody reads, and on code of which LLVM leaves nothing. Functions of numba's own
that kernels call it translates by themselves, as it would helpers. A process that does nothing but
compile takes shortcuts instead (:func:`take`). They rest on parts of numba that it may change in
any version, so they are taken only with those that the tests have seen.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any

from llvmlite.binding.ffi import _LLVMLock  # type: ignore[import-untyped]
from llvmlite.binding.newpassmanagers import (  # type: ignore[import-untyped]
    create_new_function_pass_manager,
)
from numba.core import base, ir, postproc, transforms
from numba.core.base import BaseContext
from numba.core.codegen import CPUCodeLibrary, _parse_refprune_flags
from numba.core.runtime.context import NRTContext
from numba.core.targetconfig import ConfigStack, TargetConfig
from numba.core.types.functions import BaseFunction
from numba.core.typing.templates import _OverloadFunctionTemplate
from numba.np import linalg

from abi.compilation import array_elements, helpers
from abi.compilation.counters import places_of_counters
from abi.compilation.variables import VALUES


def take() -> None:
    """Take them from now on, in all that this process compiles."""
    if helpers.is_known():
        for (owner, name), shortcut in (SHORTCUTS | OVERLOADS).items():
            setattr(owner, name, shortcut)


def _hash_of_options(options: TargetConfig) -> int:
    """Hash of the names that are set, of which there are few; numba's is of all values."""
    return hash(frozenset(options._values))


def _are_options_equal(options: Any, other: Any) -> bool:
    if type(other) is not type(options):
        return False
    return bool(options._values == other._values or options.values() == other.values())


_call_type: Any = BaseFunction.get_call_type


def _known_call_type(function: Any, context: Any, arguments: Any, keywords: Any) -> Any:
    """Type of a call of numba's own functions and operators, sought once for its arguments."""
    options = ConfigStack.top_or_none()  # type: ignore[no-untyped-call]
    call = context, arguments, tuple(keywords.items()), options
    known = function.__dict__.setdefault("_known_call_types", {})
    if call not in known:
        found = _call_type(function, context, arguments, keywords)
        known[call] = found, function._impl_keys[found.args]
    found, implementation = known[call]
    function._impl_keys[found.args] = implementation  # other options may have chosen another
    return found


def _variables_of_statement(statement: ir.Stmt) -> list[ir.Var]:
    return _variables(statement.__dict__.values(), [])


def _variables_of_expression(expression: ir.Expr) -> list[ir.Var]:
    return _variables(expression._kws.values(), [])


def _variables(values: Any, found: list[ir.Var]) -> list[ir.Var]:
    """Append the variables among values, and in lists and statements among them."""
    for value in values:
        kind = type(value)
        if kind is ir.Var:
            found.append(value)
        elif kind in _WITHOUT_VARIABLES:
            continue
        elif isinstance(value, ir.Inst):
            found += value.list_vars()  # type: ignore[no-untyped-call]
        elif isinstance(value, (list, tuple)):
            _variables(value, found)
        elif isinstance(value, dict):
            _variables(value.values(), found)
    return found


_WITHOUT_VARIABLES = frozenset((str, int, bool, type(None), ir.Loc, ir.Scope))
"""Kinds of most values that are no variable."""


_process_again: Any = postproc.PostProcessor.run


def _process_without_lifetimes(
    processor: postproc.PostProcessor, emit_dels: bool = False, extend_lifetimes: bool = False
) -> None:
    """Bring a function's blocks in order; where variables live only if it is asked for.

    Numba does this eight times for each function, and needs the lifetimes once.
    """
    function: Any = processor.func_ir
    if emit_dels or function.is_generator:
        _process_again(processor, emit_dels, extend_lifetimes)
        return
    function.blocks = transforms.canonicalize_cfg(function.blocks)  # type: ignore[no-untyped-call]
    function.variable_lifetime = postproc.VariableLifetime(function.blocks)  # type: ignore[no-untyped-call]
    function.generator_info = None


_count: Any = NRTContext._call_incref_decref


def _count_what_is_counted(
    runtime: Any, builder: Any, kind: Any, value: Any, function_name: str
) -> None:
    """Count references of the arrays in a value, without taking apart the rest of it."""
    known = runtime.__dict__.setdefault("_places_of_counters", {})
    if kind not in known:
        known[kind] = places_of_counters(runtime._context.data_model_manager, kind)
    for place, counted in known[kind]:
        part = builder.extract_value(value, place) if place else value
        _count(runtime, builder, counted, part, function_name)


def _optimise_bodies(library: CPUCodeLibrary, module: Any) -> None:
    """Shorten the functions of a module, except those that it only declares.

    Numba has LLVM do all that it can for a function here, and again for each kernel that it becomes
    part of.
    """
    codegen: Any = library._codegen
    module.data_layout = codegen._data_layout
    builder = codegen._pass_builder()
    passes = create_new_function_pass_manager()
    passes.add_sroa_pass()
    passes.add_simplify_cfg_pass()
    passes.add_instruction_combine_pass()
    passes.add_refprune_pass(_parse_refprune_flags())  # type: ignore[no-untyped-call]
    for function in module.functions:
        if not function.is_declaration:
            passes.run(function, builder)


_implementation: Any = BaseContext.get_function


def _implementation_of(context: Any, function: Any, signature: Any, **first: bool) -> Any:
    """What makes the code of a call; that of an array's element is shorter than numba's."""
    access = array_elements.access_of(function, signature)
    if access is None:
        return _implementation(context, function, signature, **first)
    return base._wrap_impl(access, context, signature)  # type: ignore[no-untyped-call]


_size: Any = BaseContext.get_abi_sizeof
_sizes: dict[tuple[str, str], int] = {}


def _known_size(context: Any, kind: Any) -> int:
    """Size of a type of LLVM's, for which numba has LLVM parse a module each time."""
    key = str(kind), str(context.target_data)
    if key not in _sizes:
        _sizes[key] = _size(context, kind)
    return _sizes[key]


def _enter(lock: Any) -> None:
    lock._lock.acquire()


def _leave(lock: Any, *_: object) -> None:
    lock._lock.release()


def _without_blas() -> None:
    """Have numba leave out linear algebra, for which it would import that of scipy."""
    raise ImportError("kernels have no linear algebra")


SHORTCUTS: dict[tuple[Any, str], Any] = {
    (TargetConfig, "__hash__"): _hash_of_options,
    (TargetConfig, "__eq__"): _are_options_equal,
    (BaseFunction, "get_call_type"): _known_call_type,
    (ir.Stmt, "list_vars"): _variables_of_statement,
    (ir.Expr, "list_vars"): _variables_of_expression,
    (postproc.PostProcessor, "run"): _process_without_lifetimes,
    (NRTContext, "_call_incref_decref"): _count_what_is_counted,
    (BaseContext, "get_abi_sizeof"): _known_size,
    (BaseContext, "get_function"): _implementation_of,
    (base, "_has_loc"): cache(base._has_loc),
    (linalg, "ensure_blas"): _without_blas,
    # no events for clocks that nobody reads
    (_LLVMLock, "__enter__"): _enter,
    (_LLVMLock, "__exit__"): _leave,
}
"""What stands for each method of numba's; the machine code of all kernels stays the same."""


_jit_decorator: Any = _OverloadFunctionTemplate._get_jit_decorator


def _decorator_of_helpers(template: Any) -> Callable[..., Any]:
    """Numba's decorator of the functions that it has for numpy's and Python's: they are helpers."""
    return partial(_jit_decorator(template), **helpers.PIPELINE)


OVERLOADS: dict[tuple[Any, str], Any] = {
    (_OverloadFunctionTemplate, "_get_jit_decorator"): _decorator_of_helpers,
    (CPUCodeLibrary, "_optimize_functions"): _optimise_bodies,
    **VALUES,
}
"""The same where kernels compute the same, but may be inlined in another order."""
