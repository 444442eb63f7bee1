"""The body-centred cubic lattice: nodes at the corners and centres of cubes.

Around each face between two cubes the two centres and the face's corners make four tetrahedra; in
cubic cells all of these are congruent, with edges h and h·√3/2. Between a face of the box and the
centre behind it stands a pyramid, which a diagonal of the face splits into two of the same volume
as the others.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from abi.tet_mesh.adjacency_kernels import BCC
from abi.tet_mesh.regular_lattice import (
    Cells,
    Corners,
    Edges,
    RegularLattice,
    Values,
    at_place,
    centres_of,
    corners_of,
    facing,
)

_RING = ((0, 0), (1, 0), (1, 1), (0, 1))


def _edges(values: Values, cells: Cells) -> Edges:
    corners, centres = corners_of(values, cells), centres_of(values, cells)
    for place in product((0, 1), repeat=3):
        x, y, z = (0.5 - p for p in place)
        yield at_place(corners, place, cells), centres, (x, y, z)
    for axis in range(3):
        sides, middles = facing(corners, axis), facing(centres, axis)
        x, y, z = np.roll((1.0, 0.0, 0.0), axis)
        yield sides[:-1], sides[1:], (x, y, z)
        yield middles[:-1], middles[1:], (x, y, z)
        x, y, z = np.roll((0.0, 1.0, 1.0), axis)
        for side in (0, -1):
            yield sides[side, :-1, :-1], sides[side, 1:, 1:], (x, y, z)


def _tetrahedra(values: Values, cells: Cells) -> Iterator[Corners]:
    corners, centres = corners_of(values, cells), centres_of(values, cells)
    for axis in range(3):
        sides, middles = facing(corners, axis), facing(centres, axis)
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


BCC_LATTICE = RegularLattice(
    kind=BCC,
    edges=_edges,
    tetrahedra=_tetrahedra,
    steps=((2, 0, 0), (0, 2, 0), (0, 0, 2), (0, 2, 2), (2, 0, 2), (2, 2, 0)),
    cross=tuple((1 - 2 * x, 1 - 2 * y, 1 - 2 * z) for x, y, z in product((0, 1), repeat=3)),
)
