"""Arrays that kernels borrow: the same results, no owner needed, and none handed back."""

from __future__ import annotations

import ast
import inspect
import sys
import textwrap
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pytest

from abi import compiling
from abi.arrays import FloatArray
from abi.compilation.borrowed import borrowed, held
from abi.compilation.callees import compiled_with
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, KERNELS, NEW_FLOATS, Kernel, compiled


class Tables(NamedTuple):
    values: FloatArray
    inner: tuple[FloatArray, int]


@jitable
def weight(tables: Tables, i: int) -> float:
    share: float = tables.values[i % len(tables.values)] * tables.inner[0][i % 2]
    return share if i % 3 else -share


def weighed(tables: Tables, found: Any) -> Any:
    own = np.arange(4.0)
    room = borrowed(own)
    total = np.zeros(2)
    for i in range(len(found)):
        found[i] = weight(tables, i) + room[i % 4]
        total[i % 2] += found[i] + tables.inner[1]
    held(own)
    return total


@pytest.fixture
def kernel() -> Iterator[Kernel[..., Any]]:
    example = (Tables(FLOATS, (FLOATS, 1)), NEW_FLOATS)
    made = compiled(example=example)(weighed)
    yield made
    del KERNELS[made.name]


def test_a_kernel_that_borrows_does_the_same_and_leaves_the_counts_alone(
    kernel: Kernel[..., Any],
) -> None:
    random = np.random.default_rng(0)
    values, shares = random.normal(size=7), random.normal(size=2)
    values.setflags(write=False)
    shares.setflags(write=False)
    tables = Tables(values, (shares, 3))
    before, expected = np.zeros(50), weighed(tables, found := np.zeros(50))
    kernel.compile()
    counts = [sys.getrefcount(array) for array in (values, shares, before)]
    for _ in range(100):
        totals = kernel(tables, before)
        np.testing.assert_allclose(totals, expected, rtol=1e-12)
    np.testing.assert_array_equal(before, found)
    assert totals.flags.owndata or totals.base is not None
    assert counts == [sys.getrefcount(array) for array in (values, shares, before)]


@jitable
def last_of(parts: tuple[FloatArray, list[int]], chosen: FloatArray, found: list[int]) -> float:
    numbers, places = parts
    found.append(places[-1])
    chosen = chosen[places[-1] :]
    total: float = numbers[places[-1]] + chosen[0]
    return total


def summed(found: Any) -> Any:
    own, places, kept = np.arange(50.0), [0] * 0, [0]
    for i in range(len(found)):
        places.append(i)
        found[i] = last_of((own, places), own, kept)
    return np.array(places + kept)


def test_a_helper_that_borrows_arrays_leaves_lists_as_they_are() -> None:
    kernel = compiled(example=(NEW_FLOATS,))(summed)
    try:
        expected = summed(before := np.zeros(50))
        kernel.compile()
        for _ in range(200):
            found = np.zeros(50)
            np.testing.assert_array_equal(kernel(found), expected)
            np.testing.assert_array_equal(found, before)
    finally:
        del KERNELS[kernel.name]


def _handed_back(value: ast.expr | None) -> Iterator[str]:
    """Names of the variables, or of what is cut from them, in what a function returns."""
    if isinstance(value, ast.Name):
        yield value.id
    elif isinstance(value, (ast.Subscript, ast.Attribute)):
        yield from _handed_back(value.value)
    elif isinstance(value, ast.Tuple):
        for item in value.elts:
            yield from _handed_back(item)


def _flat_arrays(value: ast.expr | None) -> Iterator[str]:
    """Those of them that are, or are cut from, flat arrays, of which an item is a number."""
    if isinstance(value, ast.Tuple):
        for item in value.elts:
            yield from _flat_arrays(item)
    elif not isinstance(value, ast.Subscript) or isinstance(value.slice, ast.Slice):
        yield from _handed_back(value)


def test_no_helper_hands_back_an_array_that_it_borrows() -> None:
    # it would be freed with its owner, whoever has it then
    kernels, returned = compiling.all_kernels(), 0
    for helper in {one for kernel in kernels for one in compiled_with(kernel.py_func)}:
        names = inspect.signature(helper).parameters.values()
        arrays = {one.name for one in names if str(one.annotation).endswith("Array")}
        tree = ast.parse(textwrap.dedent(inspect.getsource(helper)))
        for line in ast.walk(tree):
            if isinstance(line, ast.Return):
                assert not arrays & set(_flat_arrays(line.value)), helper
                returned += 1
    assert returned > 100


def test_no_kernel_hands_back_what_it_borrows() -> None:
    # nothing would keep such an array alive
    for kernel in compiling.all_kernels():
        function = kernel.py_func
        names = inspect.signature(function).parameters
        of_arrays = {
            name
            for name, example in zip(names, kernel.example, strict=True)
            if isinstance(example, (np.ndarray, tuple))
        }
        tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
        for line in ast.walk(tree):
            if isinstance(line, ast.Return):
                assert not of_arrays & set(_handed_back(line.value)), kernel.name
