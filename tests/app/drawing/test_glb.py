"""Lines and triangles as binary glTF are read as they were written; lines take few bytes."""

from __future__ import annotations

import io
import json
import struct

import numpy as np
import pytest
import trimesh
from trimesh.visual import ColorVisuals

from app.drawing.glb import line_set, triangle_set

_SIZES = {5123: "<u2", 5125: "<u4"}
_MOST = 1200
"""Bytes of header and padding."""


@pytest.mark.parametrize(
    ("points", "edges", "bytes_each"), [(2, 1, 2), (65_535, 9, 2), (65_536, 9, 4), (700, 4000, 2)]
)
def test_a_line_set_is_read_as_it_was_written(points: int, edges: int, bytes_each: int) -> None:
    random = np.random.default_rng(points)
    places = random.normal(size=(points, 3)).astype(np.float32).astype(float)
    ends = random.integers(points, size=(edges, 2), dtype=np.int32)
    ends[0] = (0, points - 1)
    data = line_set(places, ends, (10, 20, 30), 0.5)
    assert len(data) <= 12 * points + 2 * bytes_each * edges + _MOST

    magic, version, length, head, kind = struct.unpack_from("<4sIII4s", data)
    assert (magic, version, length, kind) == (b"glTF", 2, len(data), b"JSON")
    header = json.loads(data[20 : 20 + head])
    size, kind = struct.unpack_from("<I4s", data, 20 + head)
    body = data[28 + head :]
    assert (size, kind) == (len(body), b"BIN\0")
    assert size % 4 == 0

    position, index = header["accessors"]
    first, second = header["bufferViews"]
    assert second["byteOffset"] % bytes_each == 0
    read = np.frombuffer(body, "<f4", 3 * position["count"], first["byteOffset"])
    np.testing.assert_array_equal(read.reshape(-1, 3), places)
    indices = _SIZES[index["componentType"]]
    assert np.dtype(indices).itemsize == bytes_each
    read = np.frombuffer(body, indices, index["count"], second["byteOffset"])
    np.testing.assert_array_equal(read.reshape(-1, 2), ends)


@pytest.mark.parametrize("points", [3, 254, 65_536])
def test_triangles_are_read_by_others_as_they_were_written(points: int) -> None:
    random = np.random.default_rng(points)
    places = random.normal(size=(points, 3)).astype(np.float32).astype(float)
    faces = random.permutation(points)[: points // 3 * 3].reshape(-1, 3).astype(np.int32)
    colours = random.integers(256, size=(points, 3)).astype(np.uint8)
    data = triangle_set(places, faces, colours)
    read = trimesh.load_mesh(io.BytesIO(data), file_type="glb", process=False)
    assert isinstance(read, trimesh.Trimesh)
    np.testing.assert_array_equal(read.vertices, places)
    np.testing.assert_array_equal(read.faces, faces)
    assert isinstance(read.visual, ColorVisuals)
    np.testing.assert_array_equal(read.visual.vertex_colors[:, :3], colours)
