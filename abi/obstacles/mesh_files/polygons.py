"""Triangulation of a mesh file's polygons: convex, concave, or with holes.

A convex polygon becomes a fan. Others are cut by manifold3d (Lalish, Apache-2.0) in the plane that
fits them, which keeps every corner. Polygons that cross themselves bound no certain area.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.obstacles.mesh_files.parts import check_points

MOST_CORNERS = 10_000
"""Most corners of a polygon that is not convex."""
_ROUNDING = 1e-9
"""Relative area, over a polygon's size squared, that counts as zero."""
_OVERLAP = 1e-7
"""Relative area that triangles may cover twice."""
_FLATNESS = 1e-5
"""Largest distance of a corner from its polygon's plane, over the polygon's size, without a note:
that of coordinates with six digits."""
_CHUNK = 1_000_000
_MOST_PAIRS = 2 * MOST_CORNERS**2
"""Most pairs of edges that are compared in a file, in all its polygons that are not convex."""


def triangulate(
    points: FloatArray,
    corners: IntArray,
    counts: IntArray,
    where: Callable[[int], str],
    tally: Counter[str],
) -> IntArray:
    """Triangulate polygons.

    Args:
        points: (p, 3).
        corners: ids of all corners, one polygon after the other.
        counts: (k,) number of corners of each, at least 3.
        where: name of a polygon by its number, for a refusal.
        tally: of a file; polygons that are ``bent``, whose corners are in no plane, and ``pairs``
            of edges that are compared are added to it.

    Returns:
        Ids of the triangles' corners (m, 3); a polygon of n corners has n − 2, all in one place.

    Raises:
        ValueError: one crosses itself, or those that are not convex have too many corners.
    """
    check_points(points)
    firsts, rows = np.cumsum(counts) - counts, np.cumsum(counts - 2) - (counts - 2)
    faces = np.empty((int((counts - 2).sum()), 3), dtype=np.int32)
    for size in np.unique(counts).tolist():
        chosen = np.flatnonzero(counts == size)
        for some in np.array_split(chosen, 1 + len(chosen) * size // _CHUNK):
            rings = corners[firsts[some, None] + np.arange(size)]
            places = rows[some, None] + np.arange(size - 2)
            if size > 3:
                starts, off = _fans(points[rings])
                tally["bent"] += int((off > _FLATNESS).sum())
                turned = (np.maximum(starts, 0)[:, None] + np.arange(size)) % size
                rings = np.take_along_axis(rings, turned, axis=1)
            first = np.broadcast_to(rings[:, :1], (len(some), size - 2))
            faces[places] = np.stack([first, rings[:, 1:-1], rings[:, 2:]], axis=-1)
            if size > 3:
                add_pairs(tally, int((starts < 0).sum()) * size**2)
                for k in np.flatnonzero(starts < 0).tolist():
                    ids = cut([points[rings[k]]], where(int(some[k])))
                    faces[places[k]] = rings[k][ids]
    return faces


def flatness_notes(tally: Counter[str]) -> tuple[str, ...]:
    """Sentence on the polygons of a file that are not flat."""
    if not (bent := tally["bent"]):
        return ()
    count = "1 polygon is" if bent == 1 else f"{bent:,} polygons are"
    return (f"{count} not flat: the triangles are one of several ways to fill the outline.",)


def add_pairs(tally: Counter[str], pairs: int) -> None:
    """Count pairs of edges that are to be compared.

    Raises:
        ValueError: there are more than ``_MOST_PAIRS`` in the file.
    """
    tally["pairs"] += pairs
    if tally["pairs"] > _MOST_PAIRS:
        raise ValueError(
            f"polygons that are convex, or of a few corners: comparing {tally['pairs']:,} pairs of "
            "edges would take minutes, triangulate the mesh in the program that wrote it"
        )


def is_bent(rings: Sequence[FloatArray]) -> bool:
    """Check whether corners of an outline, and of its holes, are in no plane."""
    points = np.concatenate(rings) - rings[0].mean(axis=0)
    normal = _area_vectors(points[None, : len(rings[0])])[0]
    off = np.abs(points @ normal).max()
    return bool(off > _FLATNESS * np.ptp(points, axis=0).max() * np.linalg.norm(normal))


def cut(rings: Sequence[FloatArray], name: str) -> IntArray:
    """Triangulate one polygon, as indices into the corners of all its rings.

    Args:
        rings: corners (n, 3) of the outline, and of each hole.
        name: of the polygon, for a refusal.

    Raises:
        ValueError: it crosses itself, or has too many corners.
    """
    import manifold3d  # here, since few meshes need it

    points = np.concatenate(rings) - rings[0].mean(axis=0)
    size = float(np.ptp(points, axis=0).max())
    outline = points[: len(rings[0])]
    normal = _area_vectors(outline[None])[0]
    length = float(np.linalg.norm(normal))
    if length <= _ROUNDING * size**2:
        spread = np.linalg.svd(outline, compute_uv=False)
        if len(rings) == 1 and spread[1] <= _ROUNDING * size * len(outline):
            ids = np.arange(len(outline) - 2, dtype=np.int32)
            return np.stack([0 * ids, ids + 1, ids + 2], axis=1)
        raise _crossing(name)
    if len(points) > MOST_CORNERS:
        raise ValueError(
            f"polygons of at most {MOST_CORNERS:,} corners, {name} has {len(points):,}: "
            "triangulate the mesh in the program that wrote it"
        )
    plane = _plane(normal / length)
    ends = np.cumsum([len(ring) for ring in rings])
    contours: list[FloatArray] = []
    orders: list[IntArray] = []
    for start, end in zip([0, *ends[:-1].tolist()], ends.tolist(), strict=True):
        ring = np.arange(start, end, dtype=np.int32)
        turn = float(_area_vectors(points[None, ring])[0] @ normal)
        if (turn < 0) == (start == 0):
            ring = ring[::-1]  # a hole runs against its outline
        orders.append(ring)
        contours.append(np.ascontiguousarray(points[ring] @ plane.T))
    flat = np.concatenate(contours)
    order = np.concatenate(orders)
    ahead = np.concatenate([np.roll(contour, -1, axis=0) for contour in contours])
    if _cross_each_other(flat, ahead, _ROUNDING * size**2):
        raise _crossing(name)
    found = np.asarray(manifold3d.triangulate(contours), dtype=np.int32).reshape(-1, 3)
    a, b, c = (flat[found[:, k]] for k in range(3))
    areas = _cross(b - a, c - a)
    whole = float(_cross(flat, ahead).sum())
    if (
        len(found) != len(points) + 2 * len(rings) - 4
        or areas.min() < -_OVERLAP * size**2
        or abs(areas.sum() - whole) > _OVERLAP * size**2
    ):
        raise _crossing(name)
    return order[found]


def _plane(normal: FloatArray) -> FloatArray:
    """Two orthogonal unit vectors (2, 3) of the plane with a unit normal."""
    first = np.zeros(3)
    first[np.abs(normal).argmin()] = 1.0
    first -= first @ normal * normal
    first /= np.linalg.norm(first)
    return np.stack([first, _cross(normal, first)])


def _crossing(name: str) -> ValueError:
    return ValueError(
        f"polygons that do not cross themselves, {name} does: triangulate the mesh in the program "
        "that wrote it"
    )


def _fans(rings: FloatArray) -> tuple[IntArray, FloatArray]:
    """Corners (k,) from which fans fill polygons (k, n, 3), and distances from their planes, (k,).

    A corner is -1 where it takes more than a fan; a distance is a part of the polygon's size.
    """
    centred = rings - rings.mean(axis=1, keepdims=True)
    size = np.ptp(rings, axis=1).max(axis=1)
    normals = _area_vectors(centred)
    length = np.linalg.norm(normals, axis=1)
    has_area = length > _ROUNDING * size**2
    normals /= np.where(has_area, length, 1)[:, None]
    heights = np.abs(np.einsum("kni,ki->kn", centred, normals))
    off = np.divide(heights.max(axis=1), size, out=np.zeros_like(size), where=has_area)
    edges = np.roll(centred, -1, axis=1) - centred
    ahead = np.roll(edges, -1, axis=1)
    sines = np.einsum("kni,ki->kn", _cross(edges, ahead), normals)
    cosines = np.einsum("kni,kni->kn", edges, ahead)
    rises = np.einsum("kni,ki->kn", edges, normals)
    cosines -= rises * np.roll(rises, -1, axis=1)
    # a star turns left at every corner, too, but more than once around
    once = has_area & (np.abs(np.arctan2(sines, cosines).sum(axis=1) - 2 * np.pi) < 0.1)
    inward = sines < -_ROUNDING * size[:, None] ** 2
    starts = np.where(once & ~inward.any(axis=1), 0, -1)
    if rings.shape[1] == 4:
        # of four corners one at most points inward, which is the next of the edge's that turns
        starts = np.where(once & inward.any(axis=1), (inward.argmax(axis=1) + 1) % 4, starts)
    return starts.astype(np.int32), off


def _area_vectors(rings: FloatArray) -> FloatArray:
    """Twice the area vectors (k, 3) of closed polygons (k, n, 3), by Newell's formula."""
    return np.asarray(_cross(rings, np.roll(rings, -1, axis=1)).sum(axis=1))


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross products of vectors in space or in a plane; ``np.cross`` takes three times as long."""
    if a.shape[-1] == 2:
        return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
    (ax, ay, az), (bx, by, bz) = (np.moveaxis(one, -1, 0) for one in (a, b))
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def _cross_each_other(a: FloatArray, b: FloatArray, least: float) -> bool:
    """Check whether two of the edges from a (n, 2) to b (n, 2) cross at a point inside both.

    Edges that only touch do not: a hole may be joined to its outline by an edge there and back.
    """
    order = np.argsort(np.minimum(a[:, 0], b[:, 0]), kind="stable")
    a, b = a[order], b[order]
    low, high = np.minimum(a, b), np.maximum(a, b)
    # edges are compared with those that begin before they end along x
    partners = np.searchsorted(low[:, 0], high[:, 0], side="right") - np.arange(len(a)) - 1
    for some in np.array_split(np.arange(len(a)), 1 + int(partners.sum()) // _CHUNK):
        i = np.repeat(some, partners[some])
        j = i + 1 + np.arange(len(i)) - np.repeat(np.cumsum(partners[some]), partners[some])
        j += np.repeat(partners[some], partners[some])
        near = (low[i, 1] <= high[j, 1]) & (low[j, 1] <= high[i, 1])
        i, j = i[near], j[near]
        along, across = b[i] - a[i], b[j] - a[j]
        first, second = _cross(along, a[j] - a[i]), _cross(along, b[j] - a[i])
        third, fourth = _cross(across, a[i] - a[j]), _cross(across, b[i] - a[j])
        apart = np.minimum(
            np.minimum(np.abs(first), np.abs(second)), np.minimum(np.abs(third), np.abs(fourth))
        )
        if ((first * second < 0) & (third * fourth < 0) & (apart > least)).any():
            return True
    return False
