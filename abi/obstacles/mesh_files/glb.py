"""Reader of binary glTF 2.0 files (Khronos, glTF 2.0 specification, sections 3 and 4.4).

It reads the positions and triangles of the default scene, placed by its nodes. Everything must lie
in the file's own binary part; materials, textures, cameras and lights are ignored. What else is
left out is in the notes, and what would move or multiply the surface is refused.
"""

from __future__ import annotations

import json
import struct
from collections import Counter
from typing import Any

import numpy as np

from abi.obstacles.mesh_files.glb_nodes import placed_meshes
from abi.obstacles.mesh_files.parts import MeshFile, Parts, check_count, joined, placed
from abi.obstacles.mesh_files.words import counted, shown

_TYPES = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_HARMLESS = {
    *("KHR_materials_unlit", "KHR_materials_variants", "KHR_texture_transform"),
    *("KHR_lights_punctual", "KHR_texture_basisu", "EXT_texture_webp", "KHR_xmp_json_ld"),
    *("KHR_node_visibility", "KHR_node_selectability", "KHR_node_hoverability"),
    *("KHR_materials_anisotropy", "KHR_materials_clearcoat", "KHR_materials_diffuse_transmission"),
    *("KHR_materials_dispersion", "KHR_materials_emissive_strength", "KHR_materials_ior"),
    *("KHR_materials_iridescence", "KHR_materials_pbrSpecularGlossiness", "KHR_materials_sheen"),
    *("KHR_materials_specular", "KHR_materials_transmission", "KHR_materials_volume"),
    *("EXT_texture_avif", "MSFT_texture_dds", "EXT_lights_ies", "EXT_lights_image_based"),
}
"""Extensions that change no surface; an invisible node is still an obstacle."""
_MULTIPLYING = {
    *("EXT_mesh_gpu_instancing", "KHR_draco_mesh_compression", "KHR_gaussian_splatting"),
    *("EXT_meshopt_compression", "KHR_meshopt_compression"),
}
"""Extensions for triangles that the rest of the file does not have."""
_MOST_JSON = 8_000_000
_NO_AREA = {0: "point", 1: "line", 2: "line", 3: "line"}
_TRIANGLES, _STRIP, _FAN = 4, 5, 6


def read(data: bytes, most_faces: int) -> MeshFile:
    """Triangles of a GLB file in its own axes, in metres.

    Raises:
        ValueError: it is no such file; the message ends a sentence "expected …".
    """
    document, binary = _chunks(data)
    required = document.get("extensionsRequired", [])
    if not isinstance(required, list) or not all(name in _HARMLESS for name in required):
        raise ValueError(f"a GLB without compression or extensions, it needs {str(required)[:60]}")
    file = _File(document, binary, most_faces)
    parts: list[Parts] = []
    corners_read, faces_read = 0, 0
    file.check_extensions(document, "the file")
    meshes = placed_meshes(file.item, file.roots())
    for mesh, pose, weights in meshes:
        for triangles in file.triangles(mesh, weights):
            corners_read += len(triangles.vertices)
            faces_read += len(triangles.faces)
            if faces_read > most_faces or corners_read > 3 * most_faces:
                raise ValueError(f"at most {most_faces:,} triangles, simplify the mesh first")
            parts.append(placed(triangles, pose))
    check_count(faces_read, most_faces)
    return MeshFile(joined(parts), 1.0, file.left_out(len(meshes)), "y")


def _chunks(data: bytes) -> tuple[dict[str, Any], bytes]:
    """The document and the binary chunk; chunks must fill the file to the byte."""
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
    binary, at = b"", end
    while at < len(data):  # only the second may be binary, and others may be anything
        size, kind = struct.unpack_from("<I4s", data, at) if at + 8 <= len(data) else (0, b"")
        if not kind or at + 8 + size > len(data) or (kind == b"BIN\0" and at > end):
            raise ValueError("a whole GLB file, one of its parts has another length than announced")
        if at == end and kind == b"BIN\0":
            binary = data[at + 8 : at + 8 + size]
        at += 8 + size
    try:
        document = json.loads(
            data[20:end].decode(), parse_constant=_refuse, object_pairs_hook=_each_once
        )
    except (ValueError, RecursionError):
        raise ValueError("a GLB file, its description is not JSON with each name once") from None
    if not isinstance(document, dict):
        raise ValueError("a GLB file, its description is not a mapping")
    told = document.get("asset")
    asset = told if isinstance(told, dict) else {}
    version, least = str(asset.get("version", "2.0")), str(asset.get("minVersion", "2.0"))
    if least != "2.0" or not version.startswith("2."):
        version = version if least == "2.0" else least
        raise ValueError(f"glTF 2.0, but this asks for version {shown(version)}")
    return document, binary


def _weigh(weights: object) -> bool:
    """Check whether any of the given morph weights is not zero."""
    return any(weights) if isinstance(weights, list) else weights is not None


def _children(node: dict[str, Any]) -> list[object]:
    children = node.get("children")
    return children if isinstance(children, list) else []


def _refuse(constant: str) -> None:
    raise ValueError(constant)


def _each_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A mapping without duplicate names, of which readers could take either."""
    mapping = dict(pairs)
    if len(mapping) < len(pairs):
        raise ValueError
    return mapping


class _File:
    """The lists of a glTF document, with every reference checked before it is followed."""

    def __init__(self, document: dict[str, Any], binary: bytes, most_faces: int) -> None:
        self.document = document
        self._binary = binary
        self._most = 3 * most_faces
        self._no_area: Counter[str] = Counter()
        self._unknown: set[str] = set()
        self._morphs = False

    def item(self, kind: str, index: object) -> dict[str, Any]:
        """Entry ``index`` of the list ``kind``, without extensions that change surfaces."""
        entries = self.document.get(kind)
        if isinstance(entries, list) and type(index) is int and 0 <= index < len(entries):
            entry = entries[index]
            if isinstance(entry, dict):
                self.check_extensions(entry, f"{kind}[{index}]")
                return entry
        raise ValueError(f"a whole GLB file, {kind}[{str(index)[:12]}] is missing")

    def roots(self) -> object:
        """Numbers of the nodes that the default scene begins with; without scenes of all nodes'."""
        inner = {str(child) for node in self._entries("nodes") for child in _children(node)}
        if "scenes" in self.document:
            roots = self.item("scenes", self.document.get("scene", 0)).get("nodes", [])
            for root in roots if isinstance(roots, list) else ():
                if str(root) in inner:
                    raise ValueError(
                        "a GLB file whose nodes form trees, with whose roots its scene begins: "
                        f"nodes[{str(root)[:12]}] is in another"
                    )
            return roots
        nodes = self.document.get("nodes")
        count = len(nodes) if isinstance(nodes, list) else 0
        return [k for k in range(count) if str(k) not in inner]

    def triangles(self, index: object, weights: object = None) -> list[Parts]:
        """Vertices and triangles of each primitive of a mesh, whose morph weights must be zero."""
        mesh = self.item("meshes", index)
        primitives = mesh.get("primitives")
        if not isinstance(primitives, list):
            raise ValueError("a GLB file whose meshes have primitives")
        parts = []
        for primitive in primitives:
            mode = primitive.get("mode", _TRIANGLES) if isinstance(primitive, dict) else None
            if type(mode) is not int or not 0 <= mode <= _FAN:
                raise ValueError("a GLB file whose meshes have primitives of the kinds 0 to 6")
            if mode in _NO_AREA:
                self._no_area[_NO_AREA[mode]] += 1
                continue
            self.check_extensions(primitive, f"meshes[{index}]")
            if primitive.get("targets"):
                self._morphs = True
                if _weigh(weights) or (not weights and _weigh(mesh.get("weights"))):
                    raise ValueError(
                        f"a GLB whose morph targets have no weight, those of meshes[{index}] "
                        "have: apply them in the program that wrote it"
                    )
            parts.append(self._primitive(primitive, mode))
        return parts

    def left_out(self, placed_meshes: int) -> tuple[str, ...]:
        """Sentences on what of the file is not read, once its placed meshes are read.

        Args:
            placed_meshes: number of nodes of the default scene that have a mesh.
        """
        notes = [
            f"{counted(number, f'set of {noun}s', f'sets of {noun}s')} left out: no surface."
            for noun, number in self._no_area.items()
        ]
        if self._morphs:
            notes.append("Its morph targets are left out, as they have no weight.")
        nodes, meshes, scenes = (self._entries(kind) for kind in ("nodes", "meshes", "scenes"))
        if elsewhere := sum("mesh" in node for node in nodes) - placed_meshes:
            notes.append(f"{counted(elsewhere, 'node')} left out: not in its default scene.")
        used = {str(node.get("mesh")) for node in nodes}
        if unused := sum(str(k) not in used for k in range(len(meshes))):
            notes.append(f"{counted(unused, 'mesh', 'meshes')} left out: no node places it.")
        if "scenes" not in self.document:
            notes.append("It has no scene: all its nodes are read.")
        if (others := len(scenes) - 1) > 0:
            notes.append(f"{counted(others, 'scene')} left out: only the default one is read.")
        if self.document.get("animations"):
            notes.append("Its animations are left out.")
        if self._unknown:
            names = ", ".join(sorted(map(shown, self._unknown))[:3])
            notes.append(f"What its extensions {names} say is left out.")
        return tuple(notes)

    def _entries(self, kind: str) -> list[dict[str, Any]]:
        entries = self.document.get(kind)
        listed = entries if isinstance(entries, list) else []
        return [one for one in listed if isinstance(one, dict)]

    def check_extensions(self, entry: dict[str, Any], name: str) -> None:
        """Refuse extensions that multiply or compress triangles; note unknown ones."""
        extensions = entry.get("extensions", {})
        if not isinstance(extensions, dict):
            raise ValueError(f"a GLB file whose extensions are mappings, that of {name} is not")
        for one in extensions.keys() & _MULTIPLYING:
            raise ValueError(
                f"a GLB of plain triangles, {name} needs {one}: export it without compression "
                "and instancing"
            )
        self._unknown |= extensions.keys() - _HARMLESS

    def _primitive(self, primitive: dict[str, Any], mode: int) -> Parts:
        attributes = primitive.get("attributes")
        if not isinstance(attributes, dict):
            raise ValueError("a GLB file whose triangles have positions")
        vertices = self._numbers(attributes.get("POSITION"), "VEC3").astype(np.float64)
        if "indices" in primitive:
            ids = self._numbers(primitive["indices"], "SCALAR").ravel().astype(np.int64)
        else:
            ids = np.arange(len(vertices), dtype=np.int64)
        if ids.max() >= len(vertices) or len(ids) < 3 or (mode == _TRIANGLES and len(ids) % 3):
            raise ValueError("a GLB file whose triangles use the vertices there are")
        corners = ids.astype(np.int32)
        if mode == _TRIANGLES:
            return Parts(vertices, corners.reshape(-1, 3))
        if mode == _FAN:
            first = np.full(len(corners) - 2, corners[0])
            return Parts(vertices, np.stack([first, corners[1:-1], corners[2:]], axis=1))
        faces = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
        faces[1::2] = faces[1::2, [1, 0, 2]]
        return Parts(vertices, faces)

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
        size = buffer.get("byteLength")
        if type(size) is not int or not outer + length <= size <= len(self._binary):
            raise ValueError("a whole GLB file, its numbers go on past its end")
        if not row <= stride <= 252 or end > length:
            raise ValueError("a whole GLB file, its numbers go on past its end")
        values: np.ndarray[Any, Any] = np.ndarray(
            (count, columns), dtype, self._binary, outer + inner, (stride, dtype.itemsize)
        )
        return values.copy()
