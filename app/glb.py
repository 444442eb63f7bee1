"""Line sets as binary glTF: indexed GL lines, the lightest way to show a mesh's edges in viser.

Written out by hand: trimesh writes lines as pairs of points without indices, in twice the bytes and
over a hundred times the time. Format: glTF 2.0 specification, sections 3.7 (meshes, mode 1 = lines)
and 4.4 (binary container).
"""

from __future__ import annotations

import json
import struct

import numpy as np

from abi.arrays import FloatArray, IntArray
from app.style import Colour

_LINES, _FLOAT, _UINT = 1, 5126, 5125


def lines(points: FloatArray, edges: IntArray, colour: Colour, opacity: float) -> bytes:
    """A GLB of straight lines.

    Args:
        points: (n, 3), [unit]; at least one point.
        edges: (e, 2) indices into ``points``; at least one edge.
        colour: sRGB.
        opacity: 0 to 1.
    """
    vertices = np.ascontiguousarray(points, dtype="<f4")
    indices = np.ascontiguousarray(edges, dtype="<u4")
    linear = [(channel / 255) ** 2.2 for channel in colour]
    header = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [
            {
                "primitives": [
                    {"attributes": {"POSITION": 0}, "indices": 1, "mode": _LINES, "material": 0}
                ]
            }
        ],
        "materials": [
            {
                "pbrMetallicRoughness": {
                    "baseColorFactor": [*linear, opacity],
                    "metallicFactor": 0.0,
                },
                "extensions": {"KHR_materials_unlit": {}},
                "alphaMode": "BLEND" if opacity < 1 else "OPAQUE",
            }
        ],
        "extensionsUsed": ["KHR_materials_unlit"],
        "buffers": [{"byteLength": vertices.nbytes + indices.nbytes}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": vertices.nbytes},
            {"buffer": 0, "byteOffset": vertices.nbytes, "byteLength": indices.nbytes},
        ],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": _FLOAT,
                "count": len(vertices),
                "type": "VEC3",
                "min": vertices.min(axis=0).tolist(),
                "max": vertices.max(axis=0).tolist(),
            },
            {
                "bufferView": 1,
                "componentType": _UINT,
                "count": indices.size,
                "type": "SCALAR",
            },
        ],
    }
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    body = vertices.tobytes() + indices.tobytes()
    size = 12 + 8 + len(text) + 8 + len(body)
    return b"".join(
        (
            b"glTF",
            struct.pack("<II", 2, size),
            struct.pack("<I4s", len(text), b"JSON"),
            text,
            struct.pack("<I4s", len(body), b"BIN\0"),
            body,
        )
    )
