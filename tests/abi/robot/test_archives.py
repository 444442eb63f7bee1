"""Archives of robots and scenes as ROS packages and file managers lay them out."""

from __future__ import annotations

import io
import json
import re
import unicodedata
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.robot_files import load_plain_robot, load_robot, robot_from_archive
from abi.robot.urdf.urdf_files import description_of, files_of
from abi.scene.scene import Scene, load_scene
from tests.abi.robot.robots import arm, packed
from tests.abi.robot.test_robot_files import SRDF, ball
from tests.abi.robot.test_visuals import dae

BOX = '<box size="0.1 0.1 0.3"/>'
Files = dict[str, str | bytes]


def using(*names: str) -> str:
    """An arm whose first links have these meshes."""
    return arm(*((BOX, f'<mesh filename="{name}"/>') for name in names))


def triangles(robot: Robot) -> list[int]:
    """Number of triangles of each link that has a mesh."""
    links = (robot.links[name] for name in "abcd")
    return [len(link.shapes[0].faces) for link in links if link.shapes[0].kind == "mesh"]


def from_zip(files: Files) -> Robot:
    return robot_from_archive(packed(files))


def from_folder(files: Files, folder: Path) -> Robot:
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content.encode() if isinstance(content, str) else content)
    (urdf,) = (name for name in files if name.endswith(".urdf"))
    return load_robot(urdf, MeshSource(folder=folder))


LAYOUTS: Mapping[str, tuple[str, str, str]] = {
    # path of the URDF, path of the mesh, and what the URDF calls it
    "package": ("pkg/urdf/r.urdf", "pkg/meshes/collision/a.stl", "package://pkg/meshes/collision/a.stl"),
    "three slashes": ("pkg/r.urdf", "pkg/a.stl", "package:///pkg/a.stl"),
    "model": ("pkg/urdf/r.urdf", "pkg/meshes/collision/a.stl", "model://pkg/meshes/collision/a.stl"),
    "above": ("pkg/urdf/r.urdf", "pkg/meshes/collision/a.stl", "../meshes/collision/a.stl"),
    "zigzag": ("pkg/urdf/r.urdf", "pkg/meshes/a.stl", "package://pkg/urdf/../meshes/a.stl"),
    "backslashes": ("pkg/urdf/r.urdf", "pkg/meshes/a.stl", r"..\meshes\a.stl"),
    "other package": ("my_robot/urdf/r.urdf", "parts/meshes/a.stl", "package://parts/meshes/a.stl"),
    "renamed package": ("pkg-2.1/urdf/r.urdf", "pkg-2.1/meshes/a.stl", "package://pkg/meshes/a.stl"),
    "no package": ("data/r.urdf", "data/meshes/a.stl", "package://meshes/a.stl"),
    "without its folder": ("urdf/r.urdf", "meshes/a.stl", "package://pkg/meshes/a.stl"),
    "from the top": ("pkg/urdf/r.urdf", "pkg/meshes/a.stl", "meshes/a.stl"),
}  # fmt: skip
OTHER_FOLDERS: Mapping[str, tuple[str, ...]] = {
    "renamed package": ("Package pkg is not there: 1 mesh is taken from pkg-2.1/.",),
    "without its folder": ("Package pkg is not there: 1 mesh is taken from ./.",),
    "from the top": ("What the URDF names beside it is not there: 1 mesh is taken from pkg/.",),
}
DECOYS = ("pkg/meshes/visual/a.stl", "b/a.stl", "pkg/urdf/other/a.stl")


@pytest.mark.parametrize("decoys", [False, True])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_package_is_read_as_it_is_laid_out(tmp_path: Path, layout: str, decoys: bool) -> None:
    urdf, mesh, name = LAYOUTS[layout]
    files: Files = {urdf: using(name), mesh: ball(7)}
    if decoys:
        files |= {decoy: ball(3) for decoy in DECOYS}
    for robot in (from_zip(files), from_folder(files, tmp_path)):
        assert triangles(robot) == [7]
        assert robot.notes == OTHER_FOLDERS.get(layout, ())
        again = robot_from_archive(packed({**files_of(robot)}))
        assert triangles(again) == [7]
        assert description_of(robot) == using(name)


PACKAGE_XML = "<package><name>{}</name></package>"
OTHER_PACKAGES: Mapping[str, Files] = {
    "a folder of its name": {"ws/src/g/meshes/a.stl": ball(7)},
    "deeper": {"ws/src/grip/g/meshes/a.stl": ball(7)},
    "named by its package.xml": {
        "ws/src/gripper/package.xml": PACKAGE_XML.format("g"),
        "ws/src/gripper/meshes/a.stl": ball(7),
        "ws/src/robot/package.xml": PACKAGE_XML.format("robot"),
    },
    "named by XML of all kinds": {
        "ws/src/gripper/package.xml": "<package ><name >g</name></package>".encode("utf-16"),
        "ws/src/gripper/meshes/a.stl": ball(7),
        "ws/src/robot/package.xml": "<package><!-- <name>g</name> --><author><name>g</name>"
        "</author><name>robot</name></package>",
        "ws/src/robot/g/meshes/a.stl": ball(5),
    },
}


@pytest.mark.parametrize("layout", OTHER_PACKAGES)
def test_a_mesh_of_another_package_is_not_taken_from_the_robots_own(
    tmp_path: Path, layout: str
) -> None:
    own: Files = {
        "ws/src/robot/urdf/r.urdf": using("package://g/meshes/a.stl"),
        "ws/src/robot/meshes/a.stl": ball(3),
    }
    robots = [from_zip(own | OTHER_PACKAGES[layout])]
    if layout != "deeper":
        robots.append(from_folder(own | OTHER_PACKAGES[layout], tmp_path))
    for robot in robots:
        assert triangles(robot) == [7]
        assert robot.notes == ()
    alone = from_zip(own)
    assert triangles(alone) == [3]
    assert alone.notes == ("Package g is not there: 1 mesh is taken from ws/src/robot/.",)


def test_where_two_packages_have_one_name_it_is_told_which_is_taken() -> None:
    files: Files = {
        "robot/r.urdf": using("package://g/meshes/a.stl"),
        "g/meshes/a.stl": ball(7),
        "g/package.xml": PACKAGE_XML.format("g"),
        "copy/package.xml": PACKAGE_XML.format("g"),
    }
    robot = from_zip(files)
    assert triangles(robot) == [7]
    assert robot.notes == ("Several packages are called g; g/meshes/a.stl is taken.",)


def test_a_mesh_that_its_known_package_lacks_is_refused(tmp_path: Path) -> None:
    files: Files = {
        "robot/r.urdf": using("package://g/meshes/a.stl"),
        "robot/meshes/a.stl": ball(3),
        "gripper/package.xml": PACKAGE_XML.format("g"),
    }
    with pytest.raises(SceneError, match=r"package://g/meshes/a\.stl.*as gripper/meshes/a\.stl"):
        from_zip(files)
    with pytest.raises(SceneError, match=r"gripper/meshes/a\.stl"):
        from_folder(files, tmp_path)


@pytest.mark.parametrize("name", ["floor", "obstacles"])
@pytest.mark.parametrize("taken", [(), ("link",), ("link", "link_2")])
def test_a_link_called_as_a_part_of_the_world_gets_a_free_name_wherever_it_is_named(
    name: str, taken: tuple[str, ...]
) -> None:
    text = arm(*[(BOX, BOX)] * 3)
    pairs = '<disable_collisions link1="a" link2="c" reason="Never"/>'
    files: Files = {"r.urdf": text, "r.srdf": f'<robot name="r">{pairs}</robot>'}
    plain = from_zip(files)
    given = {"a": name, **dict(zip("bc", (f"{name}_{one}" for one in taken), strict=False))}

    def quoted(found: re.Match[str]) -> str:
        return f'"{given.get(found[1], found[1])}"'

    named: Files = {
        path: re.sub(r'"(\w+)"', quoted, str(content)) for path, content in files.items()
    }
    robot = from_zip(named)
    free = f"{name}_link" if not taken else f"{name}_link_{len(taken) + 1}"
    assert robot.notes[0] == f"Link {name} is called {free} here, for {name} is the world's."
    new = {**given, "a": free}
    assert [*robot.links] == [new.get(link, link) for link in plain.links]
    assert robot.may_touch == {frozenset((free, new.get("c", "c")))}
    assert [
        (new.get(one.parent, one.parent), new.get(one.child, one.child)) for one in plain.joints
    ] == [(one.parent, one.child) for one in robot.joints]
    again = from_zip({**files_of(robot)})
    assert [*again.links] == [*robot.links]
    assert again.may_touch == robot.may_touch
    assert f'"{name}"' not in description_of(robot)


def test_the_longest_common_end_of_the_path_decides_and_a_note_tells_of_it() -> None:
    name = "package://other/meshes/arm/a.stl"
    files: Files = {"r.urdf": using(name), "x/arm/a.stl": ball(5), "y/leg/a.stl": ball(6)}
    robot = from_zip(files)
    assert triangles(robot) == [5]
    assert robot.notes == (f"Taken for {name}: x/arm/a.stl.",)
    with pytest.raises(SceneError, match=r"there are x/arm/a\.stl, z/arm/a\.stl"):
        from_zip({**files, "z/arm/a.stl": ball(5)})


@pytest.mark.parametrize("name", ["Meshes/A.STL", "meshes/a.STL", "MESHES/A.stl"])
def test_names_that_differ_in_case_are_found_and_told(name: str) -> None:
    robot = from_zip({"pkg/r.urdf": using("package://pkg/meshes/a.stl"), f"pkg/{name}": ball(4)})
    assert triangles(robot) == [4]
    told = (f"Taken for package://pkg/meshes/a.stl: pkg/{name}.",)
    assert robot.notes == (told if name.endswith(("A.STL", "a.STL", "A.stl")) else ())
    both: Files = {"r.urdf": using("m/a.stl"), f"{name}": ball(4), "m/a.stl": ball(2)}
    assert triangles(from_zip(both)) == [2]


def test_letters_of_both_normal_forms_are_the_same() -> None:
    composed = "Träger.stl"
    apart = unicodedata.normalize("NFD", composed)
    assert triangles(from_zip({"r.urdf": using(composed), f"m/{apart}": ball(4)})) == [4]


def mac(files: Files) -> Files:
    """The files as a Mac packs them, with what it adds for itself."""
    junk: Files = {}
    for name in files:
        folder, _, last = name.rpartition("/")
        junk[f"__MACOSX/{folder}/._{last}"] = b"\0\5\x16\7"
        junk[f"{folder}/.DS_Store"] = b"Bud1"
    return files | junk


def windows(files: Files) -> Files:
    """The files as some programs pack them, with backslashes and entries for folders."""
    made: Files = {name.replace("/", "\\"): content for name, content in files.items()}
    return made | {"pkg\\": b"", "pkg\\meshes\\": b"", "pkg\\Thumbs.db": b"x"}


@pytest.mark.parametrize("how", [mac, windows])
def test_archives_of_file_managers_are_read(how: object) -> None:
    files: Files = {
        "pkg/r.urdf": using("package://pkg/meshes/a.stl"),
        "pkg/meshes/a.stl": ball(4),
        "pkg/r.srdf": SRDF,
    }
    assert callable(how)
    robot = from_zip(how(files))
    assert triangles(robot) == [4]
    assert robot.may_touch == {frozenset("ac")}
    assert {*files_of(robot)} >= {"r.urdf", "pkg/meshes/a.stl"}


@pytest.mark.parametrize("how", [dict, mac, windows])
@pytest.mark.parametrize("top", ["", "my scene/", "a/b/"])
def test_a_scene_may_be_in_a_folder_of_its_archive(tmp_path: Path, how: object, top: str) -> None:
    scene = {
        "version": 1,
        "obstacles": [{"shape": "mesh", "file": "parts/a.stl", "position": [3, 3, 3]}],
        "arm": {"model": "urdf", "urdf": "pkg/urdf/r.urdf"},
    }
    files: Files = {
        "scene.json": json.dumps(scene),
        "parts/a.stl": ball(12),
        "pkg/urdf/r.urdf": using("package://pkg/meshes/a.stl"),
        "pkg/meshes/a.stl": ball(4),
    }
    assert callable(how)
    (tmp_path / "s.zip").write_bytes(packed(how({top + name: one for name, one in files.items()})))
    found = load_scene(tmp_path / "s.zip")
    assert found.obstacles[0].shape == "mesh"
    assert triangles(found.arm.robot) == [4]
    assert Scene.from_dict(found.to_dict(), found.meshes) == found


def test_an_archive_of_several_scenes_is_refused(tmp_path: Path) -> None:
    for one, other in (("a/scene.yaml", "b/scene.yaml"), ("Scene.yaml", "scene.json")):
        two: Files = {one: '{"version": 1}', other: '{"version": 1}'}
        (tmp_path / "s.zip").write_bytes(packed(two))
        with pytest.raises(SceneError, match=f"one scene, not of {one} and {other}"):
            load_scene(tmp_path / "s.zip")


def test_a_scene_is_found_whatever_the_case_of_its_name(tmp_path: Path) -> None:
    (tmp_path / "s.zip").write_bytes(packed({"Scene.YAML": "{version: 1, goal: [1, 2, 3]}"}))
    assert load_scene(tmp_path / "s.zip").goal == (1, 2, 3)


SEVERAL: Files = {
    "pkg/urdf/one.urdf": using("package://pkg/meshes/a.stl"),
    "pkg/urdf/two.urdf": arm(('"d"', '"hand"'), ('"d"', '"hand"')),
    "pkg/old/one.urdf": arm(),
    "pkg/meshes/a.stl": ball(4),
    "pkg/srdf/two.srdf": SRDF,
    "pkg/srdf/one.srdf": SRDF,
}


def test_of_several_robots_one_is_chosen_by_its_name(tmp_path: Path) -> None:
    (tmp_path / "robots.zip").write_bytes(packed(SEVERAL))

    def scene(urdf: str) -> Scene:
        return Scene.from_dict({"version": 1, "arm": {"model": "urdf", "urdf": urdf}}, tmp_path)

    one, two = scene("robots.zip/urdf/one.urdf"), scene("robots.zip/two.urdf")
    assert triangles(one.arm.robot) == [4]
    assert two.arm.tool == "hand"
    assert one.arm.robot != two.arm.robot
    assert one.arm.robot.may_touch == {frozenset("ac")}
    for made in (one, two):
        assert Scene.from_dict(made.to_dict(), made.meshes) == made
        (tmp_path / "saved.zip").write_bytes(made.pack())
        assert load_scene(tmp_path / "saved.zip") == made
    with pytest.raises(SceneError, match=r"named after it, such as robots\.zip/pkg/old/one\.urdf"):
        scene("robots.zip")
    for name in ("one.urdf", "three.urdf"):
        with pytest.raises(SceneError, match=r"one of pkg/old/one\.urdf, pkg/urdf/one\.urdf"):
            scene(f"robots.zip/{name}")


def test_of_several_srdfs_none_is_used_but_that_of_the_robots_name() -> None:
    files: Files = {"r.urdf": arm(), "a.srdf": SRDF, "b.srdf": SRDF}
    robot = from_zip(files)
    assert not robot.may_touch
    assert robot.notes == ("No SRDF is used, as none of several is called r.srdf.",)
    assert from_zip({**files, "r.srdf": SRDF}).may_touch


OUTSIDE = (
    *("../secret.stl", "a/../../secret.stl", "package://x/../../secret.stl", "package://x"),
    *("/etc/passwd", "file:///etc/passwd", "http://host/a.stl", r"\\\\host\a.stl", r"C:\a.stl"),
)


@pytest.mark.parametrize("name", OUTSIDE)
def test_a_name_never_leads_out_of_the_folder(tmp_path: Path, name: str) -> None:
    (tmp_path / "secret.stl").write_bytes(ball(3))
    with pytest.raises(SceneError, match=r"arm\.urdf"):
        from_folder({"r.urdf": using(name)}, tmp_path / "scene")
    with pytest.raises(SceneError, match=r"arm\.urdf"):
        from_zip({"x/r.urdf": using(name)})


def test_entries_that_lead_out_of_an_archive_are_not_there() -> None:
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        archive.writestr("r.urdf", using("a.stl"))
        archive.writestr("../a.stl", ball(3))
    with pytest.raises(SceneError, match="a file that came with the URDF"):
        robot_from_archive(content.getvalue())


def test_vertices_are_those_of_the_mesh_that_is_meant() -> None:
    name = "package://pkg/meshes/collision/a.stl"
    files: Files = {"pkg/urdf/r.urdf": using(name), "pkg/meshes/collision/a.stl": ball(6)}
    (shape,) = from_zip({**files, "pkg/meshes/visual/a.stl": ball(2)}).links["a"].shapes
    expected = np.frombuffer(ball(6)[84:], dtype=np.uint8).reshape(6, 50)[:, 12:48]
    corners = np.ascontiguousarray(expected).view("<f4").reshape(-1, 3)
    np.testing.assert_allclose(np.sort(shape.vertices[shape.faces].reshape(-1, 3), axis=0),
                               np.sort(corners, axis=0))  # fmt: skip


def test_a_file_keeps_its_own_name_whatever_one_is_called_that_was_made_of_it() -> None:
    files: Files = {"r.urdf": using("a.stl"), "a.stl": ball(2), "a.stl.plain.stl": ball(0)}
    for order in (files, dict(reversed(files.items()))):
        assert triangles(from_zip(order)) == triangles(from_zip({**files, "a.stl.plain.stl": b""}))


def test_only_in_archives_of_the_program_are_its_names_for_what_it_converted_its_own() -> None:
    files: Files = {
        "z/package.xml": "<package><name>z</name></package>",
        "z/r.urdf": using("package://z/a.dae"),
        "z/a.dae.plain.stl": ball(2),
        "notes.plain.txt": "Every mesh is exact.",
    }
    told = from_zip(files).notes
    assert "notes.plain.txt says: Every mesh is exact." in told
    assert "Taken for package://z/a.dae: z/a.dae.plain.stl." in told
    del files["z/a.dae.plain.stl"], files["notes.plain.txt"]
    sources = MeshSource({"r.zip": packed({**files, "z/a.dae": dae(0.3)})})
    robot = load_plain_robot("r.zip", sources)
    assert b"a.dae.plain.stl" in robot.archive
    assert robot.notes == robot_from_archive(robot.archive).notes


@pytest.mark.parametrize("scale", ["0 0 0", "1 1 0", "-0 1 1"])
def test_a_mesh_that_is_scaled_to_nothing_is_refused(scale: str) -> None:
    flat = arm((BOX, f'<mesh filename="a.stl" scale="{scale}"/>'))
    with pytest.raises(SceneError, match=r"scale is .* other than 0"):
        from_zip({"r.urdf": flat, "a.stl": ball(1)})


def with_checksum(content: bytes, wanted: int) -> bytes:
    """Content with bytes 4 to 8 changed so that it has a CRC-32, which is linear in its bits."""
    head, word, rest = content[:4], content[4:8], content[8:]
    without = zlib.crc32(content)
    rows = []
    for bit in range(32):
        one = int.from_bytes(word, "little") ^ 1 << bit
        rows.append((zlib.crc32(head + one.to_bytes(4, "little") + rest) ^ without, 1 << bit))
    missing, changed = without ^ wanted, 0
    for _ in range(32):  # Gaussian elimination over the bits
        pivot = max(rows)
        rows.remove(pivot)
        top = pivot[0].bit_length()
        rows = [(a ^ pivot[0], b ^ pivot[1]) if a.bit_length() == top else (a, b) for a, b in rows]
        if missing.bit_length() == top:
            missing, changed = missing ^ pivot[0], changed ^ pivot[1]
    return head + (int.from_bytes(word, "little") ^ changed).to_bytes(4, "little") + rest


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize("other", ["m/a.stl", r"m\a.stl", "./m/a.stl"])
def test_two_files_of_one_name_are_refused_unless_they_are_the_same(other: str) -> None:
    def packed_twice(second: bytes) -> bytes:
        content = io.BytesIO()
        with zipfile.ZipFile(content, "w") as archive:
            archive.writestr("r.urdf", using("m/a.stl"))
            archive.writestr("m/a.stl", ball(1))
            archive.writestr(other, second)
        return content.getvalue()

    assert triangles(robot_from_archive(packed_twice(ball(1))))
    forged = with_checksum(ball(1)[:-4] + b"abcd", zlib.crc32(ball(1)))
    assert zlib.crc32(forged) == zlib.crc32(ball(1))
    with pytest.raises(SceneError, match=r"two files m/a\.stl"):
        robot_from_archive(packed_twice(forged))
    with pytest.raises(SceneError, match=r"two files m/a\.stl.*each file is once"):
        robot_from_archive(packed_twice(ball(0)))
