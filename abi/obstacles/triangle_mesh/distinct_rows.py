"""Search for equal rows of a table by sorting a hash of each row."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from abi.arrays import BoolArray, FloatArray, IntArray

_MULTIPLIERS = (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9)
"""Odd numbers that spread bits: the golden ratio's, and two primes of xxHash (Collet, 2012)."""


def in_groups(keys: NDArray[np.int64]) -> tuple[NDArray[np.int64], BoolArray]:
    """Order (n,) that groups equal numbers (n,) from 0 on, and flags of the first in each group.

    Equal numbers stay in their order.
    """
    bits = len(keys).bit_length()
    if int(keys.max(initial=0)) >> (63 - bits):
        order = np.argsort(keys, kind="stable")
        in_order = keys[order]
    else:
        # one sort of numbers that end in their places takes a fraction of one of places
        packed = np.sort((keys << bits) | np.arange(len(keys)))
        order, in_order = packed & ((1 << bits) - 1), packed >> bits
    is_first = np.ones(len(keys), dtype=np.bool_)
    is_first[1:] = in_order[1:] != in_order[:-1]
    return order, is_first


def distinct_rows(rows: FloatArray) -> tuple[IntArray, IntArray]:
    """Index (k,) of the first of each distinct row of (n, m), and the number (n,) of every row.

    Like ``numpy.unique`` along an axis, but many times as fast. No row may contain -0.0.
    """
    order, is_first = _groups(rows)
    first = order[is_first]
    sorted_ = np.lexsort(rows[first].T[::-1])
    rank = np.empty(len(first), dtype=np.int32)
    rank[sorted_] = np.arange(len(first), dtype=np.int32)
    numbers = np.empty(len(rows), dtype=np.int32)
    numbers[order] = rank[np.cumsum(is_first) - 1]
    return first[sorted_].astype(np.int32), numbers


def first_of_distinct_rows(rows: NDArray[Any]) -> NDArray[np.int64]:
    """Index (k,) of the first of each distinct row of (n, m), ascending."""
    order, is_first = _groups(rows)
    return np.sort(order[is_first])


def in_rows(rows: NDArray[Any], others: NDArray[Any]) -> BoolArray:
    """Mask (n,) of the rows (n, m) that are among others (k, m)."""
    both = np.concatenate([others, rows]).astype(np.int64)
    order, is_first = _groups(both)
    # equal rows stay in their order, so that one of the others comes first
    leader = order[is_first][np.cumsum(is_first) - 1]
    found = np.empty(len(both), dtype=np.bool_)
    found[order] = leader < len(others)
    return found[len(others) :]


def _groups(rows: NDArray[Any]) -> tuple[NDArray[np.int64], BoolArray]:
    """Groups of equal rows; see :func:`in_groups`."""
    for multiplier in _MULTIPLIERS:
        order, is_first = in_groups(_hashed(rows, multiplier))
        repeats = np.flatnonzero(~is_first)
        if np.array_equal(rows[order[repeats]], rows[order[repeats - 1]]):
            return order, is_first
    # different rows had the same number each time: a file made for it
    order = np.lexsort(rows.T[::-1])
    in_order = rows[order]
    is_first = np.ones(len(rows), dtype=np.bool_)
    is_first[1:] = (in_order[1:] != in_order[:-1]).any(axis=1)
    return order, is_first


def _hashed(rows: NDArray[Any], multiplier: int) -> NDArray[np.int64]:
    """A number (n,) of each row (n, m) of 64 bits a number; different rows may have the same one.

    It leaves as many bits as :func:`in_groups` takes for places.
    """
    factor = np.uint64(multiplier)
    hashed = np.zeros(len(rows), dtype=np.uint64)
    for column in np.ascontiguousarray(rows.T).view(np.uint64):
        hashed = (hashed ^ column) * factor
        hashed ^= hashed >> np.uint64(32)
    return ((hashed * factor) >> np.uint64(len(rows).bit_length() + 1)).astype(np.int64)
