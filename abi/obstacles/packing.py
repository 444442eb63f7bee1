"""Convex primitives packed into the rows of numbers that the kernels take."""

from __future__ import annotations

import threading
from collections.abc import Iterable

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.obstacles.convex_shape import row
from abi.obstacles.per_shape import CROWD
from abi.obstacles.primitive_kernels import WIDTH
from abi.obstacles.primitive_tree_kernels import TREE, link
from abi.obstacles.primitives import Primitive


def pack(primitives: tuple[Primitive, ...]) -> FloatArray:
    """Rows of k primitives and their tree, flat (k ``WIDTH``,); see ``primitive_kernels``."""
    if len(primitives) < CROWD:
        rows = np.zeros((len(primitives), WIDTH))
        changed: Iterable[int] = range(len(primitives))
    else:
        rows, changed = _of_last(primitives)
    for k in changed:
        rows[k, :TREE] = row(primitives[k])
    packed = rows.ravel()
    if len(rows):
        link(packed)
    packed = read_only(packed)
    if len(primitives) >= CROWD:
        others = [one for one in _crowds() if len(one[0]) != len(primitives)]
        _memory.crowds = ((primitives, packed), *others[:2])
    return packed


_memory = threading.local()
"""Each thread's latest crowds with their rows: primitives, the boxes of meshes, and both."""


def _crowds() -> tuple[tuple[tuple[Primitive, ...], FloatArray], ...]:
    return getattr(_memory, "crowds", ())


def _of_last(primitives: tuple[Primitive, ...]) -> tuple[FloatArray, list[int]]:
    """Rows (k, ``WIDTH``) of the latest crowd of that size, and which primitives changed.

    By identity: to compare by value, or to hash, takes longer than all else of a drag.
    """
    for before, packed in _crowds():
        if len(before) == len(primitives):
            pairs = enumerate(zip(primitives, before, strict=True))
            changed = [k for k, (now, then) in pairs if now is not then]
            return packed.reshape(-1, WIDTH).copy(), changed
    return np.zeros((len(primitives), WIDTH)), list(range(len(primitives)))
