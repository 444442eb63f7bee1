"""Random GLB files with the surface that their default scene places."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
import scipy

from abi.arrays import FloatArray
from benchmarks.written_shapes import Chance, Solid, Written, placed, pose, solid, together

_INDEX = {5121: "<u1", 5123: "<u2", 5125: "<u4"}


class _Glb:
    """A document, its binary part, and the surface of each mesh."""

    def __init__(self, chance: Chance) -> None:
        self.chance = chance
        self.binary = b""
        lists = ("nodes", "meshes", "accessors", "bufferViews", "scenes")
        self.document: dict[str, Any] = {name: [] for name in lists}
        self.surfaces: list[FloatArray] = []
        self.packed: set[int] = set()
        self.left_out = self.refused = False

    def add(self, kind: str, entry: dict[str, Any]) -> int:
        """Add an entry to a list, and return its number."""
        self.document[kind].append(entry)
        return len(self.document[kind]) - 1

    def numbers(self, values: np.ndarray[Any, Any], code: int, kind: str) -> int:
        """Add values to the binary part, and return the number of their accessor."""
        self.binary += bytes(-len(self.binary) % 4)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": values.nbytes}
        self.binary += values.tobytes()
        entry = {"bufferView": self.add("bufferViews", view), "componentType": code}
        return self.add("accessors", {**entry, "count": len(values), "type": kind})

    def mesh(self, one: Solid) -> int:
        """Add a mesh of triangles, or of strips and fans, and return its number."""
        corners = self.chance.choice((True, False))
        primitives: list[dict[str, Any]] = []
        if corners:
            surface = one.surface.astype("<f4")
            position = self.numbers(surface.reshape(-1, 3), 5126, "VEC3")
            primitives.append({"attributes": {"POSITION": position}})
            if self.chance.random() < 0.5:
                code = self.chance.choice(
                    (5121, 5123, 5125) if surface.size < 760 else (5123, 5125)
                )
                every = np.arange(3 * len(surface), dtype=_INDEX[code])
                primitives[0]["indices"] = self.numbers(every, code, "SCALAR")
        else:
            position = self.numbers(one.vertices.astype("<f4"), 5126, "VEC3")
            surface = one.vertices.astype("<f4")[_rows(one)]
            for rows, mode in _runs(one, self.chance):
                ids = self.numbers(np.array(rows, "<u2"), 5123, "SCALAR")
                primitives.append(
                    {"attributes": {"POSITION": position}, "indices": ids, "mode": mode}
                )
        self._rarities(primitives, position)
        self.surfaces.append(np.asarray(surface, dtype=float))
        return self.add("meshes", {"primitives": primitives})

    def _rarities(self, primitives: list[dict[str, Any]], position: int) -> None:
        chance = self.chance.random()
        if chance < 0.1:
            primitives.append({"attributes": {"POSITION": position}, "mode": 1})
            self.left_out = True
        elif chance < 0.15:
            primitives[0]["targets"] = [{"POSITION": position}]
            self.left_out = True
        elif chance < 0.18:
            primitives[0]["extensions"] = {"KHR_draco_mesh_compression": {}}
            self.packed.add(len(self.surfaces))

    def node(self, depth: int) -> tuple[int, FloatArray]:
        """Add a node with what is below it; its number, and the surface in its parent."""
        entry, at = _transform(self.chance)
        surfaces = []
        if depth == 0 or self.chance.random() < 0.6:
            entry["mesh"] = self.chance.randrange(len(self.surfaces))
            surfaces.append(self.surfaces[entry["mesh"]])
            self.refused |= entry["mesh"] in self.packed
            if self.chance.random() < 0.02:
                entry["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": {}}}
                self.refused = True
            elif self.chance.random() < 0.02:
                entry["skin"] = 0
                self.refused = True
        if depth:
            children = [self.node(depth - 1) for _ in range(self.chance.randint(1, 2))]
            entry["children"] = [number for number, _ in children]
            surfaces += [surface for _, surface in children]
        return self.add("nodes", entry), placed(together(surfaces), at)


def glb(chance: Chance) -> Written:
    """Nodes in nodes, meshes used again, several scenes, and all kinds of primitives."""
    file = _Glb(chance)
    for _ in range(chance.randint(1, 3)):
        file.mesh(solid(chance))
    roots = [file.node(chance.randint(0, 2)) for _ in range(chance.randint(1, 2))]
    refused = file.refused
    scenes: list[dict[str, Any]] = [{"nodes": [number for number, _ in roots]}]
    default = 0
    if chance.random() < 0.3:
        other = {"nodes": [file.node(0)[0]]}
        default = chance.randint(0, 1)
        scenes.insert(1 - default, other)
        file.left_out = True
    used = {node.get("mesh") for node in file.document["nodes"]}
    file.left_out |= len(used - {None}) < len(file.surfaces)
    document = {"asset": {"version": "2.0"}, **file.document, "scenes": scenes}
    if default or chance.random() < 0.5:
        document["scene"] = default
    document["buffers"] = [{"byteLength": len(file.binary)}]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary = file.binary + bytes(-len(file.binary) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text
    body += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    content = struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body
    surface = together([surface for _, surface in roots])
    return Written(".glb", content, surface, 1.0, file.left_out, refused)


def _transform(chance: Chance) -> tuple[dict[str, Any], FloatArray]:
    """A node with a matrix, or with parts of one, and its pose (4, 4)."""
    if chance.random() < 0.5:
        at = pose(chance)
        return {"matrix": at.T.ravel().tolist()}, at
    turn = scipy.spatial.transform.Rotation.from_rotvec([chance.uniform(-3, 3) for _ in range(3)])
    entry = {
        "rotation": turn.as_quat().tolist(),
        "scale": [chance.uniform(0.5, 2) * chance.choice((1, 1, -1)) for _ in range(3)],
        "translation": [chance.uniform(-3, 3) for _ in range(3)],
    }
    at = np.eye(4)
    at[:3, :3] = turn.as_matrix() * entry["scale"]
    at[:3, 3] = entry["translation"]
    kept = {name: value for name, value in entry.items() if chance.random() < 0.9}
    if len(kept) < len(entry):
        at = np.eye(4)
        at[:3, :3] = turn.as_matrix() if "rotation" in kept else np.eye(3)
        at[:3, :3] = at[:3, :3] * kept.get("scale", [1, 1, 1])
        at[:3, 3] = kept.get("translation", [0, 0, 0])
    return dict(kept), at


def _rows(one: Solid) -> np.ndarray[Any, Any]:
    """Triangles (m, 3) of the sides of a solid, which is open then."""
    return np.array([ids for a, b, c, d in one.polygons[2:] for ids in ((a, b, c), (a, c, d))])


def _runs(one: Solid, chance: Chance) -> list[tuple[tuple[int, ...], int]]:
    """The sides as fans (6) and strips (5)."""
    runs: list[tuple[tuple[int, ...], int]] = []
    for a, b, c, d in one.polygons[2:]:
        runs.append(((a, b, c, d), 6) if chance.random() < 0.5 else ((b, c, a, d), 5))
    return runs
