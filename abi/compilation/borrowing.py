"""Numba's compiler, taught to borrow; see :mod:`abi.compilation.borrowed`."""

from __future__ import annotations

from typing import Any

from numba.core import ir, types
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.untyped_passes import IRProcessing
from numba.extending import lower_builtin, type_callable

from abi.compilation.borrowed import borrowed
from abi.compilation.counters import COUNTER, places_of_counters


@type_callable(borrowed)
def _type_of_borrowed(_: Any) -> Any:
    return lambda value: value


@lower_builtin(borrowed, types.Any)  # type: ignore[no-untyped-call, untyped-decorator]
def _lower_borrowed(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    kind = signature.args[0]
    value = _without_owner(context, builder, kind, arguments[0])
    context.nrt.incref(builder, kind, value)  # of what is no array, such as lists
    return value


def _without_owner(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """The value with no owner at any of its arrays; to nothing numba counts no references."""
    for place, counted in places_of_counters(context.data_model_manager, kind):
        if counted is COUNTER:
            value = builder.insert_value(value, context.get_constant_null(counted), place)
    return value


def borrowing(passes: Any) -> Any:
    """Numba's passes for a function, which is to borrow its arguments, too; ready to be run."""
    passes.add_pass_after(_BorrowArguments, IRProcessing)
    passes.finalize()
    return passes


@register_pass(mutates_CFG=False, analysis_only=False)  # type: ignore[no-untyped-call]
class _BorrowArguments(FunctionPass):
    """Puts ``x = borrowed(x)`` for each argument x with arrays at the beginning of a function."""

    _name = "borrow_arguments"

    def __init__(self) -> None:
        super().__init__()  # type: ignore[no-untyped-call]

    def run_pass(self, state: Any) -> bool:
        first = state.func_ir.blocks[min(state.func_ir.blocks)]
        body = []
        for line in first.body:
            body.append(line)
            given = line.value if isinstance(line, ir.Assign) else None
            if isinstance(given, ir.Arg) and _has_arrays(state.args[given.index]):
                body += _borrow(line.target, first.scope, line.loc)
        first.body = body
        return True


def _has_arrays(kind: Any) -> bool:
    """Whether a value of this type is an array, or a tuple with one."""
    if isinstance(kind, types.BaseTuple):
        return any(map(_has_arrays, kind.types))  # type: ignore[attr-defined]
    return isinstance(kind, types.Array)


def _borrow(argument: Any, scope: Any, where: Any) -> list[Any]:
    """The lines that do it for one."""
    assign: Any = ir.Assign
    name, function, call = "borrowed", scope.redefine("$borrowed", where), ir.Expr.call
    return [
        assign(ir.Global(name, borrowed, where), function, where),  # type: ignore[no-untyped-call]
        assign(call(function, [argument], (), where), argument, where),  # type: ignore[no-untyped-call]
    ]
