"""Boxes that overlap, against a comparison of all with all."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from abi.arrays import FloatArray
from abi.obstacles.triangle_mesh import rays
from abi.obstacles.triangle_mesh.rays import near_boxes


def boxes(random: np.random.Generator, axes: int) -> tuple[FloatArray, FloatArray]:
    """Up to 400 boxes, often with sides in common or flat, some of them far away."""
    low = random.normal(size=(random.integers(1, 400), axes)) + random.choice([0.0, 100.0])
    sides = random.choice([0.0, 0.1, 1.0]) * random.random(low.shape)
    digits = int(random.integers(1, 4))
    return np.round(low, digits), np.round(low, digits) + np.round(sides, digits)


@given(seed=st.integers(0, 10**6), axes=st.sampled_from([2, 3]))
def test_each_pair_is_told_once(seed: int, axes: int) -> None:
    random = np.random.default_rng(seed)
    ones, others = boxes(random, axes), boxes(random, axes)
    found = np.concatenate([np.stack(pair, axis=1) for pair in near_boxes(ones, others)])
    meet = (ones[0][:, None] <= others[1]) & (ones[1][:, None] >= others[0])
    np.testing.assert_array_equal(found[np.lexsort(found.T[::-1])], np.argwhere(meet.all(axis=2)))


def test_what_is_small_in_what_is_large_is_compared_with_its_neighbours() -> None:
    random, compared = np.random.default_rng(0), 0
    low = 0.1 * random.random((20_000, 3))
    low[::2] += 100.0
    corners = low, low + 0.001
    overlapping = rays._overlapping

    def counted(*arguments: Any) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
        nonlocal compared
        compared += len(arguments[2]) * len(arguments[3])
        return overlapping(*arguments)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rays, "_overlapping", counted)
        assert sum(len(one) for one, _ in near_boxes(corners, corners)) >= len(low)
    assert compared < 100 * rays._FEW_PAIRS * len(low) / 1000
