"""Scenes and their meshes in one file."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from abi.errors import SceneError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.triangle_mesh import mesh_reader
from abi.obstacles.triangle_mesh.mesh_reader import SUFFIXES
from abi.scene.scene import MOST_OBSTACLES, Scene, load_scene
from tests.abi import meshes
from tests.abi.robot.robots import arm, packed


def rough() -> bytes:
    """A box and a ball on a lattice: its repair would be repaired again, otherwise."""
    vertices, faces = meshes.sphere(2)
    shaken = vertices * np.random.default_rng(0).uniform(0.6, 1.4, (len(vertices), 1))
    return meshes.stl(meshes.joined((np.round(2 * shaken) / 2, faces[1:]), meshes.box()))


def with_meshes() -> Scene:
    files = {
        "rough.stl": rough(),
        "parts/nut.stl": meshes.stl(meshes.bumpy(2)),
        "nut.stl": meshes.stl(meshes.soup(20, seed=1, size=0.5)),
    }
    obstacles = [
        {"shape": "mesh", "file": "parts/nut.stl", "position": [3, 3, 3], "scale": 0.7},
        {"shape": "box", "size": [1, 1, 1], "position": [1, 4, 1]},
        {"shape": "mesh", "file": "nut.stl", "position": [4, 2, 1], "wxyz": [1, 1, 0, 0]},
        {"shape": "mesh", "file": "rough.stl", "position": [4, 4, 4], "scale": 0.5},
    ]
    return Scene.from_dict({"version": 1, "obstacles": obstacles}, files)


def archive(**files: str) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as into:
        for name, content in files.items():
            into.writestr(name.replace("__", "."), content)
    return packed.getvalue()


def test_a_scene_comes_back_with_its_meshes(tmp_path: Path) -> None:
    scene = with_meshes()
    path = tmp_path / "mine.zip"
    path.write_bytes(scene.pack())
    assert load_scene(path) == scene
    assert load_scene(path).meshes.files == scene.meshes.files


@pytest.mark.parametrize("limit", ["MAX_BYTES", "MAX_FACES"])
def test_a_mesh_too_large_to_be_read_again_is_not_packed(
    limit: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = with_meshes()
    monkeypatch.setattr(mesh_reader, limit, 100)
    with pytest.raises(SceneError, match="at most 500,000 triangles, and 50 MB"):
        scene.pack()


def test_meshes_of_every_format_come_back_equal(tmp_path: Path) -> None:
    ball: Any = trimesh.creation.icosphere(2, 0.6)
    parts: Any = trimesh.util.concatenate(  # united, and one apart
        [
            trimesh.creation.box(),
            ball,
            trimesh.creation.icosphere(1, 0.2).apply_translation((2, 0, 0)),
        ]
    )
    files = {}
    for suffix in SUFFIXES:
        content = parts.export(file_type=suffix[1:])
        files[f"parts/a{suffix}"] = content if isinstance(content, bytes) else content.encode()
    files |= {"a.obj": files["parts/a.obj"], "parts/a2.obj": ball.export(file_type="obj").encode()}
    shapes = [{"shape": "mesh", "file": file, "position": [3, 3, 3]} for file in files]
    scene = Scene.from_dict({"version": 1, "obstacles": shapes}, files)
    path = tmp_path / "mine.zip"
    path.write_bytes(scene.pack())

    assert load_scene(path) == scene
    with zipfile.ZipFile(path) as packed:
        packed.extractall(tmp_path / "unpacked")
    by_hand = load_scene(tmp_path / "unpacked" / "scene.yaml")
    for one, other in zip(scene.obstacles, by_hand.obstacles, strict=True):
        assert isinstance(one, MeshShape)
        assert isinstance(other, MeshShape)
        assert one.surface == other.surface


@pytest.mark.parametrize("comment", ["drawn with v1.2", "part.stl", "exported from nut.stl"])
def test_an_archive_of_obj_files_keeps_them_apart_whatever_their_comments(
    tmp_path: Path, comment: str
) -> None:
    path = tmp_path / "old.zip"
    sizes = {"nut.obj": 1.0, "wall.obj": 3.0}
    shapes = ", ".join(f"{{shape: mesh, file: {file}}}" for file in sizes)
    with zipfile.ZipFile(path, "w") as into:
        into.writestr("scene.yaml", f"version: 1\nobstacles: [{shapes}]")
        for file, size in sizes.items():
            into.writestr(file, trimesh.creation.box([size] * 3).export(file_type="obj"))
            into.getinfo(file).comment = comment.encode()
    for shape, (file, size) in zip(load_scene(path).obstacles, sizes.items(), strict=True):
        assert isinstance(shape, MeshShape)
        assert shape.file == file
        assert shape.surface.extent == pytest.approx(size)


def test_a_scene_comes_back_with_its_arm(tmp_path: Path) -> None:
    files = {"own arm.zip": packed({"x/r.urdf": arm()})}
    settings = {"model": "urdf", "urdf": "own arm.zip", "tip": "c"}
    scene = Scene.from_dict({"version": 1, "arm": settings}, files)
    path = tmp_path / "mine.zip"
    path.write_bytes(scene.pack())

    assert load_scene(path) == scene
    assert load_scene(path).arm.robot == scene.arm.robot


@pytest.mark.slow
@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (lambda: b"PK\x03\x04 cut off", "whole zip"),
        (lambda: with_meshes().pack()[:-30], "whole zip"),
        (lambda: archive(mesh__obj="v 0 0 0"), "scene.yaml in it"),
        (lambda: archive(scene__yaml="version: 2"), "version"),
        (lambda: archive(scene__json="0" * 200_000_001), "200 MB"),
    ],
    ids=["not an archive", "cut off", "no scene", "another version", "too large"],
)
def test_what_is_no_archive_of_a_scene_is_refused(
    tmp_path: Path, content: Callable[[], bytes], expected: str
) -> None:
    path = tmp_path / "scene.zip"
    path.write_bytes(content())
    with pytest.raises(SceneError, match=expected):
        load_scene(path)


def test_more_obstacles_than_can_be_planned_are_refused_at_once() -> None:
    ball = {"shape": "sphere", "radius": 0.01}
    with pytest.raises(SceneError, match="obstacles is 5001; expected at most 5,000"):
        Scene.from_dict({"version": 1, "obstacles": [ball] * (MOST_OBSTACLES + 1)})


@pytest.mark.slow
def test_a_text_of_too_many_entries_is_refused_before_it_is_built(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text("{version: 1, obstacles: [" + "{a: [1]}, " * 12_000 + "]}")
    with pytest.raises(SceneError, match="fewer entries, or the same as JSON"):
        load_scene(path)
