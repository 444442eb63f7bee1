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


def _handed_back(value: ast.expr | None) -> Iterator[str]:
    """Names of the variables, or of what is cut from them, in what a function returns."""
    if isinstance(value, ast.Name):
        yield value.id
    elif isinstance(value, (ast.Subscript, ast.Attribute)):
        yield from _handed_back(value.value)
    elif isinstance(value, ast.Tuple):
        for item in value.elts:
            yield from _handed_back(item)


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
