from __future__ import annotations

import json
import re
import struct
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.arrays import FloatArray
from abi.errors import SceneError
from abi.obstacles.pose import rotation
from abi.obstacles.triangle_mesh import mesh_reader
from abi.obstacles.triangle_mesh.mesh_reader import read
from tests.abi import meshes
from tests.thorough import examples

VERTICES, FACES = meshes.bumpy(1)
STL = meshes.stl((VERTICES, FACES))
OBJ = "".join(
    [f"v {x:.17g} {y:.17g} {z:.17g}\n" for x, y, z in VERTICES]
    + [f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in FACES]
).encode()
MESH = trimesh.Trimesh(VERTICES, FACES, process=False)
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


def exported(thing: Any, kind: str) -> bytes:
    data = thing.export(file_type=kind)
    return data.encode() if isinstance(data, str) else bytes(data)


TEXT_STL = exported(MESH, "stl_ascii")


def glb(change: dict[str, Any] | None = None, binary: bytes | None = None, **nodes: Any) -> bytes:
    """A GLB of one triangle, with parts of its description exchanged."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype="<f4")
    body = corners.tobytes() + np.arange(3, dtype="<u4").tobytes() if binary is None else binary
    accessor = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}
    ids = {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"}
    document: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, **nodes}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [accessor, ids],
        "bufferViews": [
            {"buffer": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 12},
        ],
        "buffers": [{"byteLength": len(body)}],
        **(change or {}),
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    parts = struct.pack("<I4s", len(text), b"JSON") + text
    parts += struct.pack("<I4s", len(body), b"BIN\0") + body
    return struct.pack("<4sII", b"glTF", 2, 12 + len(parts)) + parts


def primitive(**change: Any) -> dict[str, Any]:
    return {"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, **change}]}]}


def accessor(**change: Any) -> dict[str, Any]:
    ids = {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"}
    first = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", **change}
    return {"accessors": [first, ids]}


def corners(data: bytes, name: str) -> FloatArray:
    vertices, faces = read(data, name)
    return vertices[faces]


@pytest.mark.parametrize("name", ["binary.stl", "text.stl", "m.obj", "m.glb", "UPPER.STL"])
def test_what_trimesh_writes_is_read_back(name: str) -> None:
    kind = "stl_ascii" if name == "text.stl" else name[-3:].lower()
    found = corners(exported(MESH, kind), name)
    np.testing.assert_allclose(found, VERTICES[FACES], atol=1e-6)


def test_a_scene_of_placed_parts_is_read_as_trimesh_places_them() -> None:
    scene = trimesh.Scene()
    for k in range(4):
        pose = np.eye(4)
        pose[:3, :3] = rotation((1.0, k, -2.0, 0.5))
        pose[:3, 3] = k, -k, 2 * k
        if k == 3:
            pose[:3, :3] *= -0.5  # mirrored
        scene.add_geometry(MESH, transform=pose)
    found = corners(exported(scene, "glb"), "scene.glb")

    volume = np.einsum("ij,ij->i", np.cross(found[:, 0], found[:, 1]), found[:, 2]).sum() / 6
    whole = scene.to_mesh()
    assert sorted(map(tuple, found.mean(axis=1).round(4).tolist())) == sorted(
        map(tuple, whole.triangles_center.round(4).tolist())
    )
    assert volume == pytest.approx(MESH.volume * (3 + 0.5**3))


def test_the_nodes_of_a_glb_place_its_mesh() -> None:
    turned = glb(rotation=[0, 0, 2**-0.5, 2**-0.5], scale=[2, 1, 1], translation=[5, 0, 0])
    expected = [[5, 0, 0], [5, 2, 0], [4, 0, 0]]
    np.testing.assert_allclose(corners(turned, "m.glb")[0], expected, atol=1e-6)
    matrix = [0, 2, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1]
    np.testing.assert_allclose(corners(glb(matrix=matrix), "m.glb")[0], expected, atol=1e-6)


def test_a_mesh_that_hangs_on_a_camera_is_read() -> None:
    eye = {"cameras": [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}]}
    np.testing.assert_array_equal(corners(glb(eye, camera=0), "m.glb"), corners(glb(), "m.glb"))


def test_polygons_and_indices_from_the_end_of_an_obj() -> None:
    text = "# a square\nv 0 0 0\nv 1 0 0\nv 1 1 0 1.0\nv 0 1 \\\n0\nvn 0 0 1\nmtllib m.mtl\n"
    found = corners((text + "usemtl red\nf -4//1 2/1/1 3 4\n").encode(), "m.obj")
    np.testing.assert_array_equal(
        found[:, :, :2], [[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]]
    )


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("m.stl", b"", "empty"),
        ("m.stl", b"  \n", "empty"),
        ("m.stl", bytes(84), "empty"),
        ("m.stl", STL[:84][:80] + bytes(4), "no triangles"),
        ("m.stl", STL[:40], "cut off"),
        ("m.stl", STL[:-1], "cut off"),
        ("m.stl", STL[: len(STL) // 2], "cut off"),
        ("m.stl", STL + b"\0", "goes on"),
        ("m.stl", STL[:80] + struct.pack("<I", len(FACES) - 1) + STL[84:], "goes on"),
        ("m.stl", STL[:80] + struct.pack("<I", 2**32 - 1) + STL[84:], "cut off"),
        ("m.stl", STL[:84] + struct.pack("<12f", *[np.nan] * 12) + STL[132:], "NaN"),
        ("m.stl", STL[:84] + struct.pack("<12f", *[1e30] * 12) + STL[132:], "at most 1e+06"),
        ("m.stl", TEXT_STL[: len(TEXT_STL) // 2], "cut off"),
        ("m.stl", TEXT_STL.replace(b"vertex", b"vertax", 1), "three vertices"),
        ("m.stl", TEXT_STL.replace(b"endloop", b"", 1), "facet 1 is not"),
        ("m.stl", TEXT_STL.replace(b"vertex ", b"vertex x", 1), "not a number"),
        ("m.stl", re.sub(rb"vertex \S+", b"vertex nan", TEXT_STL, count=1), "NaN"),
        ("m.stl", b"solid nothing\nendsolid nothing\n", "no triangles"),
        ("m.stl", b"solid x" + bytes(200), "STL"),
        ("m.stl", OBJ, "STL"),
        ("m.stl", b"\x89PNG\r\n\x1a\n" + bytes(500), "PNG"),
        ("m.stl", b"\xff\xd8\xff\xe0" + bytes(500), "JPEG"),
        ("m.stl", b"<!doctype html><html>404</html>", "web page"),
        ("m.obj", b"\n\n <html>404</html>", "web page"),
        ("m.stl", b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "git lfs pull"),
        ("m.stl", b"PK\x03\x04" + bytes(500), "zip"),
        ("m.glb", b"\x1f\x8b\x08" + bytes(500), "gzip"),
        ("m.obj", b'{"asset": {"version": "2.0"}}', "JSON"),
        ("m.obj", b"# nothing\n", "no triangles"),
        ("m.obj", b"v 0 0 0\nl 1 1\n", "no triangles"),
        ("m.obj", STL, "text"),
        ("m.obj", b"v 0 0\0", "binary"),
        ("m.obj", (TRIANGLE + "call other.obj\nf 1 2 3\n").encode(), "calls another file"),
        ("m.obj", (TRIANGLE + "f 0 1 2\n").encode(), "'0'"),
        ("m.obj", (TRIANGLE + "f 1 2 4\n").encode(), "line 4 has 4"),
        ("m.obj", (TRIANGLE + "f 1 2 -4\n").encode(), "'-4'"),
        ("m.obj", (TRIANGLE + "f 1 2\n").encode(), "no triangles"),
        ("m.obj", (TRIANGLE + "f 1 2 x\n").encode(), "'x'"),
        ("m.obj", (TRIANGLE + f"f 1 2 {'9' * 5001}\n").encode(), "'999"),
        ("m.obj", f"v nan 0 0\n{TRIANGLE}f 1 2 3\n".encode(), "NaN"),
        ("m.obj", f"v 1e999 0 0\n{TRIANGLE}f 1 2 3\n".encode(), "infinite"),
        ("m.obj", f"v 1 0\n{TRIANGLE}f 1 2 3\n".encode(), "three numbers"),
        ("m.obj", f"v 1 0 {'1' * 60_000}\n{TRIANGLE}f 1 2 3\n".encode(), "three numbers"),
        ("m.glb", STL, "does not begin"),
        ("m.glb", glb()[:-1], "whole"),
        ("m.glb", glb() + b"\0", "whole"),
        ("m.glb", glb()[:60], "whole"),
        ("m.glb", b"glTF" + struct.pack("<I", 1) + glb()[8:], "version 1"),
        ("m.glb", glb({"buffers": [{"uri": "/etc/passwd", "byteLength": 48}]}), "another"),
        ("m.glb", glb({"buffers": [{"uri": "data:,", "byteLength": 48}]}), "another"),
        ("m.glb", glb(accessor(count=10**8)), "at most"),
        ("m.glb", glb(accessor(count=10**4)), "past its end"),
        ("m.glb", glb(accessor(count=-1)), "at most"),
        ("m.glb", glb(accessor(count=True)), "at most"),
        ("m.glb", glb({"accessors": [{"count": 10**8, "type": "VEC3"}]}), "stand in it"),
        ("m.glb", glb(accessor(byteOffset=30)), "past its end"),
        ("m.glb", glb(accessor(byteOffset=-12)), "whole numbers"),
        ("m.glb", glb(accessor(bufferView=7)), "bufferViews[7]"),
        ("m.glb", glb(accessor(componentType=5124)), "float positions"),
        ("m.glb", glb(primitive(mode=7)), "kinds 0 to 6"),
        ("m.glb", glb(primitive(mode=1)), "no triangles"),
        ("m.glb", glb(primitive(extensions={"KHR_draco_mesh_compression": {}})), "compression"),
        ("m.glb", glb(primitive(attributes={})), "accessors[None]"),
        ("m.glb", glb({"extensionsRequired": ["KHR_draco_mesh_compression"]}), "KHR_draco"),
        ("m.glb", glb({"scenes": [{"nodes": []}]}), "no triangles"),
        ("m.glb", glb({"scenes": [{"nodes": [0, 0]}]}), "tree"),
        ("m.glb", glb(children=[0]), "tree"),
        ("m.glb", glb(children=[99]), "nodes[99]"),
        ("m.glb", glb(translation=[1e300, 0, 0]), "within"),
        ("m.glb", glb(matrix=[float("nan")] * 16), "JSON"),
        ("m.glb", glb().replace(b'"asset"', b'"nodes"'), "each name once"),
        ("m.glb", glb(rotation=[0, 0, 0, 0]), "rotations"),
        ("m.glb", glb(scale=[1, 1]), "3 numbers"),
        ("m.glb", glb({"nodes": "x"}), "nodes[0]"),
        ("m.glb", glb(binary=np.full(12, np.nan, "<f4").tobytes()), "use the vertices"),
        ("m.glb", glb(binary=np.full(9, np.inf, "<f4").tobytes() + bytes(12)), "infinite"),
    ],
)
def test_what_is_not_a_mesh_is_refused_in_one_line(name: str, data: bytes, words: str) -> None:
    with pytest.raises(SceneError) as caught:
        read(data, name)
    assert words in caught.value.message
    assert "\n" not in caught.value.message
    assert len(caught.value.message) < 250


def test_deep_json_is_refused() -> None:
    with pytest.raises(SceneError, match="JSON"):
        read(glb().replace(b'"nodes": [0]', b"[" * 12, 1), "m.glb")
    deep = b'{"a":' * 100_000
    data = struct.pack("<4sIII4s", b"glTF", 2, 20 + len(deep), len(deep), b"JSON") + deep
    with pytest.raises(SceneError, match="JSON"):
        read(data, "m.glb")


def test_the_limits_are_those_of_the_file_not_of_its_promises(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(mesh_reader, "MAX_FACES", len(FACES) - 1)
    for name, data in (("m.stl", STL), ("t.stl", TEXT_STL), ("m.obj", OBJ)):
        with pytest.raises(SceneError, match="at most"):
            read(data, name)
    many = {"nodes": [{"mesh": 0}] * 100, "scenes": [{"nodes": list(range(100))}]}
    with pytest.raises(SceneError, match="at most"):
        read(glb(many), "m.glb")
    monkeypatch.setattr(mesh_reader, "MAX_BYTES", len(STL) - 1)
    with pytest.raises(SceneError, match="MB"):
        read(STL, "m.stl")


@pytest.mark.slow
@settings(max_examples=examples(40))
@given(
    st.sampled_from(["m.stl", "t.stl", "m.obj", "m.glb"]),
    st.data(),
)
def test_damage_is_refused_or_leaves_a_mesh(name: str, data: st.DataObject) -> None:
    whole = {"m.stl": STL, "t.stl": TEXT_STL, "m.obj": OBJ, "m.glb": glb()}
    damaged = bytearray(whole[name])
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(damaged) - 1))
        damaged[place : place + data.draw(st.integers(0, 2))] = data.draw(st.binary(max_size=3))
    try:
        vertices, faces = read(bytes(damaged), name)
    except SceneError as error:
        assert "\n" not in error.message  # noqa: PT017
        return
    assert len(faces) > 0
    assert np.isfinite(vertices).all()
    assert faces.min() >= 0
    assert faces.max() < len(vertices)
