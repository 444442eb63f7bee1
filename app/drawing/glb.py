"""Line sets as binary glTF: indexed GL lines, the lightest way to show a mesh's edges in viser.

Written out by hand: trimesh writes lines as pairs of points without indices, in twice the bytes and
over a hundred times the time. Format: glTF 2.0 specification, sections 3.7 (meshes, mode 1 = lines)
and 4.4 (binary container).
"""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abi.arrays import FloatArray, IntArray
from app.ui.style import Colour

_LINES, _FLOAT = 1, 5126
_INTEGERS = {"<u2": 5123, "<u4": 5125}
"""Component types of indices, by numpy's names."""
_SHORT = 65_535
"""Points up to which an index takes two bytes; the last number ends a strip (section 3.7.2.1)."""


def line_set(points: FloatArray, edges: IntArray, colour: Colour, opacity: float) -> bytes:
    """A GLB of straight lines.

    Args:
        points: (n, 3), [unit]; at least one point.
        edges: (e, 2) indices into ``points``; at least one edge.
        colour: sRGB.
        opacity: 0 to 1.
    """
    vertices = np.ascontiguousarray(points, dtype="<f4")
    # most of the bytes, and those of a hand's every move
    kind = "<u2" if len(vertices) <= _SHORT else "<u4"
    indices = np.ascontiguousarray(edges, dtype=kind)
    primitive = {"attributes": {"POSITION": 0}, "indices": 1, "mode": _LINES, "material": 0}
    header = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "materials": [_unlit(colour, opacity)],
        "extensionsUsed": ["KHR_materials_unlit"],
        **_buffers(vertices, indices, _INTEGERS[kind]),
    }
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    body = vertices.tobytes() + indices.tobytes()
    chunks = _chunk(b"JSON", text) + _chunk(b"BIN\0", body)
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def _unlit(colour: Colour, opacity: float) -> dict[str, Any]:
    """Material that shows its colour whatever the light."""
    linear = [(channel / 255) ** 2.2 for channel in colour]
    return {
        "pbrMetallicRoughness": {"baseColorFactor": [*linear, opacity], "metallicFactor": 0.0},
        "extensions": {"KHR_materials_unlit": {}},
        "alphaMode": "BLEND" if opacity < 1 else "OPAQUE",
    }


def _buffers(
    vertices: NDArray[np.float32], indices: NDArray[np.unsignedinteger[Any]], kind: int
) -> dict[str, Any]:
    """Header entries for a body of vertices (n, 3) and indices (e, 2) of a component type."""
    position = {
        "bufferView": 0,
        "componentType": _FLOAT,
        "count": len(vertices),
        "type": "VEC3",
        "min": vertices.min(axis=0).tolist(),
        "max": vertices.max(axis=0).tolist(),
    }
    index = {
        "bufferView": 1,
        "componentType": kind,
        "count": indices.size,
        "type": "SCALAR",
    }
    return {
        "buffers": [{"byteLength": vertices.nbytes + indices.nbytes}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": vertices.nbytes},
            {"buffer": 0, "byteOffset": vertices.nbytes, "byteLength": indices.nbytes},
        ],
        "accessors": [position, index],
    }


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack("<I4s", len(content), kind) + content
