"""Repair of a triangle mesh, so that inside and outside are defined.

The steps follow what printing and simulation tools do before they trust a mesh (Attene, A
lightweight approach to repairing digitized polygon meshes, The Visual Computer 26, 2010).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from abi import arguments
from abi.arrays import BoolArray, FloatArray, IntArray, read_only
from abi.errors import SceneError
from abi.obstacles.mesh_files.words import counted
from abi.obstacles.triangle_mesh.crossings import layers_of
from abi.obstacles.triangle_mesh.distinct_rows import (
    distinct_rows,
    first_of_distinct_rows,
    in_rows,
)
from abi.obstacles.triangle_mesh.enclosed import with_enclosed
from abi.obstacles.triangle_mesh.flat_triangles import uncovered_lines
from abi.obstacles.triangle_mesh.rays import rays_met
from abi.obstacles.triangle_mesh.shells import (
    Edges,
    Shells,
    areas_of,
    components,
    have_both_sides,
    patches_of,
    shells_of,
)
from abi.obstacles.triangle_mesh.surface import Surface
from abi.obstacles.triangle_mesh.t_junctions import split_at_corners
from abi.obstacles.triangle_mesh.union import united
from abi.obstacles.triangle_mesh.welding import (
    faces_in_order,
    in_order,
    near_rows,
    weld,
    weld_nearby,
    without_duplicates,
)
from abi.obstacles.triangle_mesh.winding import windings

_WELD = 1e-6
"""Relative distance, over the mesh's size, within which corners are joined if that closes the
surface, and a corner lies on an edge."""

_CANCELLED = "has no holes, but its triangles bound no solid, as where a surface crosses itself"

_CLOSED_GAPS = "Small gaps between its triangles were closed."
_SPLIT = "Triangles were split where corners of others lie on their edges."
_AS_THEY_WERE = "Where that moved corners, the triangles count as they were, too."

_BESIDE = 1e-6
"""Distance from a triangle at which it is asked what is solid, over the mesh's size."""
_AWAY = 3e-6
"""The same, beyond corners that were joined."""
_MOST_FOLDED = 2000
"""Triangles beside which that is asked, spread evenly: long ones take long to find."""
_DIRECTION = np.array([0.283, 0.531, 0.799])
_MOST_WOUND = 3 * 10**6
"""Most pairs of triangles that are tested for one inside the other; else it counts as a sheet."""
_MOST = 500_000
"""Most triangles of a united surface, so that its file can be read again."""


def clean(vertices: FloatArray, faces: IntArray, name: str = "mesh") -> Surface:
    """Repair triangles as far as that is unambiguous, and note each repair.

    Equal corners are welded; duplicates are dropped, and so are triangles without area, with a note
    where no other triangle has their line. In each shell whose edges all have two sides, all
    triangles are made to face outward. Overlapping, touching and nested shells are united, which
    fills cavities, since nothing could get into them; a shell that may cross itself stays in a
    layer apart from those near it, and inside is what any layer winds around. What stays open, such
    as a fin at a solid, counts as a thin sheet that nothing may cross, without an inside. In a
    surface that has solid parts, too, it is there with both its sides, which wind around nothing.

    Args:
        vertices: (n, 3) finite coordinates.
        faces: (m, 3) ids of the corners.
        name: the file's name, for errors.

    Raises:
        SceneError: no triangle has an area.
    """
    vertices = arguments.points("vertices", vertices)
    faces = arguments.ids("faces", faces, (-1, 3), len(vertices))
    lines = uncovered_lines(vertices, faces)
    given = vertices, faces = weld(vertices, faces)
    size = float(np.ptp(vertices, axis=0).max(initial=0.0)) if len(faces) else 0.0
    if size == 0 or not areas_of(vertices, faces).any():
        raise SceneError("file", name, "a mesh, but none of its triangles has an area")
    vertices, shells, moved = _split(vertices, faces, size)
    notes = shells.notes
    if lines:
        notes = (
            *notes,
            f"{counted(lines, 'triangle')} left out: without area, and along no other.",
        )
    is_solid = shells.is_solid & ~_is_thin(vertices, shells)
    faces, sheets = shells.faces[is_solid], shells.faces[~is_solid]
    most, is_as_in_file = _MOST if shells.closed.any() else 0, True
    number = np.unique(shells.label[is_solid], return_inverse=True)[1].astype(np.int32)
    parts = int(number.max(initial=-1)) + 1
    solids = [faces]
    if parts > 1:
        layers = layers_of(vertices, faces, number)
        layer, plain = layers[number], int((layers == 0).sum())
        solids = [faces[layer == k] for k in range(max(int(layers.max()) + 1, 1))]
        sheets, parts = np.concatenate([sheets, faces[layer < 0]]), int((layers >= 0).sum())
        merged = united(vertices, solids[0], number[layer == 0], _MOST) if plain > 1 else None
        if merged is not None:
            notes = (*notes, f"Its {plain} parts count as one solid.")
            corners, merged_faces = in_order(*merged)
            is_as_in_file, first = False, np.int32(len(corners))
            sheets, moved = sheets + first, moved + first
            solids = [merged_faces, *(one + first for one in solids[1:])]
            vertices = np.concatenate([corners, vertices])
    sheets, moved = (
        without_duplicates(one[areas_of(vertices, one) > 0])[0] for one in (sheets, moved)
    )
    count = len(sheets) + len(moved)
    folded = _folded(vertices, solids, size) if shells.notes and parts else 0
    least = "At least " if folded and sum(map(len, solids)) > _MOST_FOLDED else ""
    if count and sum(map(len, solids)) + 2 * count <= most:
        folded += len(sheets)
        sheets = np.concatenate([sheets, moved])
        solids[0] = np.concatenate([solids[0], sheets, sheets[:, ::-1]])
        is_as_in_file = False
    elif count:
        why = "has holes" if shells.has_border.any() else _CANCELLED
        whole = f"The surface {why}: it is treated as a thin shell, without an inside."
        solids, parts, folded = [np.concatenate([*solids, sheets, moved])], 0, 0
        notes = (*notes, whole)
    if folded:
        told = least + counted(folded, "triangle")
        notes = (*notes, f"{told} no part of a solid: a thin shell, without an inside.")
    solids = [one[areas_of(vertices, one) > 0] for one in solids]
    # corners that a united part and a sheet both have are there twice
    vertices, faces = in_order(*weld(vertices, np.concatenate(solids)))
    solids = np.split(faces, np.cumsum([len(one) for one in solids])[:-1])
    solids = [one if is_as_in_file else faces_in_order(one) for one in solids if len(one)]
    sizes = tuple(map(len, solids)) if len(solids) > 1 else ()
    faces = np.concatenate(solids)
    is_as_given = np.array_equal(vertices, given[0]) and np.array_equal(faces, given[1])
    before = None if is_as_given else (read_only(given[0]), read_only(given[1]))
    return Surface(
        *(read_only(vertices), read_only(faces), parts > 0, notes), layers=sizes, given=before
    )


def _folded(vertices: FloatArray, layers: Sequence[IntArray], size: float) -> int:
    """Number of triangles of solids without a solid on either side, as where turned ones fold.

    Those much narrower than the distance at which it is asked are not.

    Args:
        vertices: (n, 3).
        layers: faces (m, 3) of each.
        size: of the mesh.
    """
    corners = vertices[np.concatenate(layers)]
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    wide = np.flatnonzero(areas > 10 * _AWAY * size * sides)
    wide = wide[:: 1 + len(wide) // _MOST_FOLDED]
    away = _AWAY * size * normals[wide] / areas[wide, None]
    middles = corners[wide].mean(axis=1)
    alone = np.arange(len(wide))
    for faces in layers:
        beside = np.concatenate([middles[alone] + away[alone], middles[alone] - away[alone]])
        point, _, side = rays_met(vertices[faces], beside, _DIRECTION)
        solid = np.abs(np.bincount(point, side, len(beside))) > 0.5
        alone = alone[~solid.reshape(2, -1).any(axis=0)]
        if not len(alone):
            break
    return len(alone)


def _is_thin(vertices: FloatArray, shells: Shells) -> BoolArray:
    """Mask (m,) of faces of solids that are there with both their sides, and have no solid around.

    A wall between two solids has one on each side. What has none adds nothing to what winds around
    a point: it is a sheet, though the solid that it touches is closed.
    """
    is_solid = shells.is_solid
    thin = is_solid.copy()
    thin[is_solid] = have_both_sides(shells.faces[is_solid])
    if not thin.any():
        return thin
    rest, walls = shells.faces[is_solid & ~thin], shells.faces[thin]
    asked, of = np.arange(len(walls)), np.arange(len(walls))
    if len(rest) * len(walls) > _MOST_WOUND:  # all of a patch between solids are as one of it is
        _, asked, of = np.unique(patches_of(walls, rest), return_index=True, return_inverse=True)
    if 2 * len(rest) * len(asked) <= _MOST_WOUND:
        corners = vertices[walls[asked]]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        away = _BESIDE * np.ptp(vertices, axis=0).max() * normals / np.where(lengths, lengths, 1.0)
        beside = (windings(vertices, rest, corners.mean(axis=1) + one) for one in (away, -away))
        thin[thin] = (np.stack([*beside]) == 0).all(axis=0)[of]
    return thin


def _split(
    vertices: FloatArray, faces: IntArray, size: float
) -> tuple[FloatArray, Shells, IntArray]:
    """Split a mesh into shells, closing small gaps if less of it is sheets then.

    Nearby corners are joined, and edges split at corners that lie on them. Where all edges of what
    is connected have sides that cancel, it stays as it is. Triangles whose corners moved are there
    as they were, too, so that nothing of the surface is lost, be it thinner than the gap.

    Returns:
        Its vertices, its shells, and the triangles as they were before corners moved.
    """
    shells = _split_as_it_is(vertices, faces)
    split, edges = (vertices, shells, faces[:0]), Edges.of(faces)
    is_open = (edges.balance != 0)[edges.edge]
    if not is_open.any() or (shells.is_solid.all() and edges.sides.max() <= 2):
        return split
    _, number = near_rows(vertices, _WELD * size)
    a, b, c = number[faces].T
    count = int(number.max()) + 1
    part = components(np.concatenate([a, b]), np.concatenate([b, c]), count)[1][a]
    is_loose = np.isin(part, part[edges.face[is_open]])
    near, near_faces, moved = weld_nearby(vertices, faces[is_loose], _WELD * size)
    pieces, beside = split_at_corners(near, near_faces, _WELD * size)
    is_split, before = len(pieces) > len(near_faces), np.concatenate([moved, beside])
    if not is_split and not len(moved):
        return split
    corners, ids = np.concatenate([near, vertices]), faces[~is_loose] + np.int32(len(near))
    corners, faces = weld(corners, np.concatenate([ids, pieces]))
    joined = _split_as_it_is(corners, faces)
    loose = areas_of(vertices, shells.faces[~shells.is_solid]).sum()
    left = areas_of(corners, joined.faces[~joined.is_solid]).sum()
    if left >= loose * (1 - _WELD) and Edges.of(faces).balance.any():
        return split
    told = [(_CLOSED_GAPS, not is_split or len(moved) > 0), (_SPLIT, is_split)]
    notes = [sentence for sentence, holds in (*told, (_AS_THEY_WERE, len(before) > 0)) if holds]
    every = np.concatenate([corners, near]) + 0.0
    first, ids = distinct_rows(every)
    joined = replace(joined, faces=ids[joined.faces], notes=(" ".join(notes), *joined.notes))
    return every[first], joined, ids[before + np.int32(len(corners))]


def _split_as_it_is(vertices: FloatArray, faces: IntArray) -> Shells:
    """Split a mesh into shells without joining nearby corners.

    Solids that touch in a face have its triangles twice, once from each side, as surfaces have
    that are to be seen from both; where one stands in the other, flush with its side, they are
    there twice from the same side. So all are kept only where one does not bound a solid. Of the
    ways to read them, all as in the file if that has no border, or some, with sides as in the file
    or as most of their neighbours have them, that one is taken by which the fewest are sheets.
    """
    kept, other_sides = without_duplicates(faces)
    shells = shells_of(vertices, kept)
    if len(other_sides) and not shells.closed.all():
        sheets = np.sort(kept[~shells.is_solid & ~shells.has_border], axis=1)
        first = first_of_distinct_rows(np.sort(faces, axis=1).astype(np.int64))
        repeated = np.delete(faces, first, axis=0)
        agreeing = shells.faces
        same = agreeing[in_rows(np.sort(kept, axis=1), np.sort(other_sides, axis=1))]
        told, least = shells.notes, len(faces) + 1
        of_sheets = [
            np.concatenate([once, more[in_rows(np.sort(more, axis=1), sheets)]])
            for once, more in ((kept, other_sides), (kept, repeated), (agreeing, same))
        ]
        ways = [(faces, ()), *zip(of_sheets, ((), (), told), strict=True)]
        for both, before in ways[int(Edges.of(faces).balance.any()) :]:
            turned = shells_of(vertices, faces_in_order(both))
            ordered = shells_of(vertices, faces_in_order(turned.faces))
            loose = ~ordered.is_solid
            if both is faces:  # what has both its sides changes nothing
                loose &= ~have_both_sides(ordered.faces)
            thin = int((loose | _is_thin(vertices, ordered)).sum())
            if thin < least:
                shells, least = replace(ordered, notes=(*before, *turned.notes)), thin
            if not thin:
                break
        kept = shells.faces
    shells = with_enclosed(vertices, shells, faces)
    dropped = len(faces) - len(kept)
    twice = (f"{counted(dropped, 'triangle')} there twice, and once is enough.",) if dropped else ()
    return replace(shells, notes=(*twice, *shells.notes))
