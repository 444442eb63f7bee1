"""Triangles of a mesh that rays from points meet, and boxes that overlap."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from abi.arrays import BoolArray, FloatArray, IntArray

_MOST_PLACED = 16
"""Most cells of a grid, for each triangle on average, that these are noted in."""
_CHUNK = 2_000_000
"""Most pairs of a point and a triangle that are in memory at once."""


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
) -> Iterator[tuple[IntArray, IntArray]]:
    """Numbers of boxes and of other boxes that overlap them, each pair once, some at a time.

    Args:
        ones: low and high corners (p, d), of any d of 2 or more.
        others: low and high corners (m, d).
    """
    lowest, highest = others[0].min(axis=0), others[1].max(axis=0)
    size = np.where(highest > lowest, highest - lowest, 1.0)
    for cells in (512, 256, 64, 16, 4, 1):
        (cell, other), (places, one) = (
            _placed(low, high, lowest, size, cells) for low, high in (others, ones)
        )
        if max(len(cell) / len(others[0]), len(places) / max(len(ones[0]), 1)) <= _MOST_PLACED:
            break
    order = np.argsort(cell, kind="stable")
    other, starts = other[order], np.searchsorted(cell[order], np.arange(cells**2 + 1))
    many = starts[places + 1] - starts[places]
    chunk = np.cumsum(many) // _CHUNK
    for rows in np.split(np.arange(len(places)), np.flatnonzero(np.diff(chunk)) + 1):
        row = np.repeat(rows, many[rows])
        step = np.arange(len(row)) - np.repeat(np.cumsum(many[rows]) - many[rows], many[rows])
        a, b = one[row], other[starts[places[row]] + step]
        for axis in reversed(range(len(size))):
            near = ones[0][a, axis] <= others[1][b, axis]
            near &= ones[1][a, axis] >= others[0][b, axis]
            row, a, b = row[near], a[near], b[near]
        # in the first of the cells that both are in
        low = np.maximum(ones[0][a, :2], others[0][b, :2])
        is_first = _cell(low, lowest, size, cells) == places[row]
        yield a[is_first], b[is_first]


def _cell(points: FloatArray, lowest: FloatArray, size: FloatArray, cells: int) -> IntArray:
    """Number (n,) of the cell of a square of cells that each point is in, or next to."""
    at = np.clip((points[:, :2] - lowest[:2]) / size[:2] * cells, 0, cells - 1).astype(np.int64)
    return at[:, 0] * cells + at[:, 1]


def _placed(
    low: FloatArray, high: FloatArray, lowest: FloatArray, size: FloatArray, cells: int
) -> tuple[IntArray, IntArray]:
    """Numbers (k,) of cells that boxes are in, and of these boxes; too many of one are not told."""
    first, last = (_cell(one, lowest, size, cells) for one in (low, high))
    wide = last // cells - first // cells + 1
    deep = last % cells - first % cells + 1
    each = wide * deep
    if each.sum() > _MOST_PLACED * len(low) and cells > 1:
        return np.zeros(_MOST_PLACED * len(low) + 1, np.int64), first
    box = np.repeat(np.arange(len(low)), each)
    step = np.arange(len(box)) - np.repeat(np.cumsum(each) - each, each)
    column, row = np.divmod(step, deep[box])
    cell = first[box] + column * cells + row
    return np.asarray(cell, np.int64), np.asarray(box, np.int64)


def _left_of(a: FloatArray, b: FloatArray, at: FloatArray) -> BoolArray:
    """Whether points (k, 2) are left of lines from a (k, 2) to b; the same from b to a is not."""
    swapped = (a[:, 0] > b[:, 0]) | ((a[:, 0] == b[:, 0]) & (a[:, 1] > b[:, 1]))
    one, other = np.where(swapped[:, None], b, a), np.where(swapped[:, None], a, b)
    d, e = other - one, at - one
    return np.asarray((d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0] > 0) != swapped)
