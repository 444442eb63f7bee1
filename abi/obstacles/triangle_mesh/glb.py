"""Reader of binary glTF 2.0 files (Khronos, glTF 2.0 specification, sections 3 and 4.4).

It reads the positions and triangles of the default scene, placed by its nodes. Everything must lie
in the file's own binary part; materials, textures, cameras and lights are ignored.

trimesh reads GLB too, but every check below would be needed first, and it leaves out meshes at a
node with a camera.
"""

from __future__ import annotations

import json
import math
import struct
from typing import Any

import numpy as np

from abi.arrays import FloatArray, IntArray
from abi.obstacles.pose import rotation
from abi.obstacles.triangle_mesh.parts import NO_COLOURS, Parts, check_count

_TYPES = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_LOOKS = {"KHR_materials_unlit", "KHR_texture_transform", "KHR_lights_punctual"}
_MOST_JSON = 8_000_000
_MOST_NODES = 10_000
_LARGEST = 1e9


def read(data: bytes, most_faces: int) -> Parts:
    """Vertices (n, 3) and triangles (m, 3) of a GLB file in its own axes.

    Raises:
        ValueError: it is no such file; the message ends a sentence "expected …".
    """
    document, binary = _chunks(data)
    required = document.get("extensionsRequired", [])
    if not isinstance(required, list) or not all(name in _LOOKS for name in required):
        raise ValueError(f"a GLB without compression or extensions, it needs {str(required)[:60]}")
    file = _File(document, binary, most_faces)
    vertices: list[FloatArray] = []
    faces: list[IntArray] = []
    corners_read, faces_read = 0, 0
    for mesh, pose in _placed_meshes(file):
        for corners, triangles in file.triangles(mesh):
            turned = triangles[:, ::-1] if np.linalg.det(pose[:3, :3]) < 0 else triangles
            faces.append(turned + np.int32(corners_read))
            vertices.append(corners @ pose[:3, :3].T + pose[:3, 3])
            corners_read += len(corners)
            faces_read += len(triangles)
            if faces_read > most_faces or corners_read > 3 * most_faces:
                raise ValueError(f"at most {most_faces:,} triangles, simplify the mesh first")
    check_count(faces_read, most_faces)
    return np.concatenate(vertices), np.concatenate(faces), NO_COLOURS


def _chunks(data: bytes) -> tuple[dict[str, Any], bytes]:
    """The document and the binary part; the file's two parts must fill it to the byte."""
    if len(data) < 20 or data[:4] != b"glTF":
        raise ValueError("a GLB file, this does not begin like one")
    version, total, length, kind = struct.unpack_from("<III4s", data, 4)
    end = 20 + length
    if version != 2:
        raise ValueError(f"glTF 2, but this is version {version}")
    if total != len(data) or kind != b"JSON" or end > len(data):
        raise ValueError(f"a whole GLB file, it announces {total:,} bytes and has {len(data):,}")
    if length > _MOST_JSON:
        raise ValueError("a GLB file whose description is under 8 MB")
    binary = b""
    if end < len(data):
        if end + 8 > len(data):
            raise ValueError("a whole GLB file, but its second part is cut off")
        size, kind = struct.unpack_from("<I4s", data, end)
        if kind != b"BIN\0" or end + 8 + size != len(data):
            raise ValueError("a whole GLB file, its binary part has another length than announced")
        binary = data[end + 8 :]
    try:
        document = json.loads(data[20:end].decode(), parse_constant=_refuse)
    except (ValueError, RecursionError):
        raise ValueError("a GLB file, its description is not JSON") from None
    if not isinstance(document, dict):
        raise ValueError("a GLB file, its description is not a mapping")
    return document, binary


def _refuse(constant: str) -> None:
    raise ValueError(constant)


class _File:
    """The lists of a glTF document, with every reference checked before it is followed."""

    def __init__(self, document: dict[str, Any], binary: bytes, most_faces: int) -> None:
        self.document = document
        self._binary = binary
        self._most = 3 * most_faces

    def item(self, kind: str, index: object) -> dict[str, Any]:
        """Entry ``index`` of the list ``kind``."""
        entries = self.document.get(kind)
        if isinstance(entries, list) and type(index) is int and 0 <= index < len(entries):
            entry = entries[index]
            if isinstance(entry, dict):
                return entry
        raise ValueError(f"a whole GLB file, {kind}[{str(index)[:12]}] is missing")

    def triangles(self, index: object) -> list[tuple[FloatArray, IntArray]]:
        """Vertices and triangles of each primitive of a mesh."""
        primitives = self.item("meshes", index).get("primitives")
        if not isinstance(primitives, list):
            raise ValueError("a GLB file whose meshes have primitives")
        parts = []
        for primitive in primitives:
            if not isinstance(primitive, dict) or primitive.get("mode", 4) != 4:
                raise ValueError("a GLB of plain triangles, without points, lines or strips")
            if primitive.get("extensions") or primitive.get("targets"):
                raise ValueError("a GLB of plain triangles, without compression or morphing")
            attributes = primitive.get("attributes")
            if not isinstance(attributes, dict):
                raise ValueError("a GLB file whose triangles have positions")
            vertices = self._numbers(attributes.get("POSITION"), "VEC3").astype(np.float64)
            if "indices" in primitive:
                ids = self._numbers(primitive["indices"], "SCALAR").ravel().astype(np.int64)
            else:
                ids = np.arange(len(vertices), dtype=np.int64)
            if len(ids) % 3 or ids.max() >= len(vertices):
                raise ValueError("a GLB file whose triangles use the vertices there are")
            parts.append((vertices, ids.astype(np.int32).reshape(-1, 3)))
        return parts

    def _numbers(self, index: object, kind: str) -> np.ndarray[Any, Any]:
        """Values of an accessor, (n, 3) or (n, 1), copied out of the binary part."""
        accessor = self.item("accessors", index)
        count, columns = accessor.get("count"), 3 if kind == "VEC3" else 1
        if accessor.get("sparse") is not None or "bufferView" not in accessor:
            raise ValueError("a GLB file whose numbers all stand in it")
        if type(count) is not int or not 0 < count <= self._most:
            raise ValueError(f"at most {self._most:,} numbers in a row, not {str(count)[:20]}")
        if accessor.get("type") != kind or accessor.get("componentType") not in _TYPES:
            raise ValueError("a GLB file of float positions and unsigned indices")
        dtype = np.dtype(_TYPES[accessor["componentType"]])
        if (dtype.kind == "f") != (kind == "VEC3"):
            raise ValueError("a GLB file of float positions and unsigned indices")
        view = self.item("bufferViews", accessor["bufferView"])
        buffer = self.item("buffers", view.get("buffer"))
        if view["buffer"] != 0 or "uri" in buffer:
            raise ValueError("a mesh in one file, but this GLB refers to another")
        row = columns * dtype.itemsize
        inner, outer = accessor.get("byteOffset", 0), view.get("byteOffset", 0)
        length, stride = view.get("byteLength"), view.get("byteStride", row)
        if any(type(number) is not int or number < 0 for number in (inner, outer, length, stride)):
            raise ValueError("a GLB file with whole numbers for its lengths")
        end = inner + stride * (count - 1) + row
        if not row <= stride <= 252 or end > length or outer + length > len(self._binary):
            raise ValueError("a whole GLB file, its numbers go on past its end")
        values: np.ndarray[Any, Any] = np.ndarray(
            (count, columns), dtype, self._binary, outer + inner, (stride, dtype.itemsize)
        )
        return values.copy()


def _placed_meshes(file: _File) -> list[tuple[object, FloatArray]]:
    """Meshes of the default scene and the pose (4, 4) each is placed by; nodes form a forest."""
    roots = file.item("scenes", file.document.get("scene", 0)).get("nodes", [])
    waiting: list[tuple[object, FloatArray]] = [(root, np.eye(4)) for root in _ids(roots)]
    seen: set[object] = set()
    placed = []
    while waiting:
        index, outer = waiting.pop()
        node = file.item("nodes", index)
        if index in seen or len(seen) > _MOST_NODES:
            raise ValueError("a GLB file whose nodes form a tree of at most 10,000")
        seen.add(index)
        pose = outer @ _pose(node)
        if not np.isfinite(pose).all() or np.abs(pose).max() > _LARGEST:
            raise ValueError("a GLB file whose nodes stay within 1e9")
        if "skin" in node:
            raise ValueError("a GLB file without a skeleton")
        if "mesh" in node:
            placed.append((node["mesh"], pose))
        waiting += [(child, pose) for child in _ids(node.get("children", []))]
    return placed


def _ids(values: object) -> list[object]:
    if not isinstance(values, list):
        raise ValueError("a GLB file whose nodes are lists")
    return values


def _pose(node: dict[str, Any]) -> FloatArray:
    """Local pose (4, 4) of a node: its matrix, or translation times rotation times scale."""
    if "matrix" in node:
        return _floats(node["matrix"], 16).reshape(4, 4).T
    pose = np.eye(4)
    x, y, z, w = _floats(node.get("rotation", [0, 0, 0, 1]), 4).tolist()
    if not math.hypot(x, y, z, w) > 1e-6:
        raise ValueError("a GLB file whose rotations are not zero")
    pose[:3, :3] = rotation((w, x, y, z)) * _floats(node.get("scale", [1, 1, 1]), 3)
    pose[:3, 3] = _floats(node.get("translation", [0, 0, 0]), 3)
    return pose


def _floats(values: object, count: int) -> FloatArray:
    if (
        not isinstance(values, list)
        or len(values) != count
        or any(type(v) not in (int, float) or not abs(v) <= _LARGEST for v in values)
    ):
        raise ValueError(f"a GLB file whose poses are {count} numbers within 1e9")
    return np.array(values, dtype=np.float64)
