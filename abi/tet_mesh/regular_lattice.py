"""A regular lattice as array views with one value per node.

A family is all edges, or all tetrahedra, that are translates of one another. Each family is given
by the values at its corners, so one description serves node ids (which makes the table) and flags
(which counts the tetrahedra left, without a table).

Nodes are numbered with z fastest: first the corners of the cubes, then, where a lattice has them,
their centres.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abi.arrays import FloatArray

Cells = tuple[int, int, int]
Values = NDArray[Any]
Step = tuple[float, float, float]
HalfSteps = tuple[tuple[int, ...], ...]
Edges = Iterator[tuple[Values, Values, Step]]
Corners = tuple[Values, Values, Values, Values]


@dataclass(frozen=True)
class RegularLattice:
    """A lattice of cubes that are all cut in the same way.

    Attributes:
        kind: its number in the kernels, see ``adjacency_kernels``.
        edges: families of edges, of values (n,) at the nodes and of the cells: values at both ends,
            and the step between the ends in cells.
        tetrahedra: families of tetrahedra: values at the four corners, in positive order,
            (b - a) × (c - a) · (d - a) > 0.
        steps: from a corner to others, in half cells, each in one of its two senses.
        cross: steps from a corner to the centres around it, in half cells; none without centres.
    """

    kind: int
    edges: Callable[[Values, Cells], Edges]
    tetrahedra: Callable[[Values, Cells], Iterator[Corners]]
    steps: HalfSteps
    cross: HalfSteps = ()

    def points(self, low: Iterable[float], high: Iterable[float], cells: Cells) -> FloatArray:
        """All nodes (n, 3) in the box ``low``..``high``, [unit], world."""
        low, high = tuple(low), tuple(high)
        corners = grid(low, high, cells)
        if not self.cross:
            return corners
        axes = [
            np.linspace(a, b, 2 * n + 1)[1::2] for a, b, n in zip(low, high, cells, strict=True)
        ]
        return np.concatenate([corners, _product(axes)])


def grid(low: Iterable[float], high: Iterable[float], cells: Cells) -> FloatArray:
    """Corners of the cubes that divide the box ``low``..``high``.

    Returns:
        points: ((nx+1)(ny+1)(nz+1), 3), [unit], world.
    """
    axes = [np.linspace(a, b, n + 1) for a, b, n in zip(low, high, cells, strict=True)]
    return _product(axes)


def _product(axes: list[FloatArray]) -> FloatArray:
    """All combinations of the axes' coordinates, the last axis fastest, shape (n, 3)."""
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def corners_of(values: Values, cells: Cells) -> Values:
    """Values of the cubes' corners, (nx + 1, ny + 1, nz + 1)."""
    nx, ny, nz = (n + 1 for n in cells)
    return values[: nx * ny * nz].reshape(nx, ny, nz)


def centres_of(values: Values, cells: Cells) -> Values:
    """Values of the cubes' centres, (nx, ny, nz)."""
    return values[-(cells[0] * cells[1] * cells[2]) :].reshape(cells)


def at_place(corners: Values, place: Iterable[int], cells: Cells) -> Values:
    """The corner at ``place`` of each cube: 0 for the low side of an axis and 1 for the high."""
    return corners[tuple(slice(p, p + n) for p, n in zip(place, cells, strict=True))]


def facing(values: Values, axis: int) -> Values:
    """``values`` with ``axis`` first, the other two in the order that keeps them right-handed."""
    return values.transpose(axis, (axis + 1) % 3, (axis + 2) % 3)
