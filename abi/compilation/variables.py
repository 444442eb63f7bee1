"""Variables of compiled functions, kept as values wherever memory for them would do no more.

Numba gives each variable that more than one block uses a place in memory, writes it anew when it is
no longer used, and counts references to the arrays in it, which LLVM then has to find out to be of
no use. But whoever calls a function holds its arguments meanwhile, and so all that is in them:
there is nothing to count. And a variable that is assigned once, before all that use it, is a value.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from numba.core import ir, types
from numba.core.analysis import compute_cfg_from_blocks, compute_use_defs, must_use_alloca
from numba.core.lowering import Lower

from abi.compilation.borrowed import borrowed
from abi.compilation.counters import COUNTER, places_of_counters

_AssignedOnce = dict[str, tuple[int, Any]]
"""Block and value of each variable that one line assigns."""
_PARTS = ("getattr", "static_getitem", "exhaust_iter")
"""Numba's names for what takes a part of a tuple."""


def _assigned_once(blocks: dict[int, Any]) -> _AssignedOnce:
    """Return the variables that one line assigns, each with the block and the value there."""
    found: _AssignedOnce = {}
    several = set()
    for label, block in blocks.items():
        for line in block.find_insts(ir.Assign):
            name = line.target.name
            if name in found:
                several.add(name)
            found[name] = label, line.value
    return {name: where for name, where in found.items() if name not in several}


def _held(lower: Lower, once: _AssignedOnce) -> frozenset[str]:
    """Return the variables that hold what somebody else holds as long as they are used."""
    blocks = lower.func_ir.blocks.values()
    handed_back = (line.value.name for block in blocks for line in block.find_insts(ir.Return))
    known = dict.fromkeys(handed_back, False)
    return frozenset(name for name in once if _is_held(name, lower, once, known))


def _is_held(name: str, lower: Lower, once: _AssignedOnce, known: dict[str, bool]) -> bool:
    """Check that of one variable; ``known`` are the answers so far."""
    if name not in known:
        known[name] = False  # while it is being asked
        known[name] = name in once and _holds(name, lower, once, known)
    return known[name]


def _holds(name: str, lower: Lower, once: _AssignedOnce, known: dict[str, bool]) -> bool:
    """Check whether somebody else holds the value that is assigned to a variable."""
    value = once[name][1]
    if isinstance(value, ir.Arg):
        kind = lower.typeof("arg." + value.name)  # type: ignore[no-untyped-call]
        return not isinstance(kind, types.Omitted)
    if isinstance(value, ir.Var):
        return _is_held(value.name, lower, once, known)
    if not isinstance(value, ir.Expr):
        return False
    if value.op == "call":
        called = once.get(value.func.name, (0, None))[1]
        if not isinstance(called, ir.Global) or called.value is not borrowed:
            return False
        lent = _is_held(value.args[0].name, lower, once, known)
        return lent or _has_only_arrays(lower, name)
    if value.op not in _PARTS:
        return False
    if value.op == "static_getitem" and not isinstance(value.index, int):
        return False
    whole = value.value.name
    kind = lower.typeof(whole)  # type: ignore[no-untyped-call]
    return isinstance(kind, types.BaseTuple) and _is_held(whole, lower, once, known)


def _has_only_arrays(lower: Lower, name: str) -> bool:
    """Check whether nothing but arrays would be counted, which have no counter once lent."""
    models, kind = lower.context.data_model_manager, lower.typeof(name)  # type: ignore[no-untyped-call]
    return all(counted is COUNTER for _, counted in places_of_counters(models, kind))


_find_values: Any = Lower._find_singly_assigned_variable


def _find_more_values(lower: Any) -> None:
    """Find the variables that are values, and those of which nothing is counted."""
    _find_values(lower)
    blocks = lower.func_ir.blocks
    lower._held, lower._uncounted = frozenset(), frozenset()
    if lower.func_ir.func_id.is_generator:
        return
    once = _assigned_once(blocks)
    lower._held = _held(lower, once)
    models = lower.context.data_model_manager
    lines = (line for block in blocks.values() for line in block.find_insts(ir.Assign))
    lower._uncounted = lower._held | {
        name
        for name in {line.target.name for line in lines}
        if not models[lower.typeof(name)].contains_nrt_meminfo()
    }
    in_memory = lower._singly_assigned_vars | must_use_alloca(blocks)  # type: ignore[no-untyped-call]
    lower._singly_assigned_vars |= _values(blocks, once, lower._uncounted - in_memory)


def _values(blocks: dict[int, Any], once: _AssignedOnce, names: Iterable[str]) -> set[str]:
    """Return those of some variables that are assigned once, before all blocks that use them."""
    users: dict[str, list[int]] = {}
    for label, used in compute_use_defs(blocks).usemap.items():  # type: ignore[no-untyped-call]
        for name in used:
            users.setdefault(name, []).append(label)
    before = compute_cfg_from_blocks(blocks).dominators()  # type: ignore[no-untyped-call]

    def is_before(label: int, user: int) -> bool:
        return label < user and label in before[user]  # blocks are translated in their order

    return {
        name
        for name in names
        if name in once and all(is_before(once[name][0], user) for user in users.get(name, ()))
    }


_assigned: Any = Lower.lower_assign


def _assigned_uncounted(lower: Any, kind: Any, line: Any) -> Any:
    """Value of a line that assigns it, which numba counts unless the variable is held."""
    if line.target.name not in lower._held:
        return _assigned(lower, kind, line)
    context = lower.context
    counts = context.enable_nrt
    context.enable_nrt = False
    try:
        return _assigned(lower, kind, line)
    finally:
        context.enable_nrt = counts


_store: Any = Lower.storevar


def _store_uncounted(lower: Any, value: Any, name: str, argidx: int | None = None) -> None:
    """Assign a value, without looking at what the variable was where that is not counted."""
    if name not in lower._uncounted:
        _store(lower, value, name, argidx)
    elif name in lower._singly_assigned_vars:
        lower._blk_local_varmap[name] = value
    else:
        lower.builder.store(value, lower.getvar(name))


_delete: Any = Lower.delvar


def _delete_counted(lower: Any, name: str) -> None:
    """Give up a variable, of which nothing is left to do where it is not counted."""
    if name not in lower._uncounted:
        _delete(lower, name)


VALUES: dict[tuple[Any, str], Any] = {
    (Lower, "_find_singly_assigned_variable"): _find_more_values,
    (Lower, "lower_assign"): _assigned_uncounted,
    (Lower, "storevar"): _store_uncounted,
    (Lower, "delvar"): _delete_counted,
}
"""What stands for each method of numba's."""
