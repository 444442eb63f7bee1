"""Scenes of the server's own machine: read as the library reads them, but in another process."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from abi.errors import SceneError
from abi.obstacles.triangle_mesh import mesh_reader
from abi.robot.urdf.robot_files import robot_from_archive
from abi.scene.scene import Scene, load_scene
from app.reading.local_scene import load_local
from tests.abi import meshes
from tests.abi.robot.robots import packed
from tests.abi.robot.test_visuals import ENTITY, dae, looking


def refuse(*_: Any) -> None:
    raise AssertionError("read in this process")


def written(folder: Path, look: bytes, arm: str = "own/a.urdf") -> Path:
    """A scene file with an arm that has a DAE, and with a mesh, beside it."""
    (folder / "own").mkdir()
    (folder / "own" / "a.urdf").write_text(looking("a.dae"))
    (folder / "own" / "a.dae").write_bytes(look)
    (folder / "own.zip").write_bytes(packed({"a.urdf": looking("a.dae"), "a.dae": look}))
    (folder / "a.stl").write_bytes(meshes.stl(meshes.bumpy(2)))
    path = folder / "scene.json"
    obstacle = {"shape": "mesh", "file": "a.stl", "position": [3, 3, 3]}
    data = {"version": 1, "obstacles": [obstacle], "arm": {"model": "urdf", "urdf": arm}}
    path.write_text(json.dumps(data))
    return path


@pytest.mark.slow
@pytest.mark.parametrize("arm", ["own/a.urdf", "own.zip"])
def test_no_dae_is_read_in_this_process(
    arm: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written(tmp_path, dae(0.3), arm)
    wanted = load_scene(path)
    robot_from_archive.cache_clear()
    monkeypatch.setitem(mesh_reader._READERS, ".dae", refuse)
    scene = load_local(str(path))

    assert scene.to_dict() == wanted.to_dict()
    mesh, other = (one.meshes.surface("a.stl") for one in (scene, wanted))
    np.testing.assert_array_equal(mesh.vertices, other.vertices)
    for link, same in zip(
        scene.arm.robot.links.values(), wanted.arm.robot.links.values(), strict=True
    ):
        assert [len(shape.faces) for shape in link.drawn] == [len(s.faces) for s in same.drawn]
    assert Scene.from_dict(scene.to_dict(), scene.meshes).arm.robot == scene.arm.robot


@pytest.mark.slow
def test_what_is_wrong_with_a_file_is_said(tmp_path: Path) -> None:
    path = written(tmp_path, ENTITY)
    assert "cannot be read: a." in load_local(str(path)).arm.robot.notes[0]
    (tmp_path / "a.stl").write_bytes(b"solid a")
    with pytest.raises(SceneError, match=r"a\.stl"):
        load_local(str(path))
    (tmp_path / "a.stl").unlink()
    with pytest.raises(SceneError) as error:
        load_local(str(path))
    with pytest.raises(SceneError) as wanted:
        load_scene(path)
    assert (error.value.field, error.value.message) == (wanted.value.field, wanted.value.message)


def test_a_scene_that_names_no_file_starts_no_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.reading.running_reader.subprocess.Popen", refuse)
    assert load_local("paper").to_dict() == load_scene("paper").to_dict()
    assert load_local("kitchen-ur5e").arm.urdf == "ur5e"


def test_a_held_mesh_comes_from_its_file_and_from_its_zip(tmp_path: Path) -> None:
    (tmp_path / "held.stl").write_bytes(meshes.stl(meshes.bumpy(2)))
    held = {"shape": "mesh", "file": "held.stl", "scale": 0.02}
    arm = {"model": "urdf", "urdf": "ur5e", "base": [0, 0, 0], "attached": held}
    workspace = {"min": [-1, -1, 0], "max": [1, 1, 1.5]}
    data = {"version": 1, "unit": "m", "workspace": workspace, "mesh": {"pitch": 0.3}, "arm": arm}
    data |= {"start": [0.4, -0.3, 0.5], "goal": [0.4, 0.3, 0.5]}
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(data))
    scene = load_scene(path)
    (tmp_path / "scene.zip").write_bytes(scene.pack())
    for name in ("scene.json", "scene.zip"):
        assert load_local(str(tmp_path / name)) == load_scene(tmp_path / name) == scene
