"""Where the triangles of one shell cross, and what it winds around there.

A shell that crosses itself may wind a negative number of times around a part of what it encloses;
added to what another shell winds around it, that part would be hollow. Every cell of its complement
that no whole shell bounds has a piece of a line along which two triangles cross at its border. So
it is asked beside each of these pieces.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.obstacles.triangle_mesh.distinct_rows import distinct_rows, first_of_distinct_rows
from abi.obstacles.triangle_mesh.rays import near_boxes, rays_met
from abi.obstacles.triangle_mesh.welding import compact
from abi.obstacles.triangle_mesh.winding import windings

_TOUCHES = 1e-13
"""Distance of a corner from a triangle, over the size of all, at which it is on it."""
_SHAKEN = 1e-9
"""Where triangles touch, corners are moved by so much, over the size of all, so that they do not.
What is larger in each direction winds the same number of times then."""
_TRIES = 3
_BESIDE = 1e-11
"""Distance from a line at which it is asked what is there, over the size of all."""
_FOLD = 2e-4
"""Distance from a line, over the size of all, at which a shell that winds back still has to."""
_DIRECTION = np.array([0.283, 0.531, 0.799])
_MOST_ASKED = 20
"""Shells that wind back of which it is asked whether they meet others; more are taken to."""
_MOST_SHELLS = 2000
"""Shells of which it is asked one by one whether they wind back, in some ten seconds; of more, all
that cross or touch themselves are taken to."""
_MOST_LINES = 20_000
_MOST_PAIRS = 30_000_000
"""Pairs of an edge and a triangle that are near each other and are compared, in ten seconds or so;
shells with more are taken to be whole."""
_CROWD = 200
"""Triangles at one corner, as of a fan, from which on these are taken not to lie on each other."""
_AXES = np.array(
    [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.8, 0.53, 0.27], [-0.53, 0.8, 0.27], [0.27, -0.27, 0.93]]
)
"""Directions along which it is asked whether an edge and a triangle overlap."""
_WEDGES = np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)])


class Lines(NamedTuple):
    """Pieces of lines along which triangles cross.

    Attributes:
        triangles: (k, 2) numbers of both triangles.
        ends: (k, 2, 3) both ends.
        touching: (d,) numbers of triangles that touch others, where there may be more lines.
    """

    triangles: IntArray
    ends: FloatArray
    touching: IntArray


def crossing_shells(
    vertices: FloatArray, faces: IntArray, label: IntArray
) -> tuple[BoolArray, BoolArray, int]:
    """Shells that cross themselves, where their boxes overlap those of others.

    Args:
        vertices: (n, 3).
        faces: (m, 3) ids of the corners, facing outward.
        label: (m,) shell of each face, each number from 0 on.

    Returns:
        Mask (s,) of those that cross themselves; and of those of them that wind around something a
        negative number of times, or may, as where triangles lie on each other, and meet others; and
        the number of those with too many triangles near each other to be asked.
    """
    corners, count = vertices[faces], int(label.max()) + 1
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, label, corners.min(axis=1))
    np.maximum.at(high, label, corners.max(axis=1))
    overlaps = np.zeros(count, dtype=np.bool_)
    for one, other in near_boxes((low, high), (low, high)):
        overlaps[one[one != other]] = True
    crosses, winds_back = np.zeros((2, count), dtype=np.bool_)
    once = first_of_distinct_rows(np.column_stack([np.sort(faces, axis=1), label]).astype(np.int64))
    crosses[np.delete(label, once)] = True  # it may wind twice around what is behind
    asked = overlaps[label]
    if not asked.any():
        return crosses, winds_back, 0
    # each shell with corners of its own
    ids, own = np.unique(faces[asked] + label[asked, None] * len(vertices), return_inverse=True)
    lines = crossing_lines(vertices[ids % len(vertices)], own.reshape(-1, 3), label[asked])
    at: IntArray = label[asked]
    if lines is not None:
        at = label[asked][np.concatenate([lines.touching, lines.triangles[:, 0]])]
    found = np.unique(at)
    if lines is not None:
        crosses[found[_MOST_SHELLS:]] = winds_back[found[_MOST_SHELLS:]] = True
    order, unasked = np.argsort(label, kind="stable"), 0
    starts = np.searchsorted(label[order], np.arange(count + 1))
    for shell in found[:_MOST_SHELLS]:
        mine = compact(vertices, faces[order[starts[shell] : starts[shell + 1]]])
        of_shell = crossing_lines(*mine)
        unasked += of_shell is None
        back = None if of_shell is None else _winds_back(*mine, of_shell)
        crosses[shell] |= back is not None
        winds_back[shell] = bool(back)
    for shell in np.flatnonzero(winds_back)[:_MOST_ASKED]:
        winds_back[shell] = _meets_others(vertices, faces, label, int(shell))
    return crosses, winds_back, unasked + max(len(found) - _MOST_SHELLS, 0) * (lines is None)


def _meets_others(vertices: FloatArray, faces: IntArray, label: IntArray, shell: int) -> bool:
    """Whether a shell may touch others, is within one, or winds back around one."""
    mine = label == shell
    corners = vertices[faces]
    boxes = corners.min(axis=1), corners.max(axis=1)
    one, other = ((low[rows], high[rows]) for low, high in [boxes] for rows in (mine, ~mine))
    if any(len(near) for near, _ in near_boxes(one, other)):
        return True
    numbers, first = np.unique(label, return_index=True)
    places = vertices[faces[first[numbers != shell], 0]]
    if (windings(vertices, faces[mine], places) < 0).any():
        return True
    place = vertices[faces[mine][:1, 0]]
    _, number = np.unique(label, return_inverse=True)
    low, high = np.full((len(numbers), 3), np.inf), np.full((len(numbers), 3), -np.inf)
    np.minimum.at(low, number, boxes[0])
    np.maximum.at(high, number, boxes[1])
    within = ((low <= place) & (place <= high)).all(axis=1)
    around = numbers[within & (numbers != shell)]
    return any(windings(vertices, faces[label == each], place)[0] for each in around)


def _winds_back(vertices: FloatArray, faces: IntArray, lines: Lines) -> bool | None:
    """Whether a shell winds a negative number of times, or may; None if it does not cross itself.

    Args:
        vertices: (n, 3).
        faces: (m, 3) ids of the corners, facing outward.
        lines: along which they cross.
    """
    size, random = np.ptp(vertices, axis=0).max(), np.random.default_rng(0)
    for _ in range(_TRIES):
        if not len(lines.touching):
            break
        vertices = vertices + random.uniform(-_SHAKEN, _SHAKEN, vertices.shape) * size
        lines = crossing_lines(vertices, faces) or lines
    if not len(lines.touching) + len(lines.triangles):
        return None
    if len(lines.touching) or len(lines.triangles) > _MOST_LINES:
        return True
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = _unit(normals)
    number, middles = _middles(lines)
    ways = _WEDGES @ normals[lines.triangles[number]]
    beside = (middles[:, None] + _BESIDE * size * ways).reshape(-1, 3)
    point, _, side = rays_met(corners, beside, _DIRECTION)
    back = np.bincount(point, side, len(beside)) < -0.5
    if not back.any():
        return False
    # what is thinner is a fold of rounded numbers, and lies in what is solid around it
    beyond = (middles[:, None] + _FOLD * size * ways).reshape(-1, 3)[back]
    point, _, side = rays_met(corners, beyond, _DIRECTION)
    return bool((np.bincount(point, side, len(beyond)) < -0.5).any())


def crossing_lines(
    vertices: FloatArray, faces: IntArray, label: IntArray | None = None
) -> Lines | None:
    """Lines along which triangles of a shell cross, between places where an edge meets a triangle.

    None where too many of them are near each other to be compared.

    Args:
        vertices: (n, 3).
        faces: (m, 3) ids of the corners; shells have none in common.
        label: (m,) shell of each face; None if there is one only.
    """
    corners = vertices[faces]
    label = np.zeros(len(faces), dtype=np.int32) if label is None else label
    sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    first, of_side = distinct_rows(sides.astype(np.float64))
    edges, of_edge = sides[first], label[first // 3]
    ends, crowded = vertices[edges], np.bincount(faces.reshape(-1)) > _CROWD
    along = vertices @ _AXES.T
    edge_box, face_box = (
        (along[ids].min(axis=1), along[ids].max(axis=1)) for ids in (edges, faces)
    )
    touches = _TOUCHES * np.ptp(corners, axis=(0, 1)).max(initial=0.0)
    edge, face, places = [first[:0]], [first[:0]], [np.zeros((0, 3))]
    touching = [first[:0]]
    pairs = 0
    for one, other in near_boxes(edge_box, face_box):
        pairs += len(one)
        if pairs > _MOST_PAIRS:
            return None
        same = of_edge[one] == label[other]
        one, other = one[same], other[same]
        shared = (edges[one][:, :, None] == faces[other][:, None]).any(axis=2)
        few = ~(shared & crowded[edges[one]]).any(axis=1)
        touching.append(
            other[few][_folded(ends[one[few]], corners[other[few]], shared[few], touches)]
        )
        apart = ~shared.any(axis=1)
        one, other = one[apart], other[apart]
        met, place, doubtful = _pierced(ends[one], corners[other], touches)
        touching.append(other[doubtful])
        edge.append(one[met])
        face.append(other[met])
        places.append(place)
    lines, odd = _joined(
        faces,
        vertices,
        of_side,
        (np.concatenate(edge), np.concatenate(face)),
        np.concatenate(places),
    )
    return Lines(*lines, np.concatenate([*touching, odd]))


def _pierced(
    ends: FloatArray, corners: FloatArray, touches: float
) -> tuple[BoolArray, FloatArray, BoolArray]:
    """Mask (k,) of edges (k, 2, 3) that run through triangles (k, 3, 3), where; and in doubt."""
    a, b, c = corners.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    normal = _unit(normal)
    heights = np.einsum("ikj,ij->ik", ends - a[:, None], normal)
    flat = np.abs(heights) <= touches
    runs = (heights.prod(axis=1) < 0) | flat.any(axis=1)
    ends, normal, heights, flat, a, b, c = (
        one[runs] for one in (ends, normal, heights, flat, a, b, c)
    )
    # the part of the edge that is in the plane: a point, or all of it
    both = flat.all(axis=1)
    share = heights[:, 0] / np.where(both, 1.0, heights[:, 0] - heights[:, 1])
    start = ends[:, 0] + share[:, None] * (ends[:, 1] - ends[:, 0])
    start[both], stop = ends[both, 0], np.where(both[:, None], ends[:, 1], start)
    # clipped by the triangle's three sides, with and without the width of a touch
    low, high = np.zeros((2, len(start))), np.ones((2, len(start)))
    for tail, head in ((a, b), (b, c), (c, a)):
        inward = np.cross(normal, head - tail)
        inward = _unit(inward)
        first = np.einsum("ij,ij->i", start - tail, inward)
        last = np.einsum("ij,ij->i", stop - tail, inward)
        for k, width in enumerate((touches, -touches)):
            _clip(first + width, last + width, low[k], high[k])
    within, surely = low <= high
    doubtful, met = np.zeros((2, len(runs)), dtype=np.bool_)
    doubtful[runs] = within & (flat.any(axis=1) | ~surely)
    met[runs] = surely & ~flat.any(axis=1)
    return met, start[met[runs]], doubtful


def _clip(first: FloatArray, last: FloatArray, low: FloatArray, high: FloatArray) -> None:
    """Narrow the part of each way, from 0 to 1, to where a linear height is not below 0."""
    fall = first - last
    place = first / np.where(fall == 0, 1.0, fall)
    low[...] = np.where(fall < 0, np.maximum(low, place), low)
    high[...] = np.where(fall > 0, np.minimum(high, place), high)
    high[(fall == 0) & (first < 0)] = -1.0


def _folded(ends: FloatArray, corners: FloatArray, shared: BoolArray, touches: float) -> BoolArray:
    """Mask (k,) of edges that begin in a corner of a triangle and run along it, inside it."""
    starts = shared.sum(axis=1) == 1
    ends, corners, shared = ends[starts], corners[starts], shared[starts]
    first = np.where(shared[:, :1, None], ends[:, :1], ends[:, 1:])[:, 0]
    last = np.where(shared[:, :1, None], ends[:, 1:], ends[:, :1])[:, 0]
    place = np.linalg.norm(corners - first[:, None], axis=2).argmin(axis=1)
    b, c = (np.take_along_axis(corners, ((place + k) % 3)[:, None, None], 1)[:, 0] for k in (1, 2))
    normal = np.cross(b - first, c - first)
    normal = _unit(normal)
    way = last - first
    is_along = np.abs(np.einsum("ij,ij->i", way, normal)) <= touches
    beside_b = np.einsum("ij,ij->i", np.cross(b - first, way), normal)
    beside_c = np.einsum("ij,ij->i", np.cross(way, c - first), normal)
    width = touches * np.linalg.norm(way, axis=1)
    folded: BoolArray = starts.copy()
    folded[starts] = is_along & (beside_b > width) & (beside_c > width)
    return folded


def _joined(
    faces: IntArray,
    vertices: FloatArray,
    of_side: IntArray,
    pierced: tuple[IntArray, IntArray],
    places: FloatArray,
) -> tuple[tuple[IntArray, FloatArray], IntArray]:
    """Triangles and ends of lines between places (k, 3) where edges (k,) run through faces (k,).

    Also triangles that other than two such places are on.

    Args:
        faces: (m, 3).
        vertices: (n, 3).
        of_side: (3m,) edge of each face's sides.
        pierced: these edges and faces.
        places: see above.
    """
    edge, face = pierced
    order = np.argsort(of_side, kind="stable")
    starts = np.searchsorted(of_side[order], np.arange(int(of_side.max()) + 2))
    many = starts[edge + 1] - starts[edge]
    row = np.repeat(np.arange(len(edge)), many)
    step = np.arange(len(row)) - np.repeat(np.cumsum(many) - many, many)
    other = order[starts[edge[row]] + step] // 3
    pairs = np.sort(np.stack([other, face[row]], axis=1), axis=1)
    triangles, number = np.unique(pairs, axis=0, return_inverse=True)
    ends = np.bincount(number)
    order = np.argsort(number, kind="stable")
    first = np.cumsum(ends) - ends
    begin = places[row[order[first]]]
    # where they have a corner in common, the line begins there
    one, two = faces[triangles.T]
    same = (one[:, :, None] == two[:, None]).any(axis=2)
    corner = vertices[np.take_along_axis(one, same.argmax(axis=1)[:, None], 1)[:, 0]]
    last = places[row[order[np.minimum(first + 1, len(order) - 1)]]]
    end = np.where((ends == 2)[:, None], last, corner)
    odd = (ends > 2) | ((ends == 1) & (same.sum(axis=1) != 1))
    return (triangles, np.stack([begin, end], axis=1)), triangles[odd, 0]


def _middles(lines: Lines) -> tuple[IntArray, FloatArray]:
    """Numbers (p,) of lines, and the middle (p, 3) of each piece that others cut them into."""
    count = len(lines.triangles)
    # pairs of lines in the same triangle
    triangle, line = lines.triangles.T.ravel(), np.tile(np.arange(count), 2)
    order = np.argsort(triangle, kind="stable")
    triangle, line = triangle[order], line[order]
    starts = np.searchsorted(triangle, triangle)
    many = np.searchsorted(triangle, triangle, side="right") - starts
    row = np.repeat(np.arange(len(line)), many)
    step = np.arange(len(row)) - np.repeat(np.cumsum(many) - many, many)
    one, other = line[row], line[starts[row] + step]
    one, other = one[one != other], other[one != other]
    place = _meeting(lines.ends[one], lines.ends[other])
    inside = (place > 0) & (place < 1)
    cut = np.concatenate([one[inside], np.arange(count), np.arange(count)])
    at = np.concatenate([place[inside], np.zeros(count), np.ones(count)])
    order = np.lexsort((at, cut))
    cut, at = cut[order], at[order]
    follows = np.flatnonzero(cut[1:] == cut[:-1])
    number, share = cut[follows], (at[follows] + at[follows + 1]) / 2
    ends = lines.ends[number]
    return number, ends[:, 0] + share[:, None] * (ends[:, 1] - ends[:, 0])


def _meeting(ones: FloatArray, others: FloatArray) -> FloatArray:
    """Place (k,) on lines (k, 2, 3), from 0 to 1, where others (k, 2, 3) in their plane meet it."""
    way, across = ones[:, 1] - ones[:, 0], others[:, 1] - others[:, 0]
    normal = np.cross(way, across)
    square = np.einsum("ij,ij->i", normal, normal)
    offset = np.cross(others[:, 0] - ones[:, 0], across)
    place = np.einsum("ij,ij->i", offset, normal) / np.where(square > 0, square, 1.0)
    return np.where(square > 0, place, -1.0)


def _unit(vectors: FloatArray) -> FloatArray:
    """Vectors (k, 3) of length 1; 0 where they are."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(lengths > 0, lengths, 1.0))
