"""Arrays that compiled code borrows, without counting references to them.

Numba counts the references to each array of a tuple at every call that it does not inline, and
counts atomically. Where tables of a dozen arrays go through millions of small functions that takes
most of the time. Whoever calls a kernel holds its arguments until it returns, so meanwhile nothing
needs to be counted.
"""

from __future__ import annotations

from typing import Any, TypeVar

from numba.core import cgutils, ir, types
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.untyped_passes import IRProcessing
from numba.extending import lower_builtin, register_jitable, type_callable

_T = TypeVar("_T")


def borrowed(value: _T) -> _T:
    """The same array, or tuple of arrays, to which compiled code counts no references.

    It must not be returned to Python, and its owner must outlive it; see :func:`held`.
    """
    return value


@register_jitable
def held(_: object) -> None:
    """Keep a value alive up to here: numba frees a variable after the last line that names it."""


@type_callable(borrowed)  # type: ignore[misc]
def _type_of_borrowed(_: Any) -> Any:
    return _same_type


def _same_type(value: Any) -> Any:
    return value


@lower_builtin(borrowed, types.Any)  # type: ignore[misc]
def _lower_borrowed(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return _without_owner(context, builder, signature.args[0], arguments[0])


def _without_owner(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """The value with no owner at any of its arrays; to nothing numba counts no references."""
    if isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder, value)
        array.meminfo = cgutils.get_null_value(array.meminfo.type)
        array.parent = cgutils.get_null_value(array.parent.type)
        return array._getvalue()
    if isinstance(kind, types.BaseTuple):
        for k, field in enumerate(kind.types):
            inner = builder.extract_value(value, k)
            value = builder.insert_value(value, _without_owner(context, builder, field, inner), k)
    return value


@register_pass(mutates_CFG=False, analysis_only=False)  # type: ignore[misc]
class _BorrowArguments(FunctionPass):  # type: ignore[misc]
    """Puts ``x = borrowed(x)`` for each argument x at the beginning of a function."""

    _name = "borrow_arguments"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        first = state.func_ir.blocks[min(state.func_ir.blocks)]
        body = []
        for line in first.body:
            body.append(line)
            if isinstance(line, ir.Assign) and isinstance(line.value, ir.Arg):
                function = first.scope.redefine("$borrowed", line.loc)
                body.append(
                    ir.Assign(ir.Global("borrowed", borrowed, line.loc), function, line.loc)
                )
                call = ir.Expr.call(function, [line.target], (), line.loc)
                body.append(ir.Assign(call, line.target, line.loc))
        first.body = body
        return True


class Borrowing(CompilerBase):  # type: ignore[misc]
    """Numba's compiler of a kernel, which borrows its arguments."""

    def define_pipelines(self) -> list[Any]:
        """Numba's own passes and that one."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.add_pass_after(_BorrowArguments, IRProcessing)
        passes.finalize()
        return [passes]
