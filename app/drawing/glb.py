"""Lines and triangles as binary glTF; indexed lines are the lightest way to show a mesh's edges.

Written out by hand: trimesh writes lines as pairs of points without indices, in twice the bytes and
over a hundred times the time, and takes a second to import, which every first picture would wait
for. Format: glTF 2.0 specification, sections 3.7 (meshes, mode 1 = lines, 4 = triangles) and 4.4
(binary container).
"""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abi.arrays import ByteArray, FloatArray, IntArray
from app.ui.style import Colour

_LINES, _TRIANGLES, _BYTE, _FLOAT = 1, 4, 5121, 5126
_INTEGERS = {"<u2": 5123, "<u4": 5125}
"""Component types of indices, by numpy's names."""
_SHORT = 65_535
"""Number of points for which two-byte indices suffice; the last ends a strip (section 3.7.2.1)."""


def line_set(points: FloatArray, edges: IntArray, colour: Colour, opacity: float) -> bytes:
    """A GLB of straight lines.

    Args:
        points: (n, 3), [unit]; at least one point.
        edges: (e, 2) indices into ``points``; at least one edge.
        colour: sRGB.
        opacity: 0 to 1.
    """
    vertices = np.ascontiguousarray(points, dtype="<f4")
    primitive = {"attributes": {"POSITION": 0}, "mode": _LINES, "material": 0}
    material = {
        "materials": [_unlit(colour, opacity)],
        "extensionsUsed": ["KHR_materials_unlit"],
    }
    return _written(primitive, [vertices], edges, material)


def triangle_set(vertices: FloatArray, faces: IntArray, colours: ByteArray) -> bytes:
    """A GLB of coloured triangles, which are shaded flat.

    Args:
        vertices: (n, 3), [unit]; at least one.
        faces: (m, 3) indices into ``vertices``; at least one face.
        colours: of the vertices, red, green and blue, (n, 3).
    """
    opaque = np.full((len(vertices), 4), 255, np.uint8)
    opaque[:, :3] = colours
    primitive = {"attributes": {"POSITION": 0, "COLOR_0": 1}, "mode": _TRIANGLES}
    return _written(primitive, [np.ascontiguousarray(vertices, dtype="<f4"), opaque], faces, {})


def _written(
    primitive: dict[str, Any],
    attributes: list[NDArray[Any]],
    elements: IntArray,
    entries: dict[str, Any],
) -> bytes:
    """Encode a GLB of one primitive.

    Args:
        primitive: its entry in the header, without its indices.
        attributes: of its vertices; the first one has their positions.
        elements: indices of the vertices of its lines or triangles.
        entries: others of the header.
    """
    # most of the bytes, and those of a hand's every move
    kind = "<u2" if len(attributes[0]) <= _SHORT else "<u4"
    indices = np.ascontiguousarray(elements, dtype=kind)
    body = b"".join(array.tobytes() for array in (*attributes, indices))
    body += b"\0" * (-len(body) % 4)
    header = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive | {"indices": len(attributes)}]}],
        **entries,
        "buffers": [{"byteLength": len(body)}],
        **_buffer_views(attributes, indices),
    }
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = _chunk(b"JSON", text) + _chunk(b"BIN\0", body)
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def _unlit(colour: Colour, opacity: float) -> dict[str, Any]:
    """Material of a constant colour, independent of light."""
    linear = [(channel / 255) ** 2.2 for channel in colour]
    return {
        "pbrMetallicRoughness": {"baseColorFactor": [*linear, opacity], "metallicFactor": 0.0},
        "extensions": {"KHR_materials_unlit": {}},
        "alphaMode": "BLEND" if opacity < 1 else "OPAQUE",
    }


def _buffer_views(attributes: list[NDArray[Any]], indices: NDArray[Any]) -> dict[str, Any]:
    """Header entries for consecutive arrays of vertices, (n, 3) or (n, 4), and indices."""
    views, accessors, begin = [], [], 0
    for array in (*attributes, indices):
        views.append({"buffer": 0, "byteOffset": begin, "byteLength": array.nbytes})
        begin += array.nbytes
    for number, array in enumerate(attributes):
        accessor: dict[str, Any] = {
            "bufferView": number,
            "componentType": _BYTE if array.dtype == np.uint8 else _FLOAT,
            "count": len(array),
            "type": f"VEC{array.shape[1]}",
        }
        if array.dtype == np.uint8:
            accessor["normalized"] = True
        else:
            accessor |= {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()}
        accessors.append(accessor)
    kind = _INTEGERS[f"<u{indices.itemsize}"]
    accessors.append(
        {
            "bufferView": len(attributes),
            "componentType": kind,
            "count": indices.size,
            "type": "SCALAR",
        }
    )
    return {"bufferViews": views, "accessors": accessors}


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack("<I4s", len(content), kind) + content
