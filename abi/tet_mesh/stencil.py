"""Directions of a lattice, which give a node's neighbours without a table of edges.

Positions are counted in half cells: the corner (i, j, k) is at (2i, 2j, 2k) and the centre of a
cube at (2i + 1, 2j + 1, 2k + 1). An edge has one number at each of its ends, its bit in
``open_directions``. The first ``cross`` of these join a corner to a centre and are the same at
both; the others come in pairs, 2m one way and 2m + 1 the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, IntArray, ShortRepr, read_only
from abi.obstacles.pose import Vec3
from abi.tet_mesh.lattice import REGULAR
from abi.tet_mesh.regular_lattice import Cells, Step


@dataclass(frozen=True, eq=False, repr=False)
class Stencil(ShortRepr):
    """The d directions of a lattice in a box.

    Attributes:
        lattice: its name in ``lattice.REGULAR``.
        cells: cubes along each axis.
        cross: number of directions from a corner to a centre.
        steps: (d, 3) half cells from a corner; from a centre the first ``cross`` are opposite.
        lengths: (d,) [unit].
        offsets: (2, d) what is added to a node's id, for corners and for centres; in the first
            ``cross`` to the id of the first node of the other kind in the same cube.
        low: low corner of the box, [unit], world.
        cell: edges of a cell, [unit].
        axes: coordinates of the half cells along x, y and z, one after the other, [unit], world.
    """

    lattice: str
    cells: Cells
    cross: int
    steps: IntArray
    lengths: FloatArray
    offsets: IntArray
    low: Vec3
    cell: Vec3
    axes: FloatArray

    def __post_init__(self) -> None:
        cells = [arguments.integer("cells", n, 1, arguments.LARGEST_ID) for n in self.cells]
        directions = len(REGULAR[self.lattice].cross) + 2 * len(REGULAR[self.lattice].steps)
        arguments.keep(
            self,
            cross=arguments.integer("cross", self.cross, 0, directions),
            steps=arguments.bits("steps", self.steps, (directions, 3)),
            lengths=arguments.numbers("lengths", self.lengths, (directions,)),
            offsets=arguments.bits("offsets", self.offsets, (2, directions)),
            axes=arguments.numbers("axes", self.axes, (2 * sum(cells) + 3,)),
        )

    @classmethod
    def of(cls, name: str, low: FloatArray, high: FloatArray, cells: Cells) -> Stencil:
        """The stencil of the lattice that divides the box ``low``..``high``, [unit]."""
        cross = REGULAR[name].cross
        both = [tuple(sign * s for s in step) for step in REGULAR[name].steps for sign in (1, -1)]
        steps = np.array([*cross, *both], dtype=np.int32)
        _, ny, nz = cells
        strides = np.array([[(ny + 1) * (nz + 1), nz + 1, 1], [ny * nz, nz, 1]])
        offsets = strides @ (steps.T // 2)
        if cross:
            behind = (1 - steps[: len(cross)].T) // 2
            offsets[:, : len(cross)] = np.stack([-strides[1] @ behind, strides[0] @ behind])
        axes = []
        for a, b, n in zip(low, high, cells, strict=True):
            axis = np.linspace(a, b, 2 * n + 1)
            axis[::2] = np.linspace(a, b, n + 1)
            axes.append(axis)
        return cls(
            lattice=name,
            cells=cells,
            cross=len(cross),
            steps=read_only(steps),
            lengths=read_only(np.linalg.norm(steps / 2 * ((high - low) / cells), axis=1)),
            offsets=read_only(offsets.astype(np.int32)),
            low=_vector(low),
            cell=_vector((high - low) / cells),
            axes=read_only(np.concatenate(axes)),
        )

    def open_directions(self, nodes: int) -> IntArray:
        """The directions in which each node has a neighbour (n,), as bits."""
        bits = np.zeros(nodes, dtype=np.int32)
        for tail, head, step in REGULAR[self.lattice].edges(bits, self.cells):
            there, back = self.ends(step)
            tail |= np.int32(1 << there)
            head |= np.int32(1 << back)
        return read_only(bits)

    def ends(self, step: Step) -> tuple[int, int]:
        """Ends of the edges in a direction; ``step`` is in cells, from tail to head."""
        found = np.flatnonzero((self.steps == 2 * np.array(step)).all(axis=1))
        there = int(found[0])
        return there, (there if there < self.cross else there ^ 1)

    def cell_of(self, point: Vec3) -> Vec3:
        """A point, [unit], world, in half cells."""
        (x, y, z), (a, b, c), (u, v, w) = point, self.low, self.cell
        return 2 * (x - a) / u, 2 * (y - b) / v, 2 * (z - c) / w

    def node_at(self, point: Vec3) -> int:
        """The node nearest to a point of the box, or -1 if none is within a quarter cell."""
        (nx, ny, nz), (x, y, z) = self.cells, self.cell_of(point)
        a, b, c = round(x), round(y), round(z)
        odd = a % 2
        if b % 2 != odd or c % 2 != odd or (odd and not self.cross):
            return -1
        if not (0 <= a <= 2 * nx and 0 <= b <= 2 * ny and 0 <= c <= 2 * nz):
            return -1
        i, j, k = a // 2, b // 2, c // 2
        if odd:
            return (nx + 1) * (ny + 1) * (nz + 1) + (i * ny + j) * nz + k
        return (i * (ny + 1) + j) * (nz + 1) + k

    def heads(self, nodes: IntArray) -> IntArray:
        """Neighbours in each direction of nodes (m,), shape (m, d); any id if there is none."""
        nx, ny, nz = self.cells
        corners = (nx + 1) * (ny + 1) * (nz + 1)
        low = nodes < corners
        across = np.empty_like(nodes)
        for here, side in ((low, 0), (~low, 1)):
            shape = (nx + 1 - side, ny + 1 - side, nz + 1 - side)
            other = (nx + side, ny + side, nz + side)
            i, j, k = np.unravel_index(nodes[here] - side * corners, shape)
            across[here] = (1 - side) * corners + (i * other[1] + j) * other[2] + k
        heads: IntArray = nodes[:, None] + np.where(low[:, None], self.offsets[0], self.offsets[1])
        heads[:, : self.cross] += (across - nodes)[:, None]
        return heads.astype(np.int32)


def _vector(values: FloatArray) -> Vec3:
    x, y, z = values.tolist()
    return x, y, z
