"""Shortcuts through numba's compiler: the same machine code, in less time."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, cast

import numba
import numpy as np
import pytest
from numba.core import runtime as numba_runtime

from abi.arrays import FloatArray
from abi.compilation import shortcuts
from abi.compilation.dispatcher import compile_once, make_dispatcher
from abi.compilation.helpers import is_known
from abi.compilation.jitable import jitable
from abi.compiled import NEW_FLOATS


def make_kernel() -> Callable[[FloatArray, int], float]:
    """A new function each time, since numba remembers what it has compiled."""

    def kernel(numbers: FloatArray, count: int) -> float:
        found = [(0, 0.0)]
        last = np.empty(len(numbers), np.int32)
        for i in range(len(last)):
            last[-1 - i] = i + (last[-i] if i > 0 else 0)
        squares = np.empty((count, 2))
        for i in range(count):
            pair = abs(numbers[i]) ** 0.5, max(numbers[i], 1.0) // 3.0
            squares[i, 0], squares[i, 1] = pair
            if pair[0] > 2.0 and not pair[1] < 1.0:
                found.append((i, -pair[0]))
        parts = last, (np.empty(count), 0)
        for i in range(count):
            fresh = np.empty(count)
            fresh[i] = squares[i, 0]
            parts = last, (fresh, i)
        best = found.pop()
        while len(found) > 1:
            other = found.pop()
            best = other if other[1] < best[1] else best
        one = parts[1][0][parts[1][1]]
        return float(last[0] + one + best[1] * best[0] + squares[:count].sum())

    return kernel


def machine_code() -> list[str]:
    """Instructions of the kernel, without the names, which numba numbers."""
    njit: Any = numba.njit
    compiled = njit(error_model="numpy", no_cfunc_wrapper=True)(make_kernel())
    compiled.compile((numba.float64[::1], numba.int64))
    [code] = compiled.inspect_asm().values()
    names = re.compile(r"[.\w]*(_ZN|_ZZ|numba|\.const)[$.@\w]*|\.L\w+|#.*")
    lines = (names.sub("NAME", line).split() for line in code.splitlines() if line[:1] == "\t")
    return [" ".join(line) for line in lines if not line[0].startswith(".")]


def use(monkeypatch: pytest.MonkeyPatch, kinds: dict[tuple[Any, str], Any]) -> None:
    for (owner, name), shortcut in kinds.items():
        monkeypatch.setattr(owner, name, shortcut)


@pytest.mark.slow
def test_machine_code_is_the_same_with_shortcuts(monkeypatch: pytest.MonkeyPatch) -> None:
    assert is_known()
    usual = machine_code()
    assert len(usual) > 100
    use(monkeypatch, shortcuts.SHORTCUTS)
    assert machine_code() == usual
    assert machine_code() == usual  # with what it knows by now


def test_kernels_compute_the_same_where_numbas_functions_are_helpers(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    numbers = np.random.default_rng(0).uniform(-90, 90, 50)
    usual: Any = numba.njit(make_kernel())
    expected = usual(numbers, 50)
    use(monkeypatch, shortcuts.SHORTCUTS | shortcuts.OVERLOADS)
    # other types of numbers, so that numba has none of its functions for them yet
    compiled: Any = numba.njit(make_kernel())
    assert compiled(numbers.astype(np.float32).astype(float)[::1], 50) == pytest.approx(expected)
    assert compiled(numbers, 50) == expected
    with pytest.raises(ValueError, match="negative dimensions"):
        compiled(numbers, -1)


def make_lender() -> Callable[[FloatArray, int], Any]:
    """A new function each time, which lends arrays and lists to a helper."""

    @jitable
    def part(tables: Any, lists: Any, i: int) -> float:
        numbers, (inner, share) = tables
        last, seen = numbers, lists[0]
        if i % 2:
            last, seen = inner, lists[1]
        seen.append(i)
        while share > 2.0 * len(seen):
            share -= last[i % len(last)]
            last = tables[1][0]
        return float(last[i % len(last)] + len(lists[1]) + share)

    def lender(numbers: FloatArray, count: int) -> Any:
        lists, total = ([0] * 0, [0]), 0.0
        for i in range(count):
            fresh = np.full(3, 1.0 + i)
            total += part((numbers, (fresh, float(i))), lists, i)
            lists = (lists[1], lists[0]) if i % 3 else lists
        return total, np.array(lists[0] + lists[1])

    return lender


def test_all_that_is_lent_is_counted_neither_too_often_nor_too_seldom(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    use(monkeypatch, shortcuts.SHORTCUTS | shortcuts.OVERLOADS)
    lender, numbers = make_lender(), np.arange(1.0, 6.0)
    kernel = make_dispatcher(lender, (NEW_FLOATS, 1), {})
    compile_once(kernel, (NEW_FLOATS, 1))
    expected, runtime = lender(numbers, 40), cast(Any, numba_runtime)
    runtime._nrt_python.memsys_enable_stats()
    before = runtime.rtsys.get_allocation_stats()
    for _ in range(100):
        total, places = kernel(numbers, 40)
        assert total == expected[0]
        np.testing.assert_array_equal(places, expected[1])
    del places
    after = runtime.rtsys.get_allocation_stats()
    runtime._nrt_python.memsys_disable_stats()
    assert after.alloc - before.alloc == after.free - before.free >= 4_000
