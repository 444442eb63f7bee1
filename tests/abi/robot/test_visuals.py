"""Pictures of links: their visuals where they can be read, else their collision shapes."""

from __future__ import annotations

import io
import zipfile
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import trimesh

from abi.obstacles.mesh_files.parts import MeshFile
from abi.obstacles.triangle_mesh import mesh_reader
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.bodies.link_bodies import link_bodies
from abi.robot.urdf import mesh_lookup
from abi.robot.urdf.link import LinkShape
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.robot_files import (
    SHIPPED,
    load_plain_robot,
    load_robot,
    robot_from_archive,
    robots_in,
    unpacked,
)
from abi.robot.urdf.urdf_files import description_of
from tests.abi.robot.robots import arm, packed

ENTITY = b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]><a>&b;</a>'


def dae(radius: float, unit: float = 1.0) -> bytes:
    """A ball of 320 triangles, in a DAE of that unit whose z axis points up."""
    ball = trimesh.creation.icosphere(subdivisions=2, radius=radius / unit)
    content = ball.export(file_type="dae")
    assert isinstance(content, bytes)
    told = f'<asset><unit name="u" meter="{unit}"/>'.encode()
    return content.replace(b"<asset>", told, 1).replace(b"Y_UP", b"Z_UP")


def looking(*names: str, text: str | None = None) -> str:
    """The arm whose link ``a`` has visuals of these files beside its box."""
    looks = "".join(
        f'<visual><origin xyz="0 0.02 0"/><geometry><mesh filename="{name}"/></geometry></visual>'
        for name in names
    )
    return (text or arm()).replace("</link>", f"{looks}</link>", 1)


def read(files: dict[str, str | bytes]) -> tuple[Robot, Robot]:
    """The robot of a zip, and what becomes of it where no DAE may be left."""
    content = packed(files)
    plain = load_plain_robot("r.zip", MeshSource({"r.zip": content}))
    return robot_from_archive(content), robot_from_archive(plain.archive)


def corners(shapes: tuple[LinkShape, ...]) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    parts = [shape.vertices @ shape.pose[:3, :3].T + shape.pose[:3, 3] for shape in shapes]
    return np.concatenate(parts)


@pytest.mark.parametrize(("radius", "unit"), [(0.1, 1.0), (0.4, 0.01)])
def test_a_link_is_drawn_with_its_visual(radius: float, unit: float) -> None:
    for robot in read({"x/a.urdf": looking("meshes/a.dae"), "x/meshes/a.dae": dae(radius, unit)}):
        link = robot.links["a"]
        drawn = corners(link.drawn)

        told = () if unit == 1 else (f"a.dae: Its unit of {unit} m counts.",)
        assert robot.notes == told
        assert [shape.kind for shape in link.shapes] == ["box"]
        assert [len(shape.faces) for shape in link.drawn] == [320]
        middle = (drawn.min(axis=0) + drawn.max(axis=0)) / 2
        np.testing.assert_allclose(middle, (0, 0.02, 0), atol=1e-6)
        assert np.abs(drawn).max() == pytest.approx(radius + 0.02, rel=1e-5)
        assert robot.links["b"].drawn == robot.links["b"].shapes


def test_visuals_change_no_body() -> None:
    plain = robot_from_archive(packed({"a.urdf": arm()})).links["a"]
    files: dict[str, str | bytes] = {"a.urdf": looking("a.dae"), "a.dae": dae(0.2)}
    (before,), (after,) = map(link_bodies, (plain, read(files)[0].links["a"]))
    assert np.array_equal(before.points, after.points)
    assert before.radius == after.radius


def test_no_dae_is_left_for_the_server(monkeypatch: pytest.MonkeyPatch) -> None:
    bottom = arm(('<box size="0.1 0.1 0.3"/>', '<mesh filename="solid.dae"/>'))
    files: dict[str, str | bytes] = {
        "a.urdf": looking("a.dae", text=bottom),
        "a.dae": dae(0.1),
        "solid.dae": dae(0.2),
        "unused.dae": b"x",
    }
    robot, plain = read(files)

    assert description_of(plain) == description_of(robot)
    with zipfile.ZipFile(io.BytesIO(plain.archive)) as archive:
        assert not [name for name in archive.namelist() if name.endswith(".dae")]
    robot_from_archive.cache_clear()
    monkeypatch.setitem(mesh_reader._READERS, ".dae", None)
    again = load_plain_robot("r.zip", MeshSource({"r.zip": plain.archive}))
    assert again.archive == plain.archive
    for kind in ("shapes", "drawn"):
        first, second = (getattr(one.links["a"], kind)[0] for one in (robot, again))
        np.testing.assert_allclose(
            second.vertices[second.faces], first.vertices[first.faces], atol=1e-7
        )


@pytest.mark.parametrize("several", [False, True])
def test_each_file_of_an_upload_is_unpacked_once_and_each_mesh_read_once(
    several: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    files: dict[str, str | bytes] = {
        "one.urdf": looking("a.dae", "b.stl"),
        "a.dae": dae(0.1),
        "b.stl": trimesh.creation.box().export(file_type="stl"),
    }
    name = "r.zip/one.urdf" if several else "r.zip"
    content = packed(files | ({"two.urdf": arm()} if several else {}))
    unpacked_files, meshes = Counter[str](), Counter[str]()
    unpack, read_file = zipfile.ZipFile.read, mesh_reader.read_file

    def counted_unpack(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> bytes:
        unpacked_files[member.filename] += 1
        return unpack(archive, member)

    def counted_read(content: bytes, name: str) -> MeshFile:
        meshes[name] += 1
        return read_file(content, name)

    monkeypatch.setattr(zipfile.ZipFile, "read", counted_unpack)
    monkeypatch.setattr(mesh_reader, "read_file", counted_read)
    assert robots_in(content) == (("one.urdf", "two.urdf") if several else ("one.urdf",))
    assert not unpacked_files
    load_plain_robot(name, MeshSource({"r.zip": content}))
    assert {*unpacked_files.values()} == {1}
    assert meshes == {"a.dae": 1, "b.stl": 1}


@pytest.mark.parametrize(
    "content",
    [
        b"x",
        b"",
        ENTITY,
        ENTITY.decode().encode("utf-16"),
        dae(0.1)[:-200],
        dae(0.1) + packed({"b.dae": dae(0.1)}),
        dae(0.1).replace(b'meter="1.0"', b'meter="1e300"'),
        b'<?xml version="1.0" encoding="utf-7"?>+ADwAIQ-DOCTYPE a>',
        None,
    ],
    ids=["text", "empty", "entity", "utf-16", "cut off", "archive", "unit", "utf-7", "missing"],
)
def test_a_visual_that_cannot_be_read_leaves_the_shape_and_a_sentence(
    content: bytes | None,
) -> None:
    files: dict[str, str | bytes] = {"a.urdf": looking("b.dae", "a.dae"), "b.dae": dae(0.1)}
    if content is not None:
        files["a.dae"] = content
    for robot in read(files):
        assert robot.notes == ("Drawn by collision shapes, as visuals cannot be read: a.",)
        assert [shape.kind for shape in robot.links["a"].drawn] == ["box"]


def test_what_of_a_mesh_is_left_out_is_noted_once() -> None:
    scene = b'</visual_scene><visual_scene id="m"><node/></visual_scene>'
    several = dae(0.1).replace(b"</visual_scene>", scene)
    for robot in read({"a.urdf": looking("a.dae", "a.dae"), "a.dae": several}):
        assert robot.notes == ("a.dae: 1 scene is left out: the file opens with another.",)


def test_an_axis_that_points_up_is_noted_once_for_all_files() -> None:
    sideways = dae(0.1).replace(b"Z_UP", b"Y_UP")
    names = "abcdef"
    files: dict[str, str | bytes] = {f"{one}.dae": sideways for one in names}
    for robot in read({"a.urdf": looking(*files), **files}):
        first = ", ".join(f"{one}.dae" for one in names[:4])
        told = f"{first} and 2 more: Its y axis points up, and it is not turned."
        assert robot.notes == (told,)


@pytest.mark.parametrize("name", ["../a.dae", "/etc/passwd", "http://127.0.0.1/a.dae"])
def test_a_visual_elsewhere_is_not_looked_for(name: str, tmp_path: Path) -> None:
    (tmp_path / "a.dae").write_bytes(dae(0.1))
    folder = tmp_path / "scene"
    folder.mkdir()
    (folder / "a.urdf").write_text(looking(name))
    robot = load_robot("a.urdf", MeshSource(folder=folder))

    assert robot.links["a"].drawn == robot.links["a"].shapes
    assert robot.notes


def test_visuals_beside_a_urdf_come_along(tmp_path: Path) -> None:
    (tmp_path / "a.dae").write_bytes(dae(0.1))
    (tmp_path / "a.urdf").write_text(looking("package://r/a.dae"))
    robot = load_robot("a.urdf", MeshSource(folder=tmp_path))

    assert [len(shape.faces) for shape in robot.links["a"].drawn] == [320]


def test_visuals_take_no_triangles_from_the_shapes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mesh_lookup, "MAX_TRIANGLES", 600)
    box, first = '<box size="0.1 0.1 0.3"/>', '<box size="0.1 0.1 0.2"/>'
    solid = arm((box, first), (box, '<mesh filename="big.dae"/>'))
    for robot in read({"a.urdf": looking("big.dae", text=solid), "big.dae": dae(0.1)}):
        assert [shape.kind for shape in robot.links["b"].shapes] == ["mesh"]
        assert [shape.kind for shape in robot.links["a"].drawn] == ["box"]
        assert robot.notes


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_arms_are_drawn_as_they_look(name: str) -> None:
    robot = load_robot(name, MeshSource())

    assert not robot.notes
    drawn = [link for link in robot.links.values() if link.visuals]
    assert len(drawn) >= 7
    for link in drawn:
        assert all(shape.kind == "mesh" for shape in link.visuals)
    files = unpacked(robot.archive)
    size = sum(len(content) for path, content in files.items() if "/visual/" in path)
    assert 100_000 < size <= 1_000_000
