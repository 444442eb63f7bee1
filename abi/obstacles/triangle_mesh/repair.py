"""Repair of a triangle mesh, so that inside and outside are defined.

The steps follow what printing and simulation tools do before they trust a mesh (Attene, A
lightweight approach to repairing digitized polygon meshes, The Visual Computer 26, 2010).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from abi import arguments
from abi.arrays import BoolArray, FloatArray, IntArray, read_only
from abi.errors import SceneError
from abi.obstacles.triangle_mesh.distinct_rows import (
    distinct_rows,
    first_of_distinct_rows,
    in_groups,
)
from abi.obstacles.triangle_mesh.surface import Surface
from abi.obstacles.triangle_mesh.union import united

_WELD = 1e-6
"""Corners this near, as a part of the mesh's size, are joined where that closes the surface."""

_FLAT = 1e-9
"""A shell whose volume is below this part of its area to the power 3/2 has no inside."""


def clean(vertices: FloatArray, faces: IntArray, name: str = "mesh") -> Surface:
    """Repair triangles as far as that needs no guess, and note each repair.

    Equal corners are welded; triangles without area and duplicates are dropped. In each shell whose
    edges all have two sides, all triangles are made to face outward. Overlapping, touching and
    nested shells are united, which fills cavities, since nothing could get into them. If a shell
    stays open, the whole surface counts as an open one that nothing may cross, without an inside.

    Args:
        vertices: (n, 3) finite coordinates.
        faces: (m, 3) ids of the corners.
        name: the file's name, for errors.

    Raises:
        SceneError: no triangle has an area.
    """
    vertices = arguments.points("vertices", vertices)
    faces = arguments.ids("faces", faces, (-1, 3), len(vertices))
    notes: list[str] = []
    vertices, faces = _weld(vertices, faces, 0.0)
    faces = _without_duplicates(faces, notes)
    size = float(np.ptp(vertices, axis=0).max(initial=0.0)) if len(faces) else 0.0
    if size == 0 or not _areas(vertices, faces).any():
        raise SceneError("file", name, "a mesh, but none of its triangles has an area")
    shells = _shells(vertices, faces)
    if not shells.closed.all():
        welded, welded_faces = _weld(vertices, faces, _WELD * size)
        welded_faces = _without_duplicates(welded_faces, [])
        retried = _shells(welded, welded_faces) if len(welded_faces) else shells
        if retried.closed.all():
            vertices, shells = welded, retried
            notes.append("Small gaps between its triangles were closed.")
    notes += shells.notes
    faces, closed = shells.faces, bool(shells.closed.all())
    if closed and len(shells.closed) > 1:
        merged = united(vertices, faces, shells.label)
        if merged is not None:
            vertices, faces = _in_order(*merged)
            faces = _faces_in_order(faces)
            notes.append(f"Its {len(shells.closed)} parts count as one solid.")
    if not closed:
        notes.append("The surface has holes: it is treated as a thin shell, without an inside.")
    vertices, faces = _in_order(*_compact(vertices, faces[_areas(vertices, faces) > 0]))
    return Surface(read_only(vertices), read_only(faces), closed, tuple(notes))


@dataclass(frozen=True, eq=False)
class _Shells:
    """Faces (m, 3) turned outward, the shell (m,) of each, which shells are closed (k,)."""

    faces: IntArray
    label: IntArray
    closed: BoolArray
    notes: tuple[str, ...]


def _shells(vertices: FloatArray, faces: IntArray) -> _Shells:
    """Split the faces where they share no edge, and turn each closed shell outward."""
    edges = _Edges.of(faces)
    faces, notes = faces.copy(), []
    flipped = edges.flipped()
    if flipped.any():
        faces[flipped] = faces[flipped, ::-1]
        edges = _Edges.of(faces)
        notes.append(f"{flipped.sum()} triangles were inside out and have been turned.")
    paired = np.flatnonzero(edges.edge[1:] == edges.edge[:-1])
    count, label = _components(edges.face[paired], edges.face[paired + 1], len(faces))
    # a shell without a boundary winds a whole number of times around every point
    loose = edges.balance != 0
    closed = np.bincount(label[edges.face[loose[edges.edge]]], minlength=count) == 0
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    a, b, c = (vertices[faces[:, corner]] - middle for corner in range(3))
    volume = np.bincount(label, np.einsum("ij,ij->i", np.cross(a, b), c) / 6, count)
    area = np.bincount(label, _areas(vertices, faces), count)
    closed &= np.abs(volume) > _FLAT * area**1.5
    inward = closed & (volume < 0)
    if inward.any():
        turned = inward[label]
        faces[turned] = faces[turned, ::-1]
        what = "The surface was" if count == 1 else f"{inward.sum()} of its {count} parts were"
        notes.append(f"{what} inside out and turned. Hollows inside count as solid.")
    return _Shells(faces, label.astype(np.int32), closed, tuple(notes))


@dataclass(frozen=True, eq=False)
class _Edges:
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
    def of(cls, faces: IntArray) -> _Edges:
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
        count, half = _components(tails, heads, 2 * m)
        kept = np.bincount(half[:m], minlength=count)
        as_is, turned = kept[half[:m]], kept[half[m:]]
        # on a tie the half of the patch's first face stays
        return np.asarray((turned > as_is) | ((turned == as_is) & (half[m:] < half[:m])))


def _components(a: IntArray, b: IntArray, count: int) -> tuple[int, IntArray]:
    """Connected components of ``count`` nodes with edges from a to b: their number, and labels."""
    edges = scipy.sparse.coo_array((np.ones(len(a), dtype=np.int8), (a, b)), shape=(count, count))
    number, label = scipy.sparse.csgraph.connected_components(edges, directed=False)
    return number, label


def _weld(vertices: FloatArray, faces: IntArray, size: float) -> tuple[FloatArray, IntArray]:
    """Join equal vertices, or those in the same cube of side ``size``; drop degenerate faces."""
    keys = (np.round(vertices / size) if size else vertices) + 0.0  # -0.0 is 0.0
    first, ids = distinct_rows(keys)
    welded = ids[faces]
    a, b, c = welded.T
    welded = welded[(a != b) & (b != c) & (c != a)]
    return _compact(vertices[first], welded.astype(np.int32))


def _without_duplicates(faces: IntArray, notes: list[str]) -> IntArray:
    """Each triangle once, whichever way it faces, in the order of the file."""
    first = first_of_distinct_rows(np.sort(faces, axis=1).astype(np.int64))
    if len(first) < len(faces):
        notes.append(f"{len(faces) - len(first)} triangles were there twice and count once.")
    return faces[first]


def _compact(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """Leave out the vertices that no face uses."""
    is_used = np.zeros(len(vertices), dtype=np.bool_)
    is_used[faces] = True
    ids = np.cumsum(is_used, dtype=np.int32) - np.int32(1)
    return np.ascontiguousarray(vertices[is_used]), ids[faces]


def _in_order(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """The vertices as welding orders them, so that a surface read again is the same."""
    order = np.lexsort(vertices.T[::-1])
    number = np.empty(len(order), dtype=np.int32)
    number[order] = np.arange(len(order), dtype=np.int32)
    return vertices[order], number[faces]


def _faces_in_order(faces: IntArray) -> IntArray:
    """The faces by their corners, the lowest first, whatever order a union has given them."""
    first = faces.argmin(axis=1)[:, None]
    turned = np.take_along_axis(faces, (first + np.arange(3)) % 3, axis=1)
    return turned[np.lexsort(turned.T[::-1])]


def _areas(vertices: FloatArray, faces: IntArray) -> FloatArray:
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)
