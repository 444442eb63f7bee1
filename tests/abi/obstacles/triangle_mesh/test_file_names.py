"""Files under names in another normal form of Unicode than the one that asks for them."""

from __future__ import annotations

import json
import unicodedata
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.file_names import same_name
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.urdf.robot_files import load_robot
from abi.scene.scene import Scene, load_scene
from abi.scene.scene_archive import SUFFIX
from tests.abi import meshes
from tests.abi.robot.robots import arm, packed

_FORMS = ("NFC", "NFD")
_NAMES = ("Bücher/Tür.stl", "한글.stl", "Å.stl", "x/naïve.stl")
_CUBE = meshes.stl(meshes.box())


@pytest.mark.parametrize("name", _NAMES)
@pytest.mark.parametrize("asked", _FORMS)
@pytest.mark.parametrize("there", _FORMS)
def test_a_scene_finds_its_mesh_in_either_form(
    name: str, asked: str, there: str, tmp_path: Path
) -> None:
    asked, there = unicodedata.normalize(asked, name), unicodedata.normalize(there, name)  # type: ignore[arg-type]
    data = {"version": 1, "obstacles": [{"shape": "mesh", "file": asked, "position": [3, 3, 3]}]}
    file = tmp_path / there
    file.parent.mkdir(exist_ok=True)
    file.write_bytes(_CUBE)
    scene = Scene.from_dict(data, tmp_path)
    assert Scene.from_dict(data, {there: _CUBE}) == scene
    path = tmp_path / f"scene{SUFFIX}"
    path.write_bytes(packed({"scene.json": json.dumps(data), there: _CUBE}))
    assert load_scene(path) == scene

    text = arm(('<box size="0.1 0.1 0.3"/>', f'<mesh filename="package://x/{asked}"/>'))
    archive = packed({"x/a.urdf": text.encode(), f"x/{there}": _CUBE})
    assert load_robot("a.zip", MeshSource({"a.zip": archive})).links


def test_of_two_files_that_read_the_same_the_one_named_is_taken(tmp_path: Path) -> None:
    for form, size in zip(_FORMS, (1.0, 2.0), strict=True):
        name = unicodedata.normalize(form, "ü.stl")  # type: ignore[arg-type]
        (tmp_path / name).write_bytes(meshes.stl(meshes.box((size, 1.0, 1.0))))
        assert MeshSource(folder=tmp_path).content(name) == (tmp_path / name).read_bytes()
    assert len({one.read_bytes() for one in tmp_path.iterdir()}) == len(list(tmp_path.iterdir()))


def test_a_name_that_only_looks_alike_is_not_taken(tmp_path: Path) -> None:
    (tmp_path / "u.stl").write_bytes(_CUBE)
    with pytest.raises(SceneError, match="no such file"):
        MeshSource(folder=tmp_path).content("ü.stl")
    (tmp_path / "link.stl").symlink_to(Path(__file__))
    with pytest.raises(SceneError, match="not a link out of it"):
        MeshSource(folder=tmp_path).content("link.stl")


@settings(max_examples=40)
@given(st.lists(st.text(max_size=8), max_size=6), st.text(max_size=8))
def test_the_name_itself_goes_first_and_several_that_read_the_same_are_none(
    names: list[str], name: str
) -> None:
    found = same_name(name, names)
    normal = unicodedata.normalize("NFC", name)
    same = [one for one in names if unicodedata.normalize("NFC", one) == normal]
    if name in names:
        assert found == name
    elif len(same) == 1:
        assert found == same[0]
    else:
        assert found is None
