from __future__ import annotations

import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from abi import assets
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.obstacles.triangle_mesh.surface import Surface
from abi.scene.scene import Scene, load_scene
from app.shared import mesh_store
from app.state.tab_state import TabState
from tests.abi import meshes
from tests.abi.robot.robots import arm, packed

SHIPPED = MeshSource(folder=assets.path("scenes"))


@pytest.fixture(autouse=True)
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("ABI_STORE", str(tmp_path / "store"))
    return tmp_path / "store"


def _scene() -> Scene:
    """The paper's scene with an uploaded mesh besides its cube."""
    file = {"shape": "mesh", "file": "bumpy.stl", "position": [1, 1, 5], "scale": 0.3}
    scene = load_scene("paper")
    cube = scene.obstacles[0].model_dump()
    content = meshes.stl(meshes.inverted(meshes.bumpy(2)))  # which is turned
    return scene.replace(obstacles=[cube, file], files={"bumpy.stl": content})


def test_a_scene_comes_back_with_its_mesh() -> None:
    state = TabState("paper", _scene())
    mesh_store.keep(state.scene.meshes.files)
    again = TabState.decode(state.encode(), SHIPPED)
    assert again == state
    kept, surface = (one.scene.meshes.files["bumpy.stl"] for one in (state, again))
    assert isinstance(kept, Surface)
    assert isinstance(surface, Surface)
    assert surface.notes == kept.notes
    assert kept.given is not None
    assert surface.given is not None
    np.testing.assert_array_equal(surface.given[1], kept.given[1])


def test_a_mesh_that_is_not_here_is_named_and_the_rest_comes_back() -> None:
    state = TabState("paper", _scene())
    again = TabState.decode(state.encode(), SHIPPED)
    assert again.missing == ("bumpy.stl",)
    assert again.scene == load_scene("paper")


@pytest.mark.parametrize("stored", [False, True])
def test_another_mesh_of_the_same_name_is_not_taken_for_one_that_is_not_here(stored: bool) -> None:
    other = {"shape": "mesh", "file": "bumpy.stl", "position": [5, 5, 1], "scale": 0.1}
    here = load_scene("paper").replace(
        obstacles=[other], files={"bumpy.stl": meshes.stl(meshes.bumpy(3, seed=1))}
    )
    shipped = next(iter(load_scene("sculpture").meshes.files))
    state = TabState("paper", _scene())
    data = [one.model_dump() for one in state.scene.obstacles]
    files = {"bumpy.stl": state.scene.meshes.files["bumpy.stl"]}
    surface = MeshSource({"a.stl": meshes.stl(meshes.bumpy(1))}).surface("a.stl")
    named = state.scene.replace(
        obstacles=[*data, {**data[1], "file": shipped}],
        files={**files, shipped: surface},
    )
    if stored:
        mesh_store.keep(named.meshes.files)
    source = MeshSource(here.meshes.files, SHIPPED.folder)
    again = TabState.decode(TabState("paper", named).encode(), source)
    assert again.missing == (() if stored else ("bumpy.stl", shipped))
    assert again.scene == (named if stored else load_scene("paper"))


def test_an_arm_holds_no_other_mesh_than_the_one_that_was_meant() -> None:
    def holding(content: bytes) -> Scene:
        held = {"shape": "mesh", "file": "held.stl", "scale": 0.03}
        return Scene.from_dict(
            {
                **load_scene("kitchen-ur5e").to_dict(),
                "obstacles": [],
                "arm": {"model": "urdf", "urdf": "ur5e", "base": [0, 0, 0], "attached": held},
            },
            {"held.stl": content},
        )

    one, other = (holding(meshes.stl(meshes.bumpy(2, seed=seed))) for seed in (0, 1))
    again = TabState.decode(TabState("mine", one).encode(), MeshSource(other.meshes.files))
    assert again.missing == ("held.stl",)
    assert again.scene.arm.attached is None
    same = TabState.decode(TabState("mine", one).encode(), MeshSource(one.meshes.files))
    assert same.scene == one


def test_the_meshes_of_shipped_scenes_are_always_here() -> None:
    state = TabState("sculpture", load_scene("sculpture"))
    assert TabState.decode(state.encode(), SHIPPED) == state


def test_an_archive_is_kept_as_it_is() -> None:
    content = packed({"arm.urdf": arm()})
    (key,) = mesh_store.keys({"arm.zip": content}).values()
    assert mesh_store.find(key) is None
    mesh_store.keep({"arm.zip": content})
    assert mesh_store.find(key) == content


@pytest.mark.parametrize("key", ["", "../secret", "a" * 63, "A" * 64, "a" * 64, "/etc/passwd"])
def test_only_a_hash_finds_a_file(key: str, store: Path) -> None:
    (store.parent / "secret").write_text("no")
    assert mesh_store.find(key) is None


def test_a_file_that_was_changed_is_not_taken(store: Path) -> None:
    surface = next(iter(_scene().meshes.files.values()))
    mesh_store.keep({"a": surface})
    (path,) = store.iterdir()
    with np.load(path) as data:
        arrays = dict(data)
    arrays["vertices"] = 2 * arrays["vertices"]
    with path.open("wb") as file:
        np.savez(file, **arrays)
    assert mesh_store.find(path.name) is None
    path.write_bytes(b"nothing")
    assert mesh_store.find(path.name) is None


def test_the_files_used_longest_ago_go(store: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mesh_store, "MAX_STORED", 25)
    contents = [bytes([k]) * 10 for k in range(4)]
    for content in contents:
        mesh_store.keep({"a": content})
    assert len(list(store.iterdir())) == 2
    kept = mesh_store.find(mesh_store.keys({"a": contents[3]})["a"])
    assert kept == contents[3]


def _disk(monkeypatch: pytest.MonkeyPatch, total: int, others: int, store: Path) -> None:
    """A disk of so many bytes, of which ``others`` are taken by other files."""

    def usage(path: Path) -> shutil._ntuple_diskusage:
        used = others + sum(one.stat().st_size for one in store.iterdir())
        return shutil._ntuple_diskusage(total, used, total - used)

    monkeypatch.setattr(shutil, "disk_usage", usage)


@pytest.mark.parametrize(("total", "others"), [(50, 0), (64, 40)])
def test_a_small_or_a_full_disk_keeps_the_newest_files(
    total: int, others: int, store: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _disk(monkeypatch, total, others, store)
    contents = [bytes([k]) * 10 for k in range(6)]
    for number, content in enumerate(contents):
        mesh_store.keep({"a": content})
        os.utime(store / mesh_store.keys({"a": content})["a"], (number, number))
    assert len(list(store.iterdir())) == 2
    for content in contents[-2:]:
        assert mesh_store.find(mesh_store.keys({"a": content})["a"]) == content

    mesh_store.keep({"a": b"x" * 30})  # what fits nowhere drives nothing out
    assert len(list(store.iterdir())) == 2


def test_a_folder_that_cannot_be_written_stops_nothing(store: Path) -> None:
    store.write_text("a file where the folder should be")
    mesh_store.keep({"a": b"content"})
    assert mesh_store.find(mesh_store.keys({"a": b"content"})["a"]) is None
