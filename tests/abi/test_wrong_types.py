"""Public functions, given what they do not take."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

import abi
from abi.export.formats import export

SCENE: Any = abi.load_scene("paper")
LOW, HIGH = (0, 0, 0), (1, 1, 0)
MESH = {"version": 1, "obstacles": [{"shape": "mesh", "file": "ball.stl"}]}

CALLS: dict[str, Callable[[Any], object]] = {
    "plan": abi.plan,
    "Planner": lambda wrong: abi.Planner(compile=False)(wrong),
    "load_scene": abi.load_scene,
    "show": abi.show,
    "export": lambda wrong: export(wrong, "motion.csv"),
    "find_base: scene": lambda wrong: abi.find_base(wrong, LOW, HIGH),
    "find_base: low": lambda wrong: abi.find_base(SCENE, wrong, HIGH),
    "find_base: high": lambda wrong: abi.find_base(SCENE, LOW, wrong),
    "find_base: cancelled": lambda wrong: abi.find_base(SCENE, LOW, HIGH, wrong),
    "compile": abi.compile,
    "Scene.from_dict": abi.Scene.from_dict,
    "Scene.from_dict: content": lambda wrong: abi.Scene.from_dict(MESH, {"ball.stl": wrong}),
    "Scene.replace": lambda wrong: SCENE.replace(start=wrong),
    "Scene.replace: obstacles": lambda wrong: SCENE.replace(obstacles=wrong),
    "Scene.save": SCENE.save,
}


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.parametrize("wrong", [-1.5, object(), {3: ()}, [None]])
def test_a_wrong_type_is_refused_in_one_sentence(name: str, wrong: object) -> None:
    with pytest.raises(abi.AbiError) as caught:
        CALLS[name](wrong)
    assert " is " in caught.value.message
    assert "expected" in caught.value.message
    assert "\n" not in caught.value.message


@pytest.mark.parametrize("wrong", [3, "ball.stl", [b""]])
def test_files_that_are_no_mapping_are_refused(wrong: Any) -> None:
    with pytest.raises(abi.SceneError, match="files is"):
        SCENE.replace(files=wrong)


def test_a_mesh_without_its_file_says_how_to_give_it() -> None:
    with pytest.raises(abi.SceneError, match="folder= of Scene"):
        abi.Scene.from_dict(MESH)
