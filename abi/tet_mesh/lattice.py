"""Nodes, edges and tetrahedra of the two lattices, as views of arrays of one value per node.

A family is all edges, or all tetrahedra, that are translates of one another. Each family is given
by the values at its corners, so one description serves node ids (which makes the table) and flags
(which counts the tetrahedra left, without a table).

Nodes are numbered with z fastest: first the corners of the cubes, then (``bcc``) their centres.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import permutations, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abi.arrays import FloatArray

Cells = tuple[int, int, int]
Values = NDArray[Any]
Step = tuple[float, float, float]
Corners = tuple[Values, Values, Values, Values]

_RING = ((0, 0), (1, 0), (1, 1), (0, 1))


def grid(low: Iterable[float], high: Iterable[float], cells: Cells) -> FloatArray:
    """Corners of the cubes that divide the box ``low``..``high``.

    Returns:
        points: ((nx+1)(ny+1)(nz+1), 3), [unit], world.
    """
    axes = [np.linspace(a, b, n + 1) for a, b, n in zip(low, high, cells, strict=True)]
    return _product(axes)


def points(lattice: str, low: Iterable[float], high: Iterable[float], cells: Cells) -> FloatArray:
    """All nodes of the lattice in the box ``low``..``high``.

    Returns:
        points: (n, 3), [unit], world.
    """
    low, high = tuple(low), tuple(high)
    corners = grid(low, high, cells)
    if lattice == "kuhn":
        return corners
    axes = [np.linspace(a, b, 2 * n + 1)[1::2] for a, b, n in zip(low, high, cells, strict=True)]
    return np.concatenate([corners, _product(axes)])


def edges(lattice: str, values: Values, cells: Cells) -> Iterator[tuple[Values, Values, Step]]:
    """Families of edges: values at both ends, and the step between the ends in cells.

    Args:
        lattice: ``bcc`` or ``kuhn``.
        values: (n,), one value per node.
        cells: cubes along each axis.
    """
    return _EDGES[lattice](values, cells)


def tetrahedra(lattice: str, values: Values, cells: Cells) -> Iterator[Corners]:
    """Families of tetrahedra: values at the four corners, in positive order.

    Positive: (b - a) × (c - a) · (d - a) > 0.

    Args:
        lattice: ``bcc`` or ``kuhn``.
        values: (n,), one value per node.
        cells: cubes along each axis.
    """
    return _TETRAHEDRA[lattice](values, cells)


def _kuhn_edges(values: Values, cells: Cells) -> Iterator[tuple[Values, Values, Step]]:
    corners = _corners(values, cells)
    for x, y, z in product((0, 1), repeat=3):
        if x or y or z:
            behind = corners[: -x or None, : -y or None, : -z or None]
            yield behind, corners[x:, y:, z:], (x, y, z)


def _kuhn_tetrahedra(values: Values, cells: Cells) -> Iterator[Corners]:
    # one tetrahedron of each cube per order of walking from its lowest to its highest corner
    corners = _corners(values, cells)
    for order in permutations(range(3)):
        place = [0, 0, 0]
        walk = [_at(corners, place, cells)]
        for axis in order:
            place[axis] = 1
            walk.append(_at(corners, place, cells))
        a, b, c, d = walk
        odd = order in ((0, 2, 1), (1, 0, 2), (2, 1, 0))
        yield (a, b, d, c) if odd else (a, b, c, d)


def _bcc_edges(values: Values, cells: Cells) -> Iterator[tuple[Values, Values, Step]]:
    corners, centres = _corners(values, cells), _centres(values, cells)
    for place in product((0, 1), repeat=3):
        x, y, z = (0.5 - p for p in place)
        yield _at(corners, place, cells), centres, (x, y, z)
    for axis in range(3):
        sides, middles = _facing(corners, axis), _facing(centres, axis)
        x, y, z = np.roll((1.0, 0.0, 0.0), axis)
        yield sides[:-1], sides[1:], (x, y, z)
        yield middles[:-1], middles[1:], (x, y, z)
        x, y, z = np.roll((0.0, 1.0, 1.0), axis)
        for side in (0, -1):
            yield sides[side, :-1, :-1], sides[side, 1:, 1:], (x, y, z)


def _bcc_tetrahedra(values: Values, cells: Cells) -> Iterator[Corners]:
    corners, centres = _corners(values, cells), _centres(values, cells)
    for axis in range(3):
        sides, middles = _facing(corners, axis), _facing(centres, axis)
        _, ny, nz = middles.shape
        ring = [sides[:, j : j + ny, k : k + nz] for j, k in _RING]
        for near, far in zip(ring, ring[1:] + ring[:1], strict=True):
            yield middles[:-1], middles[1:], near[1:-1], far[1:-1]
        first = [corner[0] for corner in ring]
        last = [corner[-1] for corner in ring]
        yield middles[0], first[0], first[2], first[1]
        yield middles[0], first[0], first[3], first[2]
        yield middles[-1], last[0], last[1], last[2]
        yield middles[-1], last[0], last[2], last[3]


def _product(axes: list[FloatArray]) -> FloatArray:
    """All combinations of the axes' coordinates, the last axis fastest, shape (n, 3)."""
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def _corners(values: Values, cells: Cells) -> Values:
    nx, ny, nz = (n + 1 for n in cells)
    return values[: nx * ny * nz].reshape(nx, ny, nz)


def _centres(values: Values, cells: Cells) -> Values:
    return values[-(cells[0] * cells[1] * cells[2]) :].reshape(cells)


def _at(corners: Values, place: Iterable[int], cells: Cells) -> Values:
    """The corner at ``place`` of each cube: 0 for the low side of an axis and 1 for the high."""
    return corners[tuple(slice(p, p + n) for p, n in zip(place, cells, strict=True))]


def _facing(values: Values, axis: int) -> Values:
    """``values`` with ``axis`` first, the other two in the order that keeps them right-handed."""
    return values.transpose(axis, (axis + 1) % 3, (axis + 2) % 3)


_EDGES = {"bcc": _bcc_edges, "kuhn": _kuhn_edges}
_TETRAHEDRA = {"bcc": _bcc_tetrahedra, "kuhn": _kuhn_tetrahedra}
