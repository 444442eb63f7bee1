"""Files that a format's specification allows and few programs write: all of them are read."""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Mapping

import numpy as np
import pytest

from abi.errors import SceneError
from abi.obstacles.mesh_files import xml_document
from abi.obstacles.triangle_mesh.mesh_reader import read_file
from tests.abi.obstacles.mesh_files.test_left_out import DAE, ITEM, dae, model
from tests.abi.obstacles.mesh_files.test_polygons import DOORWAY, files_of
from tests.abi.obstacles.triangle_mesh.test_mesh_reader import glb

NO_SCENE = "It has no scene: all its nodes are read."
GLOSSY = ["KHR_materials_pbrSpecularGlossiness"]
DEEP = [{"children": [k + 1]} for k in range(2000)] + [{"mesh": 0}]
PLY = files_of(DOORWAY)["a.ply"]
DECLARED = '<?xml version="1.0" encoding="utf-16"?>'.encode("utf-16")
ENTITY = '<!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]>'


def with_part(data: bytes, kind: bytes) -> bytes:
    """A GLB with a further part."""
    longer = data + struct.pack("<I4s", 4, kind) + bytes(4)
    return longer[:8] + len(longer).to_bytes(4, "little") + longer[12:]


def packed(
    model: bytes, others: Mapping[str, bytes] | None = None, name: str = "3D/3dmodel.model"
) -> bytes:
    """A 3MF of a model and further entries."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for entry, part in {name: model, **(others or {})}.items():
            archive.writestr(entry, part)
    return content.getvalue()


RELATED = (
    b'<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relation'
    b'ship Id="a" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel" '
    b'Target="/3D/my%20part.model"/></Relationships>'
)


with zipfile.ZipFile(io.BytesIO(model(ITEM))) as _archive:
    MODEL = _archive.read("3D/3dmodel.model")


def with_id(number: int) -> bytes:
    own = MODEL.replace(b'object id="1"', b'object id="%d"' % number)
    return packed(own.replace(b'objectid="1"', b'objectid="%d"' % number))


@pytest.mark.parametrize(
    ("name", "data", "plain", "notes"),
    [
        ("a.glb", glb({"nodes": DEEP}), glb(), ()),
        ("a.glb", with_part(glb(), b"OWN\0"), glb(), ()),
        ("a.glb", glb({"extensionsUsed": GLOSSY, "extensionsRequired": GLOSSY}), glb(), ()),
        ("a.3mf", packed(MODEL, {"__MACOSX/3D/._3dmodel.model": b"\0"}), model(ITEM), ()),
        (
            "a.3mf",
            packed(MODEL, {"3D/other.model": b"<model"}),
            model(ITEM),
            ("1 model part is left out: nothing refers there.",),
        ),
        (
            "a.3mf",
            packed(MODEL, {"_rels/.rels": RELATED}, "3D/my part.model"),
            model(ITEM),
            (),
        ),
        ("a.3mf", packed(DECLARED + MODEL.decode().encode("utf-16-le")), model(ITEM), ()),
        ("a.3mf", with_id(2**31 - 1), model(ITEM), ()),
        ("a.dae", DAE.encode("utf-16"), DAE.encode(), ()),
        (
            "a.dae",
            DAE.replace('id="g"', 'id="gü"').replace("#g", "#g%C3%BC").encode(),
            DAE.encode(),
            (),
        ),
        (
            "a.dae",
            b'<?xml version="1.0" encoding="ISO-8859-15"?>' + DAE[DAE.index("<COLLADA") :].encode(),
            DAE.encode(),
            (),
        ),
        ("a.ply", PLY.replace(b"\n", b"\r"), PLY, ()),
    ],
)
def test_a_file_is_read_as_its_plain_form(
    name: str, data: bytes, plain: bytes, notes: tuple[str, ...]
) -> None:
    found, expected = read_file(data, name), read_file(plain, name)
    np.testing.assert_array_equal(found.parts.vertices, expected.parts.vertices)
    np.testing.assert_array_equal(found.parts.faces, expected.parts.faces)
    assert found.notes == (*expected.notes, *notes)


def test_without_a_scene_all_nodes_are_read_and_told() -> None:
    nodes = [{"mesh": 0, "translation": [1, 0, 0]}, {"children": [0]}]
    placed = read_file(glb({"nodes": nodes, "scenes": [{"nodes": [1]}]}), "a.glb").parts
    document = glb({"nodes": nodes, "scenes": None}).replace(b'"scenes": null', b'"others": null')
    found = read_file(document, "a.glb")
    np.testing.assert_array_equal(found.parts.vertices, placed.vertices)
    assert found.notes == (NO_SCENE,)


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("a.glb", glb(matrix=[*np.eye(4).ravel()], translation=[5, 0, 0]), "nodes.0. has both"),
        ("a.glb", with_part(glb(), b"BIN\0"), "another length"),
        ("a.glb", glb({"asset": {"version": "2.9", "minVersion": "2.9"}}), "version '2.9'"),
        ("a.glb", glb({"asset": {"version": "3.0"}}), "version '3.0'"),
        ("a.glb", glb({"buffers": [{"byteLength": 40}]}), "past its end"),
        ("a.glb", glb({"buffers": [{"byteLength": 52}]}), "past its end"),
        ("a.glb", glb({"nodes": [{"mesh": 0}, {"children": [0]}]}), "nodes.0. is in another"),
        ("a.dae", dae("<COLLADA", f"{ENTITY}<COLLADA").decode().encode("utf-16"), "document type"),
        ("a.dae", DAE.encode("utf-16-le"), "byte 0"),
        ("a.3mf", with_id(2**31), "below 2"),
    ],
)
def test_what_no_specification_allows_is_refused(name: str, data: bytes, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        read_file(data, name)


def test_a_unit_that_is_not_known_is_told_and_others_count() -> None:
    text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    told = read_file(b"# units = furlong\n" + text, "a.obj")
    assert told.commented is None
    assert told.notes == ("The unit 'furlong' that a comment names is not known.",)
    assert read_file(b"# units = km\n" + text, "a.obj").commented == 1000


def test_strips_may_have_lists_of_other_numbers() -> None:
    header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz")
    header += "element tristrips 1\nproperty list uchar int vertex_indices\n"
    header += "property list uchar float texcoord\nend_header\n"
    places = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype="<f4").tobytes()
    strip = b"\3" + np.array([0, 1, 2], dtype="<i4").tobytes()
    strip += b"\2" + np.array([0.5, 1], dtype="<f4").tobytes()
    assert read_file(header.encode() + places + strip, "a.ply").parts.faces.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_comments_end_where_lines_of_a_file_do(end: str) -> None:
    """And at no other of Unicode's ends of lines, as the second byte of some letters is one."""
    said = "\u0441 \xc5\x0b v 9 9 9 \u2028 f 1 2 3"
    comments = (f"{said}", "units = km", "c")
    obj = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "f 1 2 3"]
    files = {
        "a.obj": [*(f"# {one}" for one in comments), *obj],
        "a.off": ["OFF", f"# {said}", "3 1 0", "0 0 0", "1 0 0", "0 1 0", "3 0 1 2"],
        "a.ply": [
            *("ply", "format ascii 1.0", *(f"comment {one}" for one in comments)),
            *("element vertex 3", *(f"property float {axis}" for axis in "xyz")),
            *("element face 1", "property list uchar int vertex_indices", "end_header"),
            *("0 0 0", "1 0 0", "0 1 0", "3 0 1 2", ""),
        ],
    }
    for name, lines in files.items():
        file = read_file(end.join(lines).encode(), name)
        assert file.parts.faces.tolist() == [[0, 1, 2]]
        assert file.commented == (None if name == "a.off" else 1000)


def test_no_room_is_made_for_rows_that_are_not_there() -> None:
    properties = "".join(f"property uchar p{k}\n" for k in range(3000))
    for kind in ("ascii", "binary_little_endian"):
        header = f"ply\nformat {kind} 1.0\nelement vertex 20000000\n{properties}"
        for lists in ("", "property list uchar int others\n"):
            data = f"{header}{lists}element face 0\nend_header\n".encode()
            with pytest.raises(SceneError, match="not all are there"):
                read_file(data + bytes(9), "a.ply") if kind != "ascii" else read_file(data, "a.ply")


def comb(teeth: int, faces: int) -> bytes:
    """An OBJ of a comb that several faces name."""
    outline = [(k // 2, 1 + k % 2 * teeth, 0) for k in range(2 * teeth)]
    corners = [(0, 0, 0), *outline, (teeth, 0, 0)]
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in corners)
    face = " ".join(str(k + 1) for k in range(len(corners)))
    return (text + f"f {face}\n" * faces).encode()


def test_polygons_whose_edges_would_be_compared_for_minutes_are_refused() -> None:
    assert len(read_file(comb(40, 3), "a.obj").parts.faces) == 3 * 80
    with pytest.raises(SceneError, match="that are convex, or of a few corners"):
        read_file(comb(2_000, 20), "a.obj")


def test_a_text_of_more_elements_than_a_mesh_has_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(xml_document, "MOST_ITEMS", 1000)
    read_file(packed(MODEL), "a.3mf")
    crowd = b"<metadata>" + b"<a/>" * 1000 + b"</metadata>"
    with pytest.raises(SceneError, match="at most 1,000 elements"):
        read_file(packed(MODEL, {"3D/other.model": crowd}), "a.3mf")
    with pytest.raises(SceneError, match="at most 1,000 elements"):
        read_file(DAE.replace("</COLLADA>", "<a/>" * 1000 + "</COLLADA>").encode(), "a.dae")
