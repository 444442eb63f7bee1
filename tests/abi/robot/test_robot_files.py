from __future__ import annotations

import builtins
import io
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.robot_files import SHIPPED, load_robot, robot_from_archive
from abi.robot.urdf_arm import urdf_arm
from tests.abi.robot.robots import arm, joint, link, packed, urdf
from tests.thorough import examples

SPHERE = '<collision><geometry><sphere radius="1"/></geometry></collision>'
MESH = '<box size="0.1 0.1 0.3"/>'
HOSTILE: dict[str, str | bytes] = {
    "empty": b"",
    "binary": bytes(range(256)),
    "html": "<html><body>404</body></html>",
    "gzip": b"\x1f\x8b" + bytes(40),
    "cut off": arm()[:-60],
    "no links": urdf(),
    "doctype": '<!DOCTYPE r [<!ENTITY x "y">]>' + arm(),
    "entity in UTF-16": ('<!DOCTYPE r [<!ENTITY x "y">]>' + urdf()).encode("utf-16"),
    "bomb": '<!DOCTYPE r [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>' + arm(),
    "xacro": arm(('size="0.1 0.1 0.3"', 'size="${w} 1 1"')),
    "deep": urdf("<a>" * 5000 + "</a>" * 5000),
    "cycle": urdf(link("a"), link("b"), joint("p", "a", "b"), joint("q", "b", "a")),
    "cycle beside": urdf(
        *map(link, "abc"), joint("p", "b", "c"), joint("q", "c", "b")
    ),
    "joint to itself": urdf(link("a"), joint("p", "a", "a")),
    "two roots": urdf(link("a"), link("b")),
    "two parents": urdf(*map(link, "abc"), joint("p", "a", "c"), joint("q", "b", "c")),
    "same link twice": urdf(link("a"), link("a")),
    "same joint twice": urdf(*map(link, "abc"), joint("p", "a", "b"), joint("p", "b", "c")),
    "unknown child": urdf(link("a"), joint("p", "a", "nowhere")),
    "no type": arm(('type="prismatic"', "")),
    "NaN speed": arm(('velocity="1"', 'velocity="nan"')),
    "many digits": arm(('upper="2"', 'upper="2.' + "0" * 500 + '"')),
    "NaN limit": arm(('lower="-2"', 'lower="nan"')),
    "Arabic digits": arm(('upper="2"', 'upper="٢"')),
    "no axis": arm(('xyz="0 0 1"', 'xyz="0 0 0"')),
    "NaN origin": arm(('xyz="0 0 0.4"', 'xyz="0 nan 0.4"')),
    "two numbers": arm(('xyz="0 0 0.4"', 'xyz="0 0.4"')),
    "negative box": arm((MESH, '<box size="-0.1 0.1 0.3"/>')),
    "no size": arm((MESH, "<box/>")),
    "huge sphere": arm((MESH, '<sphere radius="1e308"/>')),
    "unknown shape": arm((MESH, '<capsule radius="1"/>')),
    "script as a name": arm(('link name="b"', 'link name="&lt;script&gt;"')),
    "path as a name": arm(('link name="b"', 'link name="../b"')),
    "mimic of itself": arm(('effort="9"/>', 'effort="9"/><mimic joint="p"/>')),
    "nothing that moves": urdf(link("a"), link("b"), joint("p", "a", "b", "fixed")),
    "no joint": urdf(link("a")),
    "no range": urdf(link("a"), link("b"), joint("p", "a", "b")).replace('upper="2"', 'upper="-2"'),
    "many shapes": urdf(link("a").replace("</link>", SPHERE * 60 + "</link>")),
    "many links": urdf(*(link(f"l{k}") for k in range(200))),
    **{
        f"mesh {name}": arm((MESH, f'<mesh filename="{name}"/>'))
        for name in (
            "/etc/passwd",
            "file:///etc/passwd",
            "../secret.stl",
            "a/../../secret.stl",
            "package://x/../../secret.stl",
            "package://",
            "http://127.0.0.1/x.stl",
            "\\\\host\\x.stl",
            "",
            "missing.stl",
            "b.dae",
        )
    },
}  # fmt: skip


def ball(count: int = 1) -> bytes:
    """A binary STL of ``count`` triangles."""
    corners = np.random.default_rng(0).random((count, 3, 3)).astype("<f4")
    body = b"".join(bytes(12) + row.tobytes() + bytes(2) for row in corners)
    return bytes(80) + struct.pack("<I", count) + body


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_arms_are_whole(name: str) -> None:
    robot = load_robot(name, MeshSource())

    assert SHIPPED[name] in robot.links
    assert all(joint.child in robot.links for joint in robot.joints)
    carried = [joint.child for joint in robot.joints if joint.kind != "fixed"]
    assert all(robot.links[link].shapes and robot.links[link].mass > 0 for link in carried)
    assert load_robot(name, MeshSource()) is robot


@pytest.mark.parametrize("name", HOSTILE)
def test_what_is_no_arm_is_refused_in_one_sentence(name: str) -> None:
    with pytest.raises(SceneError) as refusal:
        robot_from_archive(packed({"robot/r.urdf": HOSTILE[name], "robot/b.dae": b"x"}))

    assert refusal.value.message.startswith("arm.urdf")
    assert len(refusal.value.message) < 400


def test_nothing_that_a_file_names_is_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "secret.stl").write_bytes(ball())
    folder = tmp_path / "scene"
    folder.mkdir()
    opened: list[str] = []
    keep = io.open

    def watched(file: object, *rest: Any, **options: Any) -> Any:
        opened.append(str(file))
        return keep(file, *rest, **options)  # type: ignore[call-overload]

    monkeypatch.setattr(io, "open", watched)
    monkeypatch.setattr(builtins, "open", watched)
    for name, text in HOSTILE.items():
        (folder / "r.urdf").write_bytes(text if isinstance(text, bytes) else text.encode())
        with pytest.raises(SceneError):
            load_robot("r.urdf", MeshSource(folder=folder))
        assert not [path for path in opened if "secret" in path or "passwd" in path], name


def test_meshes_are_found_beside_the_urdf_or_by_their_only_name(tmp_path: Path) -> None:
    text = arm((MESH, '<mesh filename="package://r/meshes/ball.stl" scale="2 2 -2"/>'))
    files: dict[str, str | bytes] = {"x/arm.urdf": text, "x/parts/ball.stl": ball(9)}
    robot = robot_from_archive(packed(files))
    beside = tmp_path / "meshes"
    beside.mkdir()
    (beside / "ball.stl").write_bytes(ball(9))
    (tmp_path / "arm.urdf").write_text(text)
    same = load_robot("arm.urdf", MeshSource(folder=tmp_path))

    for found in (robot, same):
        (shape,) = found.links["a"].shapes
        assert len(shape.faces) == 9
        assert shape.vertices[:, 2].max() <= 0  # mirrored
    with pytest.raises(SceneError, match=r"ball\.stl"):
        robot_from_archive(packed({**files, "y/ball.stl": ball()}))


def test_a_mesh_in_many_places_counts_in_each() -> None:
    shape = '<collision><geometry><mesh filename="b.stl"/></geometry></collision>'
    files: dict[str, str | bytes] = {
        "a.urdf": arm(("</link>", shape * 49 + "</link>")),
        "b.stl": ball(11_000),
    }
    with pytest.raises(SceneError, match="500,000 triangles in all"):
        robot_from_archive(packed(files))


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (lambda: b"PK\x03\x04" + bytes(100), "zip"),
        (lambda: packed({"a.urdf": arm()})[:-40], "zip"),
        (lambda: packed({"a.urdf": arm(), "b.urdf": arm()}), "one file that ends in .urdf"),
        (lambda: packed({"a.txt": "x"}), "one file that ends in .urdf"),
        (lambda: packed({str(k): "x" for k in range(2500)}), "at most 2,000 files"),
        (lambda: packed({"a.urdf": arm(), "bomb.stl": bytes(150_000_000)}), "100 MB"),
        (lambda: packed({"a.urdf": " " * 2_100_000}), "at most 2 MB"),
    ],
    ids=["no zip", "cut off", "two", "none", "many", "bomb", "long"],
)
def test_archives_that_cannot_be_meant_are_refused(
    content: Callable[[], bytes], expected: str
) -> None:
    with pytest.raises(SceneError, match=expected):
        robot_from_archive(content())


SRDF = (
    '<robot name="r"><disable_collisions link1="a" link2="c" reason="Never"/>'
    '<disable_collisions link1="d" link2="hand"/><disable_collisions link1="b" link2="b"/></robot>'
)


def test_an_srdf_takes_pairs_of_links_out_of_the_checks(tmp_path: Path) -> None:
    files: dict[str, str | bytes] = {"x/a.urdf": arm()}
    plain = robot_from_archive(packed(files))
    robot = robot_from_archive(packed({**files, "y/config.srdf": SRDF}))
    (tmp_path / "a.urdf").write_text(arm())
    (tmp_path / "a.srdf").write_text(SRDF)
    beside = load_robot("a.urdf", MeshSource(folder=tmp_path))

    assert plain.may_touch == frozenset()
    for found in (robot, beside):
        assert found.may_touch == {frozenset("ac")}
        assert any("SRDF" in note for note in found.notes)
        assert load_robot("own.zip", MeshSource({"own.zip": found.archive})).may_touch

    def checked(one: Robot) -> set[frozenset[str]]:
        placed = urdf_arm(one, "d", (0.0, 0.0, 0.0))
        links = [capsule.link for capsule in placed.capsules]
        return {frozenset((links[i], links[j])) for i, j in placed.pairs}

    assert checked(plain) - checked(robot) == {frozenset("ac")}
    assert checked(robot) <= checked(plain)


@pytest.mark.parametrize("text", ["<robot", "", '<!DOCTYPE r SYSTEM "x"><robot/>', "<x/>"])
def test_a_damaged_srdf_is_refused(text: str) -> None:
    with pytest.raises(SceneError, match=r"r\.srdf"):
        robot_from_archive(packed({"a.urdf": arm(), "r.srdf": text}))


def test_an_archive_that_lies_about_its_sizes_is_refused() -> None:
    content = bytearray(packed({"a.urdf": arm(), "b.stl": bytes(1000)}))
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        offset = archive.start_dir
    # the directory's own sizes, which the archive is judged by
    content[offset + 24 : offset + 28] = struct.pack("<I", 10)

    with pytest.raises(SceneError):
        robot_from_archive(bytes(content))


@settings(max_examples=examples(50))
@given(st.data())
def test_a_damaged_urdf_is_read_or_refused(data: st.DataObject) -> None:
    text = bytearray(arm().encode())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text) - 1))
        how = data.draw(st.sampled_from(["change", "cut", "double"]))
        if how == "change":
            text[at] = data.draw(st.integers(0, 255))
        elif how == "cut":
            del text[at : at + data.draw(st.integers(1, 60))]
        else:
            text[at:at] = text[at : at + data.draw(st.integers(1, 200))]
        assume(text)
    try:
        robot = robot_from_archive(packed({"a.urdf": bytes(text)}))
    except SceneError:
        return
    assert all(np.isfinite(joint.origin).all() for joint in robot.joints)
    assert all(joint.low <= joint.high for joint in robot.joints)
