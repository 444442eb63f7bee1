"""Split of a triangle mesh into shells: closed ones that bound solids, and open sheets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.obstacles.mesh_files.words import counted
from abi.obstacles.triangle_mesh.distinct_rows import (
    distinct_rows,
    first_of_distinct_rows,
    in_groups,
    in_rows,
)

_FLAT = 1e-9
"""Relative volume, over the area to the power 3/2, below which a shell has no inside."""


@dataclass(frozen=True, eq=False)
class Shells:
    """A mesh split into shells.

    Attributes:
        faces: (m, 3), those of closed shells facing outward.
        label: (m,) shell of each face.
        closed: (k,) whether each shell bounds a solid.
        has_border: (m,) whether each face is of a patch with a free border, which bounds nothing.
        notes: sentences about what was turned or otherwise repaired.
    """

    faces: IntArray
    label: IntArray
    closed: BoolArray
    has_border: BoolArray
    notes: tuple[str, ...]

    @property
    def is_solid(self) -> BoolArray:
        """Whether each face (m,) bounds a solid."""
        return np.asarray(self.closed[self.label])


def shells_of(vertices: FloatArray, faces: IntArray) -> Shells:
    """Split faces that share no edge, and turn each closed shell outward.

    Patches with a free border, such as fins at a solid, bound nothing, and are apart from it.
    """
    thin = _have_border(faces)
    whole = ~thin | thin.all()  # the triangles of one open shell are made to agree, too
    turned, label, closed, notes = _split(vertices, faces[whole])
    faces, labels = faces.copy(), np.full(len(faces), len(closed), dtype=np.int32)
    faces[whole], labels[whole] = turned, label
    if not whole.all():
        closed = np.append(closed, False)
    return Shells(faces, labels, closed, thin, notes)


def _have_border(faces: IntArray) -> BoolArray:
    """Mask (m,) of the faces in patches with a free border, or whose removal leaves one.

    Patches meet at edges of three sides and more.
    """
    thin = np.zeros(len(faces), dtype=np.bool_)
    edges = Edges.of(faces)
    count, patch = edges.patches()
    while True:
        sides = np.bincount(edges.edge[~thin[edges.face]], minlength=len(edges.first))
        free = (sides == 1)[edges.edge] & ~thin[edges.face]
        if not free.any():
            return thin
        has_border = np.zeros(count, dtype=np.bool_)
        has_border[patch[edges.face[free]]] = True
        thin |= has_border[patch]


def _split(
    vertices: FloatArray, faces: IntArray
) -> tuple[IntArray, IntArray, BoolArray, tuple[str, ...]]:
    """Faces turned outward, the shell of each, which shells are closed, and notes."""
    edges = Edges.of(faces)
    faces, notes = faces.copy(), []
    flipped = edges.flipped()
    if (edges.sides > 3).any():
        # a triangle with both its sides agrees with any neighbour: the others have to by themselves
        single = ~have_both_sides(faces)
        flipped = np.zeros(len(faces), dtype=np.bool_)
        flipped[single] = Edges.of(faces[single]).flipped() if single.any() else False
    if flipped.any():
        faces[flipped] = faces[flipped, ::-1]
        edges = Edges.of(faces)
        notes.append(f"{counted(int(flipped.sum()), 'triangle')} inside out, and turned.")
    count, label = edges.shells()
    # a shell without a boundary winds a whole number of times around every point
    loose = edges.balance != 0
    closed = np.bincount(label[edges.face[loose[edges.edge]]], minlength=count) == 0
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    a, b, c = (vertices[faces[:, corner]] - middle for corner in range(3))
    volume = np.bincount(label, np.einsum("ij,ij->i", np.cross(a, b), c) / 6, count)
    area = np.bincount(label, areas_of(vertices, faces), count)
    closed &= np.abs(volume) > _FLAT * area**1.5
    inward = closed & (volume < 0)
    if inward.any():
        turned = inward[label]
        faces[turned] = faces[turned, ::-1]
        parts = int(closed.sum())  # sheets are from both sides what they are
        what = "The surface was" if parts == 1 else f"{inward.sum()} of its {parts} parts were"
        notes.append(f"{what} inside out and turned. Hollows inside count as solid.")
    return faces, label.astype(np.int32), closed, tuple(notes)


@dataclass(frozen=True, eq=False)
class Edges:
    """The sides of the faces, grouped into undirected edges.

    Attributes:
        face: (3m,) face of each side, in the order of ``edge``.
        edge: (3m,) edge of each side, ascending.
        forward: (3m,) whether the side runs from the lower to the higher vertex.
        balance: (e,) sides of the edge that run forward less those that run back.
        first: (e,) the edge's first side.
        sides: (e,) number of sides.
        faces: number of faces.
    """

    face: IntArray
    edge: IntArray
    forward: BoolArray
    balance: IntArray
    first: IntArray
    sides: IntArray
    faces: int

    @classmethod
    def of(cls, faces: IntArray) -> Edges:
        """Edges of faces (m, 3)."""
        tail = faces.ravel().astype(np.int64)
        head = faces[:, [1, 2, 0]].ravel().astype(np.int64)
        keys = np.minimum(tail, head) * (int(faces.max()) + 1) + np.maximum(tail, head)
        order, is_first = in_groups(keys)
        first = np.flatnonzero(is_first).astype(np.int32)
        sides = np.diff(first, append=np.int32(len(keys)))
        edge = np.cumsum(is_first, dtype=np.int32) - np.int32(1)
        forward = (tail < head)[order]
        balance = np.add.reduceat(np.where(forward, np.int32(1), np.int32(-1)), first)
        face = (order // 3).astype(np.int32)
        return cls(face, edge, forward, balance, first, sides, len(faces))

    def patches(self) -> tuple[int, IntArray]:
        """Number of patches, within which edges have two sides, and that of each face (m,)."""
        inner = self.first[self.sides == 2]
        return components(self.face[inner], self.face[inner + 1], self.faces)

    def shells(self) -> tuple[int, IntArray]:
        """Number of shells, and that of each face (m,).

        Patches within which edges have two sides are joined at edges of more, unless as many sides
        of a patch run forward there as back: it needs no other.
        """
        count, patch = self.patches()
        if self.sides.max() <= 2:
            return count, patch
        of_patch = self.edge.astype(np.int64) * count + patch[self.face]
        order, is_first = in_groups(of_patch)
        step = np.where(self.forward, np.int32(1), np.int32(-1))
        balance = np.add.reduceat(step[order], np.flatnonzero(is_first))
        needs = np.zeros(len(self.face), dtype=np.bool_)
        needs[order] = (balance != 0)[np.cumsum(is_first) - 1]
        needing = np.flatnonzero(needs | (self.sides == 2)[self.edge])
        same = np.flatnonzero(self.edge[needing[1:]] == self.edge[needing[:-1]])
        return components(self.face[needing[same]], self.face[needing[same + 1]], self.faces)

    def flipped(self) -> BoolArray:
        """Faces (m,) to turn so that neighbours agree over every edge of two sides.

        Each face is there twice, as it is and turned, and joined to those it agrees with: an
        orientable patch falls into two mirrored halves, of which the one that turns fewer faces
        is taken. One that is not, like Möbius's, is left as it is.
        """
        first = self.first[self.sides == 2]
        a, b = self.face[first], self.face[first + 1]
        disagree = self.forward[first] == self.forward[first + 1]
        m = self.faces
        if not disagree.any():
            return np.zeros(m, dtype=np.bool_)
        tails = np.concatenate([a, a + m])
        heads = np.concatenate([b + m * disagree, b + m * ~disagree])
        count, half = components(tails, heads, 2 * m)
        kept = np.bincount(half[:m], minlength=count)
        as_is, turned = kept[half[:m]], kept[half[m:]]
        # on a tie the half of the patch's first face stays
        return np.asarray((turned > as_is) | ((turned == as_is) & (half[m:] < half[:m])))


def have_both_sides(faces: IntArray) -> BoolArray:
    """Mask (m,) of the faces that occur as often from one side as from the other."""
    corners = np.sort(faces, axis=1)
    rest = np.ones(len(faces), dtype=np.bool_)
    rest[first_of_distinct_rows(corners.astype(np.int64))] = False
    both = in_rows(corners, corners[rest])
    if both.any():
        a, b, c = faces[both].T
        sides = np.where((a < b) ^ (b < c) ^ (c < a), 1, -1)
        _, number = distinct_rows(corners[both].astype(np.float64))
        both[both] = np.bincount(number, sides)[number] == 0
    return both


def patches_of(faces: IntArray, others: IntArray) -> IntArray:
    """Label (m,) of the patches into which edges of other faces divide faces (m, 3)."""
    sides, bounds = (
        np.sort(one[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1) for one in (faces, others)
    )
    inner = np.flatnonzero(~in_rows(sides, bounds))
    if not len(inner):
        return np.arange(len(faces), dtype=np.int32)
    _, edge = distinct_rows(sides[inner].astype(np.float64))
    face = (inner // 3).astype(np.int32)
    count = len(faces) + int(edge.max()) + 1
    return components(face, edge + np.int32(len(faces)), count)[1][: len(faces)]


def components(a: IntArray, b: IntArray, count: int) -> tuple[int, IntArray]:
    """Connected components of ``count`` nodes with edges from a to b: their number, and labels."""
    edges = scipy.sparse.coo_array((np.ones(len(a), dtype=np.int8), (a, b)), shape=(count, count))
    number, label = scipy.sparse.csgraph.connected_components(edges, directed=False)
    return number, label


def areas_of(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Areas (m,) of the faces."""
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)
