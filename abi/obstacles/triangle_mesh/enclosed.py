"""What triangles of solids that share edges enclose, whichever way each of them faces.

Where more than two triangles meet in an edge, the sides that they face need not tell what is solid:
some may be inside out, or there twice. But a point is outside where a ray from it can be moved away
from all triangles. A ray that is moved over an edge meets another number of each patch that ends
there, so that the patches it meets an odd number of times tell, up to those of edges, in which cell
of the triangles' complement the point is (Alexander duality, with numbers modulo 2).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.obstacles.mesh_files.words import counted
from abi.obstacles.triangle_mesh.distinct_rows import (
    distinct_rows,
    first_of_distinct_rows,
    in_groups,
    in_rows,
)
from abi.obstacles.triangle_mesh.rays import rays_met
from abi.obstacles.triangle_mesh.shells import (
    Edges,
    Shells,
    areas_of,
    components,
)

_ENCLOSED = "What triangles enclose that share edges counts as solid, whichever side they face."

_MOST_GROUPS = 300
"""Most groups of triangles that share edges; what are more are looked at as one."""
_MOST_PATCHES = 1000
"""Most patches of one group whose cells are told apart, in a second or two."""
_MOST_TRIANGLES = 125_000
"""Most triangles of groups beside which it is asked what is there, by two million rays in some ten
seconds. Groups that are more bound no solid: a hollow at a few triangles would not be seen."""
_BESIDE = 1e-8
"""Distance from a triangle at which it is asked what is there, over the size of all."""
_AWAY = 3e-6
"""The same, beyond slivers of triangles that should lie on each other."""
_SPOTS = np.array([[1, 1, 1], [28, 1, 1], [1, 28, 1], [1, 1, 28]])
"""Places in a triangle beside which points are looked at: its middle, and near its corners."""
_DIRECTIONS = np.array([[0.283, 0.531, 0.799], [-0.617, 0.709, 0.341]])


def with_enclosed(vertices: FloatArray, shells: Shells, given: IntArray) -> Shells:
    """Make solid what shells enclose that share edges, each part of it by a shell of its own.

    Where that cannot be told, as where triangles cross, and what is enclosed is hollow, or where
    triangles are very many, they bound no solid.

    Args:
        vertices: (n, 3).
        shells: of the faces given.
        given: (k, 3), as they face in the file; the notes say which of them are inside out.
    """
    whole = np.flatnonzero(~shells.has_border)
    if not len(whole):
        return shells
    _, number = distinct_rows(np.sort(shells.faces[whole], axis=1).astype(np.float64))
    faces = np.empty((int(number.max()) + 1, 3), dtype=np.int32)
    faces[number] = np.sort(shells.faces[whole], axis=1)
    a, b, c = shells.faces[whole].T
    turns = np.where((a < b) ^ (b < c) ^ (c < a), -1, 1) * shells.is_solid[whole]
    winding = np.bincount(number, turns, len(faces)).astype(np.int32)
    gone = np.zeros(len(faces), dtype=np.bool_)
    solids, sheets, outer = list[IntArray](), list[IntArray](), list[IntArray]()
    in_file = np.stack([in_rows(faces, _all_turns(one)) for one in (given, given[:, ::-1])])
    told, asked = False, 0
    solid = shells.is_solid[whole]
    for rows in _groups(faces, winding, (number[solid], shells.label[whole][solid])):
        if asked + len(rows) > _MOST_TRIANGLES:
            gone[rows] = True
            sheets.append(faces[rows])
            continue
        asked += len(rows)
        cells = _Cells(vertices, faces[rows], winding[rows])
        are_wound, most = cells.are_wound(in_file[:, rows])
        if not are_wound:
            are_wound, _ = replace(cells, beside=_AWAY).are_wound(in_file[:, rows])
        if are_wound and most <= 1:
            continue
        cycles, loose = cells.cycles()
        if are_wound and not cycles:
            continue
        gone[rows], told = True, told or (not are_wound and bool(cycles))
        solids += cycles
        sheets.append(loose)
        outer.append(cells.outer() if cycles else loose[:0])
    if not gone.any():
        return shells
    stays = np.ones(len(shells.faces), dtype=np.bool_)
    stays[whole] = ~gone[number]
    outer.append(shells.faces[stays & shells.is_solid])
    every = [*solids, np.concatenate(sheets)]
    labels = len(shells.closed) + np.repeat(np.arange(len(every)), [len(one) for one in every])
    used, label = np.unique(np.concatenate([shells.label[stays], labels]), return_inverse=True)
    closed = np.concatenate([shells.closed, np.ones(len(solids), np.bool_), [False]])[used]
    return replace(
        shells,
        faces=np.concatenate([shells.faces[stays], *every]),
        label=label.astype(np.int32),
        closed=closed,
        has_border=np.concatenate([shells.has_border[stays], np.zeros(len(labels), np.bool_)]),
        notes=(*_inside_out(np.concatenate(outer), given), _ENCLOSED) if told else shells.notes,
    )


def _groups(
    faces: IntArray, winding: IntArray, solids: tuple[IntArray, IntArray]
) -> list[IntArray]:
    """Rows of faces that share edges, in groups, where patches bound something together only.

    Patches belong together that meet in an edge of which either has an odd number of sides, and
    those of one solid. Without such an edge a patch is closed by itself.

    Args:
        faces: (m, 3), each once.
        winding: (m,) how often each counts in solids; 0 where it is in none.
        solids: rows (k,) of faces, and the number of the solid that each is in.
    """
    edges = Edges.of(faces)
    if edges.sides.max() <= 2:
        return []
    patches, patch = edges.patches()
    key = edges.edge.astype(np.int64) * patches + patch[edges.face]
    order, is_first = in_groups(key)
    places = np.flatnonzero(is_first)
    odd = key[order[places[np.diff(places, append=len(order)) % 2 == 1]]]
    edge, of_edge = odd // patches, odd % patches
    nodes = patches + len(edges.sides)
    rows, solid = solids
    tails = np.concatenate([of_edge, patch[rows]]).astype(np.int32)
    heads = np.concatenate([patches + edge, nodes + solid]).astype(np.int32)
    count, group = components(tails, heads, nodes + int(solid.max(initial=0)) + 1)
    asked = np.zeros(count, dtype=np.bool_)
    asked[group[of_edge]] = True
    asked[group[patch[winding == 0]]] = True
    group = group[patch]
    rows = np.flatnonzero(asked[group]).astype(np.int32)
    rows = rows[np.argsort(group[rows], kind="stable")]
    begins = np.flatnonzero(np.diff(group[rows], prepend=-1))[:_MOST_GROUPS]
    return [np.asarray(one, np.int32) for one in np.split(rows, begins) if len(one)]


def _all_turns(faces: IntArray) -> IntArray:
    """Faces (3m, 3) that begin with each of the corners, seen from the same side."""
    return np.concatenate([faces, faces[:, [1, 2, 0]], faces[:, [2, 0, 1]]])


def _inside_out(outer: IntArray, given: IntArray) -> tuple[str, ...]:
    """Sentence on faces, which face outward, that are turned in the file."""
    turned = np.sort(outer[~in_rows(outer, _all_turns(given))], axis=1)
    count = len(first_of_distinct_rows(turned.astype(np.int64)))
    return (f"{counted(count, 'triangle')} inside out, and turned.",) if count else ()


@dataclass(frozen=True, eq=False)
class _Cells:
    """The cells into which triangles divide space that share edges.

    Attributes:
        vertices: (n, 3).
        faces: (m, 3), each once, from any side.
        winding: (m,) how often solids have each from its front, less from behind.
        beside: distance of points from triangles, over the size of all.
    """

    vertices: FloatArray
    faces: IntArray
    winding: IntArray
    beside: float = _BESIDE

    @cached_property
    def oriented(self) -> IntArray:
        """The faces (m, 3), so that neighbours over edges of two sides agree."""
        flipped = self._edges.flipped()
        return np.where(flipped[:, None], self.faces[:, ::-1], self.faces)

    @cached_property
    def _edges(self) -> Edges:
        return Edges.of(self.faces)

    @cached_property
    def patch(self) -> IntArray:
        """Patch (m,) of each face, within which edges have two sides; the largest is 0."""
        count, patch = self._edges.patches()
        area = np.bincount(patch, areas_of(self.vertices, self.faces), count)
        rank = np.empty(count, dtype=np.int64)
        rank[np.argsort(-area, kind="stable")] = np.arange(count)
        return np.asarray(rank[patch])

    @cached_property
    def rows(self) -> dict[int, int]:
        """Patches of edges as bits, in echelon form, each by its highest bit; small ones are high.

        Each is the only one with that bit.
        """
        edges = self._edges
        shared = np.flatnonzero((edges.sides > 2)[edges.edge])
        of_edge = dict[int, int]()
        pairs = zip(
            edges.edge[shared].tolist(), self.patch[edges.face[shared]].tolist(), strict=True
        )
        for edge, patch in pairs:
            of_edge[edge] = of_edge.get(edge, 0) ^ 1 << patch
        found = dict[int, int]()
        for row in sorted(set(of_edge.values())):
            while row and (other := found.get(row.bit_length() - 1)):
                row ^= other
            if row:
                found[row.bit_length() - 1] = row
        pivots = 0
        for bit in sorted(found):
            found[bit] = _reduced(found[bit], found, pivots)
            pivots |= 1 << bit
        return found

    @cached_property
    def points(self) -> tuple[FloatArray, IntArray]:
        """Points (2k, 3) before faces and, in the same order, behind them; and these faces (k,).

        The first are beside the largest triangle of each patch.
        """
        corners = self.vertices[self.oriented]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        areas = np.linalg.norm(normals, axis=1)
        normals /= np.where(areas > 0, areas, 1.0)[:, None]
        order = np.lexsort((-areas, self.patch))
        largest = order[np.searchsorted(self.patch[order], np.arange(int(self.patch.max()) + 1))]
        wanted = np.tile(np.flatnonzero(areas > 0), len(_SPOTS))
        spot = np.repeat(np.arange(len(_SPOTS)), len(wanted) // len(_SPOTS))
        face = np.concatenate([largest, wanted])
        spot = np.concatenate([np.zeros(len(largest), np.int64), spot])
        weights = (_SPOTS / _SPOTS.sum(axis=1, keepdims=True))[spot]
        middles = np.einsum("ij,ijk->ik", weights, corners[face])
        away = self.beside * np.ptp(corners, axis=(0, 1)).max() * normals[face]
        return np.concatenate([middles + away, middles - away]), face

    @cached_property
    def met(self) -> list[tuple[IntArray, IntArray, IntArray]]:
        """Numbers of points, of faces that rays from them meet, and 1 or -1 if from behind."""
        return [rays_met(self.vertices[self.oriented], self.points[0], way) for way in _DIRECTIONS]

    @cached_property
    def odd(self) -> list[list[int]]:
        """Patches as bits that a ray from each point meets an odd number of times, each way."""
        found = []
        for point, face, _ in self.met:
            bits = [0] * len(self.points[0])
            for one, patch in zip(point.tolist(), self.patch[face].tolist(), strict=True):
                bits[one] ^= 1 << patch
            found.append(bits)
        return found

    @cached_property
    def cell(self) -> tuple[IntArray, BoolArray]:
        """Number of the cell that each point is in, 0 outside, and whether both rays tell it."""
        pivots, told = sum(1 << bit for bit in self.rows), []
        for bits in self.odd:
            names = {met: _reduced(met, self.rows, pivots) for met in set(bits)}
            told.append([names[met] for met in bits])
        one, other = told
        numbers = {0: 0}
        cell = np.array([numbers.setdefault(name, len(numbers)) for name in one])
        return cell, np.array([a == b for a, b in zip(one, other, strict=True)])

    @cached_property
    def times(self) -> IntArray:
        """How often the solids wind around the points."""
        flipped = (self.oriented != self.faces).any(axis=1)
        return self.wound(np.where(flipped, -self.winding, self.winding))

    def wound(self, winding: IntArray) -> IntArray:
        """How often faces wind around the points, given how often each (m,) of them counts."""
        point, face, side = self.met[0]
        total = np.bincount(point, side * winding[face], len(self.points[0]))
        return total.astype(np.int64)

    @property
    def are_few(self) -> bool:
        return bool(self.patch.max() < _MOST_PATCHES)

    def are_wound(self, in_file: BoolArray) -> tuple[bool, int]:
        """Whether all that is enclosed is wound around, at points beside the faces; most times.

        A negative number of times is not enough: with what others wind around it, it may be none.
        Where patches are too many to tell what is enclosed, what is behind any face as it is in
        the file has to be.

        Args:
            in_file: (2, m) whether the file has each as it is here, and turned.
        """
        flipped = (self.oriented != self.faces).any(axis=1)
        wound, most = self.times > 0, int(self.times.max())
        if self.are_few:
            cell, sure = self.cell
            return bool((wound | (cell == 0) | ~sure).all()), most
        before, behind = wound.reshape(2, -1)
        as_here, turned = np.where(flipped, in_file[::-1], in_file)[:, self.points[1]]
        return bool(((behind | ~as_here) & (before | ~turned)).all()), most

    def outer(self) -> IntArray:
        """Faces (k, 3), facing outward, of patches with all cells on one side."""
        half, count = len(self.points[1]), int(self.patch.max()) + 1
        cell, _ = self.cell
        before, behind = (cell[:count] == 0)[self.patch], (cell[half:][:count] == 0)[self.patch]
        return np.concatenate(
            [self.oriented[before & ~behind], self.oriented[~before & behind, ::-1]]
        )

    def cycles(self) -> tuple[list[IntArray], IntArray]:
        """Faces of solids that face outward and together fill all cells; and of no solid.

        Returns:
            Closed surfaces, each (k, 3); and the faces (k, 3) that are in none of these.
        """
        nothing = list[IntArray](), self.faces
        if not self.are_few:
            return nothing
        edges, rows, count = Edges.of(self.oriented), self.rows, int(self.patch.max()) + 1
        if edges.balance[edges.sides == 2].any():
            return nothing
        found, flat = list[IntArray](), list[int]()
        solid, used = list[int](), np.zeros(count, dtype=np.bool_)
        winding = np.zeros(count, dtype=np.int32)
        for free in (bit for bit in range(count) if bit not in rows):
            cycle = 1 << free | sum(1 << bit for bit, row in rows.items() if row >> free & 1)
            (solid if self._are_odd(cycle).any() else flat).append(cycle)
        # what lies on others is in a solid instead of these
        for cycle in flat:
            solid += [cycle ^ next((one for one in solid if one & cycle), 0)]
        for cycle in solid:
            turned = self._outward(cycle)
            faces = np.where(turned[self.patch, None] < 0, self.oriented[:, ::-1], self.oriented)
            faces = faces[turned[self.patch] != 0]
            if not len(faces):
                continue
            if Edges.of(faces).balance.any():
                return nothing
            found.append(faces)
            winding += turned
            used |= turned != 0
        cell, sure = self.cell
        wound = self.wound(winding[self.patch]) > 0
        # where triangles lie on others, the cells do not tell all that solids wind around
        if (wound != (cell > 0))[sure].any() or (~wound & (self.times != 0)).any():
            return nothing
        return found, self.faces[~used[self.patch]]

    def _outward(self, cycle: int) -> IntArray:
        """Times (n,) that patches count, less where turned, so that they face out of a cycle.

        A patch whose sides are both within it, or both not, does not count.
        """
        before, behind = self._are_odd(cycle).reshape(2, -1).astype(np.int32)
        turned = behind - before
        turned[[not cycle >> patch & 1 for patch in range(len(turned))]] = 0
        return turned

    def _are_odd(self, cycle: int) -> BoolArray:
        """Whether fronts (n,) and then backs of patches are within a cycle of these, as bits."""
        half, count = len(self.points[1]), int(self.patch.max()) + 1
        odd = (*self.odd[0][:count], *self.odd[0][half : half + count])
        return np.array([(met & cycle).bit_count() & 1 for met in odd], dtype=np.bool_)


def _reduced(bits: int, rows: Mapping[int, int], pivots: int) -> int:
    """Take rows from bits until none of some pivots is left; each row has one, its own."""
    while among := bits & pivots:
        bits ^= rows[among.bit_length() - 1]
    return bits
