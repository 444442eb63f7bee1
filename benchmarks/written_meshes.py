"""Random STL, OBJ, PLY and OFF files with the surface that they describe."""

from __future__ import annotations

import struct
from typing import NamedTuple

import numpy as np

from abi.arrays import FloatArray
from benchmarks.written_shapes import Chance, Written, placed, pose, solid, together


class _Polygons(NamedTuple):
    """Vertices (n, 3) and polygons of solids, and their true surface (k, 3, 3)."""

    vertices: FloatArray
    polygons: list[tuple[int, ...]]
    surface: FloatArray
    crossed: bool


def stl(chance: Chance) -> Written:
    """Binary or text, of one or several solids."""
    surfaces = [placed(solid(chance).surface, pose(chance)) for _ in range(chance.randint(1, 3))]
    surface = together(surfaces).astype("<f4").astype(float)
    if chance.random() < 0.5:
        records = b"".join(
            struct.pack("<12fH", 0, 0, 0, *triangle.ravel(), 0) for triangle in surface
        )
        header = chance.choice((b"solid of facets", b"made by chance")).ljust(80, b" ")
        return Written(".stl", header + struct.pack("<I", len(surface)) + records, surface)
    name = chance.choice(("", " part facet 1", " Gehäuse"))
    lines = []
    for part in surfaces:
        lines.append(f"solid{name}")
        for triangle in part.astype("<f4"):
            lines += ["facet normal 0 0 0", " outer loop"]
            lines += [f"  vertex {x!r} {y!r} {z!r}" for x, y, z in triangle.astype(float).tolist()]
            lines += [" endloop", "endfacet"]
        lines.append(f"endsolid{name}")
    text = chance.choice(("\n", "\r\n")).join(lines)
    if chance.random() < 0.2:
        text = text.replace("facet", "FACET")
    return Written(".stl", text.encode("latin-1"), surface)


def obj(chance: Chance) -> Written:
    """With groups, unused text, lines and points, relative ids and lines that go on."""
    found = _polygons(chance)
    vertices = [f"v {x!r} {y!r} {z!r}" for x, y, z in found.vertices.tolist()]
    count, style = len(vertices), chance.choice(("{0}", "{0}/1", "{0}//1", "{0}/1/1"))
    relative = chance.random() < 0.3
    faces, left_out, refused = [], False, found.crossed
    for polygon in found.polygons:
        ids = [k - count if relative else k + 1 for k in polygon]
        words = [style.format(k) for k in ids]
        if chance.random() < 0.1:
            words.insert(2, "\\\n")
        faces.append("f " + " ".join(words))
        if chance.random() < 0.05:
            faces.append(chance.choice(("g Türgriff links", "usemtl mat:1", "s off", "o a b c")))
    if chance.random() < 0.2:
        faces.append(chance.choice(("f 1 2", "l 1 2 3", "p 1", "curv 0 1 1 2")))
        left_out = True
    if chance.random() < 0.05:
        faces.append("surf 0 1 0 1 1 2 3 4")
        refused = True
    rest = ["vt 0 0", "vn 0 0 1"]
    head = chance.sample(
        ["mtllib C:\\Teile\\größe.mtl", "# made", "o part", "cstype bezier", "# C:\\Teile\\"], 3
    )
    if chance.random() < 0.2:  # faces before their vertices
        lines = [*head, *rest, *(faces if not relative else []), *vertices]
        lines += faces if relative else []
    else:
        lines = [*head, *vertices, *rest, *faces]
    text = chance.choice(("\n", "\r\n", "\r")).join("\n".join(lines).split("\n"))
    content = text.encode(chance.choice(("utf-8", "latin-1")))
    return Written(".obj", content, found.surface, None, left_out, refused)


def ply(chance: Chance) -> Written:
    """Text or binary in either order, with other properties and elements."""
    found = _polygons(chance)
    kind = chance.choice(("ascii", "binary_little_endian", "binary_big_endian"))
    number, length = chance.choice(("float", "double")), chance.choice(("uchar", "int", "ushort"))
    index, extra = chance.choice(("int", "uint", "ushort")), chance.random() < 0.3
    code = {"float": "f", "double": "d", "uchar": "B", "int": "i", "ushort": "H", "uint": "I"}
    rows: list[tuple[str, list[float]]] = []
    for corner in found.vertices.tolist():
        rows.append((code[number] * 3 + "B" * extra, [*corner, *([7] * extra)]))
    for polygon in found.polygons:
        form = code[length] + code[index] * len(polygon) + "B" * extra
        rows.append((form, [len(polygon), *polygon, *([9] * extra)]))
    vertex = [f"property {number} {axis}" for axis in "xyz"]
    vertex += ["property uchar quality"] * extra
    face = [f"property list {length} {index} {chance.choice(('vertex_indices', 'vertex_index'))}"]
    face += ["property uchar flags"] * extra
    left_out = chance.random() < 0.2
    header = ["ply", f"format {kind} 1.0", "comment made by chance"]
    header += [f"element vertex {len(found.vertices)}", *vertex]
    header += [f"element face {len(found.polygons)}", *face]
    if left_out:
        header += ["element edge 1", "property int vertex1", "property int vertex2"]
        rows.append(("ii", [0, 1]))
    end = "\n" if kind != "ascii" else chance.choice(("\n", "\r\n"))
    body = b"".join(
        (" ".join(f"{v!r}" for v in values) + end).encode()
        if kind == "ascii"
        else struct.pack(
            (">" if "big" in kind else "<") + form,
            *(v if c in "fd" else int(v) for c, v in zip(form, values, strict=True)),
        )
        for form, values in rows
    )
    content = end.join([*header, "end_header", ""]).encode() + body
    return Written(".ply", content, found.surface, None, left_out, found.crossed)


def off(chance: Chance) -> Written:
    """With colours, normals, comments, and faces of two corners."""
    found = _polygons(chance)
    kind, extra = chance.choice((("OFF", ""), ("COFF", " 1 0 0 1"), ("NOFF", " 0 0 1")))
    lines = [f"{x!r} {y!r} {z!r}{extra}" for x, y, z in found.vertices.tolist()]
    colour = chance.choice(("", " 255 0 0", " 0.1 0.2 0.3 1"))
    faces = [f"{len(p)} {' '.join(map(str, p))}{colour}" for p in found.polygons]
    left_out = chance.random() < 0.2
    if left_out:
        faces.append("2 0 1")
    counts = f"{len(lines)} {len(faces)} 0"
    head = [f"{kind} {counts}"] if chance.random() < 0.3 else [kind, "# made by chance", counts]
    text = chance.choice(("\n", "\r\n")).join([*head, *lines, "", *faces, ""])
    return Written(".off", text.encode(), found.surface, None, left_out, found.crossed)


def _polygons(chance: Chance) -> _Polygons:
    """Solids placed at random; a few with a polygon that crosses itself."""
    vertices: list[FloatArray] = []
    polygons: list[tuple[int, ...]] = []
    surfaces = []
    for _ in range(chance.randint(1, 3)):
        one, at = solid(chance), pose(chance)
        first, mirrored = sum(map(len, vertices)), np.linalg.det(at[:3, :3]) < 0
        vertices.append(one.vertices @ at[:3, :3].T + at[:3, 3])
        for polygon in one.polygons:
            ids = tuple(first + k for k in (polygon[::-1] if mirrored else polygon))
            polygons.append(ids)
        surfaces.append(placed(one.surface, at))
    crossed = chance.random() < 0.05
    if crossed:
        whole = next(k for k, polygon in enumerate(polygons) if len(polygon) == 4)
        a, b, c, d = polygons[whole]
        polygons[whole] = (a, c, b, d)
    return _Polygons(np.concatenate(vertices), polygons, together(surfaces), crossed)
