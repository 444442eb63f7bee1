"""Number of triangles that a mesh file places, counted without its reader.

The readers build surfaces; these functions only follow what each format says of its numbers: its
headers, counts, lists and references. They share no code with the readers, so that a part that a
reader overlooks is missed at once.
"""

from __future__ import annotations

import io
import json
import re
import struct
import xml.etree.ElementTree as ElementTree
import zipfile
from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial
from typing import Any
from urllib.parse import unquote

_DEEPEST = 250
_MISSHAPEN = ValueError, LookupError, TypeError, AttributeError, RecursionError
_OBJ_TEXT = (
    rb"(?<![^\r\n])[ \t]*"
    rb"(#|(g|o|s|usemtl|mtllib|usemap|maplib|shadow_obj|trace_obj)[ \t])[^\r\n]*"
)
"""Statements of an OBJ that are comments or names."""
_SIZES = {
    **{"char": 1, "uchar": 1, "short": 2, "ushort": 2, "int": 4, "uint": 4, "float": 4},
    **{"int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4, "uint32": 4, "float32": 4},
    **{"double": 8, "float64": 8},
}
_CODES = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I"}
_CODES |= {"int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I"}


def count(data: bytes, suffix: str) -> int:
    """Number of triangles of a valid file; a polygon with n corners counts as n − 2.

    Args:
        data: content.
        suffix: of the file's name, such as ".ply".

    Raises:
        ValueError: its structure cannot be followed.
    """
    try:
        return _COUNTS[suffix](data)
    except (*_MISSHAPEN, ElementTree.ParseError, struct.error):
        raise ValueError("a file whose triangles can be counted") from None


def _stl(data: bytes) -> int:
    if len(data) == 84 + 50 * int.from_bytes(data[80:84], "little"):
        return int.from_bytes(data[80:84], "little")
    lines = [line.split() for line in re.split(rb"[\r\n]", data.lower())]
    words = [word for line in lines if line[:1] not in ([b"solid"], [b"endsolid"]) for word in line]
    return words.count(b"vertex") - 2 * words.count(b"endloop")


def _obj(data: bytes) -> int:
    text = re.sub(_OBJ_TEXT, b"", data)
    text = re.sub(rb"\\(\r\n|\r|\n)", b" ", text)
    faces = re.finditer(rb"(?:^|[\r\n])[ \t]*fo?[ \t]([^\r\n]*)", text)
    return sum(max(len(face[1].partition(b"#")[0].split()) - 2, 0) for face in faces)


def _off(data: bytes) -> int:
    lines = [words for line in data.splitlines() if (words := line.partition(b"#")[0].split())]
    head = b" ".join(b" ".join(lines[0] + (lines[1] if len(lines[0]) == 1 else [])).split()[1:])
    faces = int(head.split()[1])
    return sum(max(int(words[0]) - 2, 0) for words in lines[len(lines) - faces :]) if faces else 0


def _ply(data: bytes) -> int:
    """Corners of faces and strips, row by row."""
    end = re.search(rb"(?<=[\r\n])end_header[ \t]*(\r\n|\n|\r)", data)
    assert end is not None
    header = [line.decode("latin-1").split() for line in data[: end.start()].splitlines()]
    kind = next(words[1] for words in header if words[:1] == ["format"])
    if kind == "ascii":
        rows: Iterator[tuple[str, str, list[float]]] = _text_lists(data[end.end() :], header)
    else:
        rows = _binary_lists(data[end.end() :], header, "<" if "little" in kind else ">")
    total = 0
    for element, name, values in rows:
        if name not in ("vertex_indices", "vertex_index"):
            continue
        if element == "face":
            total += max(len(values) - 2, 0)
        elif element == "tristrips":
            text = ",".join("|" if value == -1 else "x" for value in values)
            total += sum(max(run.count("x") - 2, 0) for run in text.split("|"))
    return total


def _elements(header: list[list[str]]) -> Iterator[tuple[str, int, list[list[str]]]]:
    names = [k for k, words in enumerate(header) if words[:1] == ["element"]]
    for k, following in zip(names, [*names[1:], len(header)], strict=True):
        properties = [words for words in header[k + 1 : following] if words[:1] == ["property"]]
        yield header[k][1], int(header[k][2]), properties


def _text_lists(body: bytes, header: list[list[str]]) -> Iterator[tuple[str, str, list[float]]]:
    words = iter(body.split())
    for element, rows, properties in _elements(header):
        for _ in range(rows if properties else 0):
            for words_of in properties:
                first = next(words)
                if words_of[1] == "list":
                    length = int(float(first))
                    yield element, words_of[4], [float(next(words)) for _ in range(length)]


def _binary_lists(
    body: bytes, header: list[list[str]], order: str
) -> Iterator[tuple[str, str, list[float]]]:
    at = 0
    for element, rows, properties in _elements(header):
        if not any(one[1] == "list" for one in properties):
            at += rows * sum(_SIZES[one[1]] for one in properties)
            continue
        for _ in range(rows):
            for one in properties:
                if one[1] != "list":
                    at += _SIZES[one[1]]
                    continue
                (length,) = struct.unpack_from(order + _CODES[one[2]], body, at)
                at += _SIZES[one[2]]
                values: list[float] = [0.0] * length
                if element == "tristrips" and one[4] in ("vertex_indices", "vertex_index"):
                    values = list(struct.unpack_from(f"{order}{length}{_CODES[one[3]]}", body, at))
                yield element, one[4], values
                at += length * _SIZES[one[3]]


def _glb(data: bytes) -> int:
    document = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    nodes = document.get("nodes", [])
    if "scenes" in document:
        waiting = list(document["scenes"][document.get("scene", 0)].get("nodes", []))
    else:
        inner = {child for node in nodes for child in node.get("children", [])}
        waiting = [k for k in range(len(nodes)) if k not in inner]
    total = 0
    for _ in range(10_001):
        if not waiting:
            return total
        node = nodes[waiting.pop()]
        waiting += node.get("children", [])
        total += _glb_mesh(document, node["mesh"]) if "mesh" in node else 0
    raise ValueError


def _glb_mesh(document: Mapping[str, Any], index: int) -> int:
    total = 0
    for primitive in document["meshes"][index]["primitives"]:
        numbers = primitive.get("indices", primitive.get("attributes", {}).get("POSITION"))
        corners = document["accessors"][numbers]["count"]
        mode = primitive.get("mode", 4)
        total += corners // 3 if mode == 4 else corners - 2 if mode > 4 else 0
    return total


def _3mf(data: bytes) -> int:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        files = {name.lower(): archive.read(name) for name in archive.namelist()}
    root = "3d/3dmodel.model"
    if "_rels/.rels" in files:
        for one in ElementTree.fromstring(files["_rels/.rels"]).iter():
            if one.get("Type", "").lower().endswith("/3dmodel"):
                root = one.get("Target", "").strip().lstrip("/").lower()
                break
    models = cache(partial(_3mf_model, files))
    build = models(root).findall("{*}build/{*}item")
    return sum(_3mf_object(models, *_3mf_key(item, root), {}, 0) for item in build)


def _3mf_model(files: Mapping[str, bytes], path: str) -> ElementTree.Element:
    """Root of one of an archive's models."""
    return ElementTree.fromstring(files[path if path in files else unquote(path)])


def _3mf_key(element: ElementTree.Element, model: str) -> tuple[str, str]:
    path = next((value for name, value in element.items() if name.endswith("}path")), "")
    return path.strip().lstrip("/").lower() or model, str(int(element.get("objectid", "")))


def _3mf_object(
    models: Callable[[str], ElementTree.Element],
    model: str,
    number: str,
    known: dict[tuple[str, str], int],
    depth: int,
) -> int:
    if depth > _DEEPEST:
        raise ValueError
    if (model, number) not in known:
        objects = models(model).findall("{*}resources/{*}object")
        found = next(one for one in objects if int(one.get("id", "")) == int(number))
        known[model, number] = len(found.findall("{*}mesh/{*}triangles/{*}triangle")) + sum(
            _3mf_object(models, *_3mf_key(one, model), known, depth + 1)
            for one in found.findall("{*}components/{*}component")
        )
    return known[model, number]


def _dae(data: bytes) -> int:
    root = ElementTree.fromstring(data)
    ids = {(one.tag.rpartition("}")[2], one.get("id")): one for one in root.iter()}
    opened = root.find("{*}scene/{*}instance_visual_scene")
    assert opened is not None
    url = opened.get("url", "").strip()[1:]
    scene = ids["visual_scene", url if ("visual_scene", url) in ids else unquote(url)]
    return sum(_dae_node(ids, node, 0) for node in scene.findall("{*}node"))


def _dae_node(
    ids: Mapping[tuple[str, str | None], ElementTree.Element],
    node: ElementTree.Element,
    depth: int,
) -> int:
    if depth > _DEEPEST:
        raise ValueError
    total = 0
    for one in node:
        kind, url = one.tag.rpartition("}")[2], one.get("url", "").strip()[1:]
        url = url if (kind.removeprefix("instance_"), url) in ids else unquote(url)
        if kind == "node":
            total += _dae_node(ids, one, depth + 1)
        elif kind == "instance_node":
            total += _dae_node(ids, ids["node", url], depth + 1)
        elif kind == "instance_geometry":
            total += _dae_geometry(ids["geometry", url])
    return total


def _dae_geometry(geometry: ElementTree.Element) -> int:
    """Triangles by the element counts; only strips and fans do not state their length."""
    total = 0
    for one in geometry.findall("{*}mesh/*"):
        kind = one.tag.rpartition("}")[2]
        lists = [_length(p) for p in one.findall("{*}p")]
        stride = 1 + max((int(k.get("offset", 0)) for k in one.findall("{*}input")), default=0)
        if kind == "triangles":
            total += int(one.get("count", ""))
        elif kind == "polylist":
            sizes = [int(word) for word in one.findtext("{*}vcount", "").split()]
            if len(sizes) != int(one.get("count", "")):
                raise ValueError
            total += sum(max(size - 2, 0) for size in sizes)
        elif kind in ("trifans", "tristrips", "polygons"):
            total += sum(max(length // stride - 2, 0) for length in lists)
            for holed in one.findall("{*}ph"):
                rings = [
                    _length(ring) // stride for ring in holed if ring.tag.endswith(("}p", "}h"))
                ]
                total += sum(rings) + 2 * len(rings) - 4
    return total


def _length(element: ElementTree.Element) -> int:
    return len("".join(element.itertext()).split())


_COUNTS = {
    **{".stl": _stl, ".obj": _obj, ".glb": _glb, ".ply": _ply, ".off": _off},
    **{".3mf": _3mf, ".dae": _dae},
}
