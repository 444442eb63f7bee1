"""Kuhn's lattice: nodes at the corners of cubes; six tetrahedra around a diagonal of each."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations, product

from abi.tet_mesh.adjacency_kernels import KUHN
from abi.tet_mesh.regular_lattice import (
    Cells,
    Corners,
    Edges,
    RegularLattice,
    Values,
    at_place,
    corners_of,
)


def _edges(values: Values, cells: Cells) -> Edges:
    corners = corners_of(values, cells)
    for x, y, z in product((0, 1), repeat=3):
        if x or y or z:
            behind = corners[: -x or None, : -y or None, : -z or None]
            yield behind, corners[x:, y:, z:], (x, y, z)


def _tetrahedra(values: Values, cells: Cells) -> Iterator[Corners]:
    # one tetrahedron of each cube per order of walking from its lowest to its highest corner
    corners = corners_of(values, cells)
    for order in permutations(range(3)):
        place = [0, 0, 0]
        walk = [at_place(corners, place, cells)]
        for axis in order:
            place[axis] = 1
            walk.append(at_place(corners, place, cells))
        a, b, c, d = walk
        odd = order in ((0, 2, 1), (1, 0, 2), (2, 1, 0))
        yield (a, b, d, c) if odd else (a, b, c, d)


KUHN_LATTICE = RegularLattice(
    kind=KUHN,
    edges=_edges,
    tetrahedra=_tetrahedra,
    steps=tuple(step for step in product((0, 2), repeat=3) if any(step)),
)
