"""Equal rows, beside NumPy's slower way."""

from __future__ import annotations

import numpy as np
import pytest

from abi.obstacles.triangle_mesh import distinct_rows as module
from abi.obstacles.triangle_mesh.distinct_rows import (
    distinct_rows,
    first_of_distinct_rows,
    in_groups,
)

RNG = np.random.default_rng(3)
TABLES = {
    "vertices": RNG.normal(size=(300, 3))[RNG.integers(0, 300, 2000)],
    "whole numbers": RNG.integers(-3, 3, (500, 3)).astype(float),
    "all alike": np.ones((7, 3)),
    "one": np.zeros((1, 3)),
    "none": np.empty((0, 3)),
}


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("multipliers", [module._MULTIPLIERS, (0,)], ids=["spread", "all collide"])
def test_distinct_rows_are_those_that_numpy_finds(
    name: str, multipliers: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_MULTIPLIERS", multipliers)
    rows = TABLES[name]
    first, numbers = distinct_rows(rows)
    _, expected, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    np.testing.assert_array_equal(first, expected)
    np.testing.assert_array_equal(numbers, inverse.ravel())
    np.testing.assert_array_equal(first_of_distinct_rows(rows), np.sort(expected))


@pytest.mark.parametrize("largest", [5, 2**40, 2**62])
def test_equal_numbers_stay_in_their_order(largest: int) -> None:
    keys = RNG.integers(0, 6, 400) * (largest // 5)
    order, is_first = in_groups(keys)
    np.testing.assert_array_equal(order, np.argsort(keys, kind="stable"))
    np.testing.assert_array_equal(keys[order[is_first]], np.unique(keys))
