"""Triangles of a mesh that rays from points meet, and boxes that overlap."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from abi.arrays import BoolArray, FloatArray, IntArray

_Numbers = NDArray[np.int64]
_CHUNK = 2_000_000
"""Most pairs of boxes that are compared at once."""
_FEW_PAIRS = 20_000
"""Pairs of boxes that are compared one by one."""
_WORTH = 0.8
"""Share of the pairs that has to be left for space to be halved again."""


def rays_met(
    corners: FloatArray, points: FloatArray, way: FloatArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Numbers (k,) of points, and of triangles that rays from them meet; 1, or -1 if from before.

    Args:
        corners: (m, 3, 3).
        points: (p, 3).
        way: direction (3,) of the rays.
    """
    first = np.cross(way, [0.0, 0.0, 1.0])
    across = np.stack([first, np.cross(way, first)])
    flat, places = corners @ across.T, points @ across.T
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    found = [np.zeros((3, 0), dtype=np.int64)]
    for point, face in near_boxes((places, places), (flat.min(axis=1), flat.max(axis=1))):
        triangles, at = flat[face], places[point]
        steep = normal[face] @ way
        within = np.einsum("ij,ij->i", corners[face, 0] - points[point], normal[face]) > 0
        within = within == (steep > 0)
        for k in range(3):
            within &= _left_of(triangles[:, k], triangles[:, (k + 1) % 3], at) == (steep > 0)
        found.append(np.stack([point, face, np.where(steep > 0, 1, -1)])[:, within])
    point, face, side = np.concatenate(found, axis=1)
    return point, face, side


def near_boxes(
    ones: tuple[FloatArray, FloatArray], others: tuple[FloatArray, FloatArray]
) -> Iterator[tuple[_Numbers, _Numbers]]:
    """Numbers of boxes and of other boxes that overlap them, each pair once, some at a time.

    Space is halved until few are in each part, so that what is small is found fast in what is
    large. A pair is told in the part in which the lowest corner is that is in both.

    Args:
        ones: low and high corners (p, d), of any d.
        others: low and high corners (m, d).
    """
    axes = ones[0].shape[1]
    everywhere = np.full(axes, -np.inf), np.full(axes, np.inf)
    first, second = (np.arange(len(boxes[0]), dtype=np.int64) for boxes in (ones, others))
    waiting = [(first, second, everywhere)]
    while waiting:
        a, b, (low, high) = waiting.pop()
        cut = None if len(a) * len(b) <= _FEW_PAIRS else _cut(ones, others, a, b)
        if cut is None:
            yield from _overlapping(ones, others, a, b, (low, high))
            continue
        axis, at = cut
        below, above = high.copy(), low.copy()
        below[axis] = above[axis] = at
        for part, side in (((low, below), -1), ((above, high), 1)):
            near = [
                rows[boxes[0][rows, axis] < at if side < 0 else boxes[1][rows, axis] >= at]
                for rows, boxes in ((a, ones), (b, others))
            ]
            if len(near[0]) and len(near[1]):
                waiting.append((near[0], near[1], part))


def _cut(
    ones: tuple[FloatArray, FloatArray],
    others: tuple[FloatArray, FloatArray],
    a: _Numbers,
    b: _Numbers,
) -> tuple[int, float] | None:
    """Axis and place that part two sets of boxes best; None where that saves little."""
    best, least = None, _WORTH * len(a) * len(b)
    for axis in range(ones[0].shape[1]):
        lows, highs = (
            [boxes[side][rows, axis] for rows, boxes in ((a, ones), (b, others))] for side in (0, 1)
        )
        at = float(np.median(np.concatenate(lows) + np.concatenate(highs))) / 2
        pairs = math.prod(int((one < at).sum()) for one in lows)
        pairs += math.prod(int((one >= at).sum()) for one in highs)
        if pairs < least:
            best, least = (axis, at), float(pairs)
    return best


def _overlapping(
    ones: tuple[FloatArray, FloatArray],
    others: tuple[FloatArray, FloatArray],
    a: _Numbers,
    b: _Numbers,
    part: tuple[FloatArray, FloatArray],
) -> Iterator[tuple[_Numbers, _Numbers]]:
    """Pairs of boxes that overlap, and whose lowest common corner is in a part of space."""
    step = max(_CHUNK // max(len(b), 1), 1)
    for begin in range(0, len(a), step):
        rows = a[begin : begin + step, None]
        near = np.ones((len(rows), len(b)), dtype=np.bool_)
        for axis in range(ones[0].shape[1]):
            low = np.maximum(ones[0][rows, axis], others[0][b, axis])
            near &= low <= np.minimum(ones[1][rows, axis], others[1][b, axis])
            near &= (low >= part[0][axis]) & (low < part[1][axis])
        one, other = np.nonzero(near)
        yield a[begin + one], b[other]


def _left_of(a: FloatArray, b: FloatArray, at: FloatArray) -> BoolArray:
    """Whether points (k, 2) are left of lines from a (k, 2) to b; the same from b to a is not."""
    swapped = (a[:, 0] > b[:, 0]) | ((a[:, 0] == b[:, 0]) & (a[:, 1] > b[:, 1]))
    one, other = np.where(swapped[:, None], b, a), np.where(swapped[:, None], a, b)
    d, e = other - one, at - one
    return np.asarray((d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0] > 0) != swapped)
