"""What is not read of a file is noted, or the file is refused; and what its numbers count in."""

from __future__ import annotations

import io
import zipfile
from typing import Any

import numpy as np
import pytest

from abi import Scene, load_scene
from abi.errors import SceneError
from abi.obstacles.mesh_files import census
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.triangle_mesh import mesh_reader
from abi.obstacles.triangle_mesh.mesh_reader import read_file, read_surface
from tests.abi.obstacles.mesh_files.test_polygons import DOORWAY, files_of
from tests.abi.obstacles.triangle_mesh.test_mesh_reader import OBJ, glb, primitive

DAE = files_of(DOORWAY)["a.dae"].decode()
NODE = '<node><instance_geometry url="#g"/></node>'
CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"


def model(build: str, unit: str = "", mesh: str = "", objects: str = "") -> bytes:
    """A 3MF of one triangle, object 1, between 2 and 3 along x."""
    corners = "".join(f'<vertex x="{x}" y="{y}" z="0"/>' for x, y in ((2, 0), (3, 0), (2, 1)))
    body = f'<vertices>{corners}</vertices><triangles><triangle v1="0" v2="1" v3="2"/></triangles>'
    text = f'<model {unit} xmlns="{CORE}"><resources><object id="1"><mesh>{body}{mesh}</mesh>'
    text += f"</object>{objects}</resources><build>{build}</build></model>"
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("3D/3dmodel.model", text)
    return packed.getvalue()


STL = b"""solid a
facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet
endsolid a
"""
INCLUDE = "http://www.w3.org/2001/XInclude"
ITEM = '<item objectid="1"/>'


def dae(change: str, to: str) -> bytes:
    assert change in DAE
    return DAE.replace(change, to, 1).encode()


def polygons(count: int) -> bytes:
    """The doorway's wall with its first polygon alone, and the number of polygons announced."""
    start, end = DAE.index("<polylist"), DAE.index("</polylist>")
    own = DAE[DAE.index("<input", start) : DAE.index("<vcount")]
    text = f'<polygons count="{count}">{own}<p>0 1 2 3</p></polygons>'
    return (DAE[:start] + text + DAE[end + len("</polylist>") :]).encode()


def controller(kind: str) -> bytes:
    text = DAE.replace("instance_geometry", "instance_controller").replace('url="#g"', 'url="#c"')
    library = f'<library_controllers><controller id="c"><{kind} source="#g"/></controller>'
    return text.replace(
        "<library_visual", f"{library}</library_controllers><library_visual"
    ).encode()


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("a.dae", controller("skin"), "skin and morph controllers, <instance_controller> in line"),
        ("a.dae", controller("morph"), "skin and morph controllers"),
        ("a.dae", dae("#g", "other.dae#g"), "refers to 'other.dae#g'"),
        ("a.dae", dae("#g", "#h"), "one geometry '#h'"),
        ("a.dae", dae("<mesh>", "<convex_mesh>"), "breaks in line"),
        ("a.dae", DAE.replace("mesh>", "convex_mesh>").encode(), "<geometry> in line 1 has none"),
        ("a.dae", dae(NODE, f'<node id="n">{NODE}<instance_node url="#n"/></node>'), "themselves"),
        ("a.dae", dae("<vcount>8", "<vcount>7"), "as vcount says"),
        ("a.dae", dae('<polylist count="1"', '<polylist count="2"'), "can be counted"),
        ("a.dae", dae("<p>0 1", "<p>0 11"), "<p> in line"),
        ("a.dae", polygons(2), "2 lists in <polygons> in line 9, it has 1"),
        ("a.dae", dae("</geometry>", "<mesh/></geometry>"), "one mesh in <geometry>"),
        ("a.dae", dae("<asset/>", '<asset><unit meter="-1"/></asset>'), "unit is a length"),
        ("a.dae", dae("<asset/>", '<asset><unit meter="0.0_1"/></asset>'), "unit is a length"),
        ("a.dae", dae("<asset/>", "<asset><up_axis>UP</up_axis></asset>"), "'UP'"),
        ("a.dae", dae("<node>", "<node><matrix>1 2 3</matrix>"), "16 numbers in <matrix>"),
        ("a.dae", dae("<scene>", "<scena>").replace(b"</scene>", b"</scena>"), "with a scene"),
        ("a.dae", dae("<asset/>", f'<x:include xmlns:x="{INCLUDE}"/>'), "includes no other"),
        ("a.stl", STL.replace(b"\n", b" ", 1), "facets begin in lines of their own, see line 1"),
        ("a.3mf", model(""), "no triangles"),
        ("a.3mf", model('<item objectid="2"/>'), "object 2 is not in"),
        ("a.3mf", model(ITEM, 'unit="cubit"'), "'cubit'"),
        ("a.3mf", model(ITEM, mesh='<b:beamlattice xmlns:b="u"/>'), "<beamlattice> in line 1"),
        ("a.3mf", model(ITEM).replace(b"triangle v1", b"quadrang v1"), "whole 3MF file"),
        ("a.3mf", model(ITEM, 'requiredextensions="b" xmlns:b="urn:b"'), "'urn:b'"),
        ("a.glb", glb(skin=0), "skeleton, nodes[0]"),
        ("a.glb", glb(extensions={"EXT_mesh_gpu_instancing": {}}), "EXT_mesh_gpu_instancing"),
        ("a.glb", glb(primitive(targets=[{"POSITION": 0}]), weights=[0.5]), "morph targets"),
        ("a.glb", glb(primitive(targets=[{"POSITION": 0}]), weights=5), "morph targets"),
        (
            "a.dae",
            dae("<mesh>", "<asset><up_axis>X_UP</up_axis></asset><mesh>").replace(
                b"<asset/>", b"<asset><up_axis>Y_UP</up_axis></asset>"
            ),
            "one up_axis",
        ),
        ("a.obj", OBJ + b"v 0 0 0 f 1 2 3\n", "three numbers, line 123 has '0 0 0 f"),
        ("a.obj", b"# unit: mm\n# unit = cm\n" + OBJ, "comments name several"),
        ("a.obj", OBJ + b"surf 0 1 0 1 1 2 3 4\n", "curved surface (surf)"),
        ("a.off", b"OFF BINARY\n", "as text, or as PLY"),
        ("a.ply", b"ply\nformat ascii 2.0 x\nend_header\n", "line 2"),
    ],
)
def test_what_would_change_the_surface_is_refused(name: str, data: bytes, words: str) -> None:
    with pytest.raises(SceneError) as caught:
        read_file(data, name)
    assert words in caught.value.message
    assert caught.value.message.count("\n") == 0


MORPH = primitive(targets=[{"POSITION": 0}])
SCENES: dict[str, Any] = {"scenes": [{"nodes": [0]}, {"nodes": [1]}], "nodes": [{"mesh": 0}] * 2}
LINES = '<lines count="2"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2 3</p></lines>'
UNUSED = f"<library_nodes>{NODE}</library_nodes>"
OTHER = f'</visual_scene><visual_scene id="m">{NODE}</visual_scene>'


@pytest.mark.parametrize(
    ("name", "data", "note"),
    [
        ("a.dae", dae("</polylist>", f"</polylist>{LINES}"), "2 lines are left out"),
        ("a.dae", dae("</polylist>", "</polylist><patch/>"), "What its <patch> says is left out"),
        (
            "a.dae",
            dae("<asset/>", '<asset><unit name="inch"/></asset>'),
            "named 'inch', but is 1 m",
        ),
        ("a.dae", dae("</visual_scene>", OTHER), "1 scene is left out"),
        ("a.dae", dae("<scene>", "<scene><instance_physics_scene/>"), "<instance_physics_scene>"),
        ("a.dae", dae("</geometry>", '</geometry><geometry id="h"><mesh/></geometry>'), "geometry"),
        (
            "a.dae",
            dae("<library_v", f"<library_nodes>{NODE}</library_nodes><library_v"),
            "instance",
        ),
        ("a.3mf", model(f"{ITEM}<x><item objectid='1'/></x>"), "What its <x> says is left out"),
        ("a.3mf", model(f"{ITEM}</build><x/><build>"), "What its <x> says is left out"),
        ("a.3mf", model(ITEM, objects='<object id="2"><mesh/></object>'), "1 object is left out"),
        ("a.glb", glb(SCENES), "1 node is left out"),
        ("a.glb", glb(SCENES), "1 scene is left out"),
        ("a.glb", glb(MORPH), "morph targets are left out"),
        ("a.glb", glb({"animations": [{}]}), "animations are left out"),
        ("a.glb", glb(extensions={"ACME_lod": {}}), "'ACME_lod'"),
        ("a.glb", glb({"extensions": {"ACME_more": {}}}), "'ACME_more'"),
        ("a.obj", OBJ + b"f 1 2\nl 1 2 3\n", "2 lines are left out"),
        ("a.obj", OBJ + b"f 1 2 # no face\n", "1 line is left out"),
        ("a.obj", OBJ + b"p 1\n", "1 point is left out"),
        ("a.obj", OBJ.replace(b"\nf", b" 2\nf", 1), "The weight of 1 vertex is left out"),
        ("a.obj", OBJ + b"v 0 0 0\n", "1 point is left out"),
    ],
)
def test_what_has_no_place_or_no_surface_is_noted(name: str, data: bytes, note: str) -> None:
    file = read_file(data, name)
    assert any(note in one for one in file.notes), file.notes
    assert len(file.parts.faces) > 0


@pytest.mark.parametrize(
    ("name", "data", "axis"),
    [
        ("a.glb", glb(), "y"),
        ("a.dae", DAE.encode(), "y"),
        ("a.dae", dae("<asset/>", "<asset><up_axis>X_UP</up_axis></asset>"), "x"),
        ("a.dae", dae("<asset/>", "<asset><up_axis> Z_UP </up_axis></asset>"), "z"),
        ("a.obj", OBJ, "z"),
    ],
)
def test_no_mesh_is_turned_and_another_axis_than_z_is_noted(
    name: str, data: bytes, axis: str
) -> None:
    surface, file = read_surface(data, name), read_file(data, name)
    noted = f"Its {axis} axis points up, and it is not turned." in surface.notes
    assert noted == (axis != "z")
    wanted = {tuple(corner) for corner in file.parts.vertices.tolist()}
    assert {tuple(corner) for corner in surface.vertices.tolist()} <= wanted


def test_text_that_is_not_used_does_not_matter() -> None:
    names = "mtllib C:\\Teile\\größe.mtl\ng Türgriff\nusemtl a:b\no ?\n".encode("latin-1")
    wanted = read_file(OBJ, "a.obj").parts
    path = b"# in C:\\Teile\\\n"
    for text in (
        names + OBJ,
        path + OBJ,
        OBJ.replace(b"\n", b"\r\n"),
        OBJ.replace(b" ", b" \\\n ", 40),
    ):
        found = read_file(text, "a.obj")
        np.testing.assert_array_equal(found.parts.vertices, wanted.vertices)
        np.testing.assert_array_equal(found.parts.faces, wanted.faces)
        assert found.notes == ()


def test_a_text_stl_may_have_any_line_ends() -> None:
    for text in (STL, STL.replace(b"\n", b"\r\n"), STL.replace(b"\n", b"\r"), STL.upper()):
        assert len(read_file(text, "a.stl").parts.faces) == 1


def test_a_reader_that_misses_triangles_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(census._COUNTS, ".obj", lambda data: 81)
    with pytest.raises(SceneError, match="announces 81 triangles and 80 are there"):
        mesh_reader.read(OBJ, "a.obj")


def shape(name: str, data: bytes, unit: str | None, scene_unit: str = "mm") -> MeshShape:
    mesh = {"shape": "mesh", "file": name, "unit": unit}
    corner = {"version": 1, "unit": scene_unit, "goal": [1, 1, 1], "obstacles": [mesh]}
    found = Scene.from_dict(corner, {name: data}).obstacles[0]
    assert isinstance(found, MeshShape)
    return found


TRIANGLE = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
PLY = b"""ply
format ascii 1.0
comment unit: meter
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0 1 0 0 0 1 0 3 0 1 2
"""
INCH = model(ITEM, 'unit="inch"')
CM = dae("<asset/>", '<asset><unit name="u" meter="0.01"/></asset>')


@pytest.mark.parametrize(
    ("name", "data", "unit", "wide", "note"),
    [
        ("a.3mf", INCH, None, 25.4, "count in inches"),
        ("a.3mf", INCH, "mm", 1, "The file counts in inches; the scene says mm"),
        ("a.3mf", model(ITEM), None, 1, "count in millimetres"),
        ("a.3mf", model(ITEM), "mm", 1, "count in millimetres"),
        ("a.dae", CM, None, 30, "count in centimetres"),
        ("a.dae", CM, "m", 3000, "The file counts in centimetres; the scene says m,"),
        ("a.dae", DAE.encode(), None, 3000, "count in metres"),
        ("a.glb", glb(), None, 1000, "count in metres"),
        ("a.glb", glb(), "cm", 10, "The file counts in metres; the scene says cm"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", None, 1, ""),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "cm", 10, ""),
        ("a.obj", b"# File units = inches\n" + TRIANGLE, None, 25.4, "count in inches"),
        ("a.obj", b"# File units = inches\n" + TRIANGLE, "cm", 10, "counts in inches; the scene"),
        ("a.obj", b"# units of inches\n# Unit: furlong\n" + TRIANGLE, None, 1, ""),
        ("a.stl", STL.replace(b"solid a", b"solid a units=cm", 1), None, 10, "in centimetres"),
        ("a.ply", PLY, None, 1000, "count in metres"),
    ],
)
def test_numbers_count_in_the_unit_of_the_scene_or_of_the_file(
    name: str, data: bytes, unit: str | None, wide: float, note: str
) -> None:
    found = shape(name, data, unit)
    low, high = found.bounds()
    assert high[0] - low[0] == pytest.approx(wide)
    assert note in found.notes[0]
    assert len([one for one in found.notes if "count" in one]) == bool(note)


def test_a_scene_that_is_packed_keeps_the_unit_of_its_files(tmp_path: Any) -> None:
    mesh = {"shape": "mesh", "file": "a.3mf"}
    scene = Scene.from_dict({"version": 1, "obstacles": [mesh]}, {"a.3mf": INCH})
    (tmp_path / "a.zip").write_bytes(scene.pack())
    assert load_scene(tmp_path / "a.zip") == scene


@pytest.mark.parametrize("statement", ["F 1 2 3", "face 1 2 3", "\ufefff 1 2 3", "v1 0 0 0"])
def test_what_is_no_statement_of_obj_is_noted(statement: str) -> None:
    usual = b"mtllib a.mtl\ng a\nvn 0 0 1\ns off\nusemtl b\n# F 1 2 3\n" + OBJ
    assert read_file(usual, "a.obj").notes == ()
    (note,) = read_file(usual + f"\n{statement}\n".encode(), "a.obj").notes
    assert note.startswith("What is no statement of OBJ is left out: ")


def test_coordinates_of_a_dae_may_stand_in_any_order() -> None:
    x, y, z = (f'<param name="{axis}" type="float"/>' for axis in "XYZ")
    usual = read_file(DAE.encode(), "a.dae").parts
    turned = read_file(dae(x + y + z, z + x + y), "a.dae").parts
    np.testing.assert_array_equal(turned.vertices, usual.vertices[:, [1, 2, 0]])
