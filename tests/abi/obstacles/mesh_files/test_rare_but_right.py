"""Files that a format's specification allows and few programs write: all of them are read."""

from __future__ import annotations

import io
import struct
import zipfile

import numpy as np
import pytest

from abi.errors import SceneError
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


def packed(model: bytes, name: str = "3D/3dmodel.model", **others: bytes) -> bytes:
    """A 3MF of a model and further entries."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for entry, part in {name: model, **others}.items():
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
        ("a.3mf", packed(MODEL, **{"__MACOSX/3D/._3dmodel.model": b"\0"}), model(ITEM), ()),
        (
            "a.3mf",
            packed(MODEL, **{"3D/other.model": b"<model"}),
            model(ITEM),
            ("1 model part is left out: nothing refers there.",),
        ),
        (
            "a.3mf",
            packed(MODEL, "3D/my part.model", **{"_rels/.rels": RELATED}),
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
