from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from abi.errors import AbiError, SceneError
from abi.scene.scene import load_scene
from abi_sweep.random_boxes import random_boxes
from abi_sweep.study import Study, load_study, plan_key, varied
from abi_sweep.task import tasks

SHIPPED = Path(__file__).parents[2] / "examples" / "studies" / "lattices.yaml"


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"version": 2}, "version"),
        ({"version": True}, "version"),
        ({"version": 1.0}, "version"),
        ({"scenes": ["paper", "nosuch"]}, "scenes[1]"),
        ({"scenes": ["missing.yaml"]}, "scenes[0]"),
        ({"scenes": []}, "scenes"),
        ({"scenes": [3]}, "scenes[0]"),
        ({"scenes": ["paper", {"boxes": 4, "seed": 3}]}, "scenes[1].seed"),
        ({"scenes": [{"boxes": 0}]}, "scenes[0].boxes"),
        ({"scenes": [{"boxes": True}]}, "scenes[0].boxes"),
        ({"scenes": [{"boxes": 4, "seeds": 300_000}]}, "scenes[0].seeds"),
        ({"vary": ["mesh.pitch"]}, "vary"),
        ({"vary": {"mesh.pitch": 1.2}}, "vary.mesh.pitch"),
        ({"vary": {"mesh.pitch": []}}, "vary.mesh.pitch"),
        ({"vary": {"workspace": [{}]}}, "vary.workspace"),
        ({"vary": {"mesh.seed": list(range(1000)), "arm.q5": list(range(1000))}}, "vary"),
        ({"pitch": [1.2]}, "pitch"),
    ],
)
def test_what_is_wrong_is_named(change: dict[str, Any], field: str) -> None:
    with pytest.raises(SceneError) as caught:
        Study.from_dict({"version": 1, "scenes": ["paper"], **change})
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("vary", "words"),
    [
        ({"mesh.pitch": [1.2, -1]}, "mesh.pitch is -1"),
        ({"mesh.pich": [1.2]}, "did you mean pitch"),
        ({"start": [[0, 0, 99]]}, "start is"),
    ],
)
def test_a_setting_that_does_not_fit_is_told_before_anything_is_planned(
    vary: dict[str, Any], words: str
) -> None:
    study = Study.from_dict({"version": 1, "scenes": ["paper"], "vary": vary})
    with pytest.raises(AbiError, match=words):
        tasks(study, lambda key: False)


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"study is .*missing\.yaml"):
        load_study(tmp_path / "missing.yaml")


def test_scenes_beside_the_study_are_found(tmp_path: Path) -> None:
    load_scene("two-boxes").save(tmp_path / "mine.yaml")
    (tmp_path / "study.yaml").write_text("version: 1\nscenes: [mine.yaml]\n")
    study = load_study(tmp_path / "study.yaml")
    assert study.scene(*study.scenes[0]) == load_scene("two-boxes")


def test_a_scene_with_a_wrong_field_is_named(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("version: 1\nmesh: {pitch: -1}\n")
    study = Study.from_dict({"version": 1, "scenes": ["paper", "mine.yaml"]}, tmp_path)
    with pytest.raises(AbiError, match=r"mine\.yaml cannot be planned: mesh\.pitch is -1"):
        tasks(study, lambda key: False)


def test_random_scenes_are_the_same_for_the_same_seed_alone() -> None:
    assert random_boxes(3) == random_boxes(3)
    assert random_boxes(3) != random_boxes(4)
    assert len(random_boxes(3, 5).obstacles) == 5


def test_every_scene_meets_every_combination_once() -> None:
    study = Study.from_dict(
        {
            "version": 1,
            "scenes": ["paper", {"boxes": 2, "seeds": 3, "first": 5}],
            "vary": {"mesh.pitch": [1.2, 0.9], "search.taut": [True, False]},
        }
    )
    heads, found = tasks(study, lambda key: False)
    columns = ("scene", "seed", "mesh.pitch", "search.taut")
    rows = [tuple(head[name] for name in columns) for head in heads]
    assert len(set(rows)) == len(rows) == study.size == 16
    assert {seed for _, seed, *_ in rows} == {None, 5, 6, 7}
    planned = [key for task in found for key, _ in task.plans]
    assert sorted(planned) == sorted({head["key"] for head in heads})


def test_a_key_tells_plans_apart_and_nothing_else() -> None:
    scene = load_scene("sculpture")
    again = varied(varied(scene, {"mesh.pitch": 0.9}), {"mesh.pitch": scene.mesh.pitch})
    assert plan_key(again) == plan_key(scene)
    assert plan_key(varied(scene, {"mesh.seed": 1})) != plan_key(scene)


def test_the_shipped_study_has_ten_thousand_plans() -> None:
    study = load_study(SHIPPED)
    assert study.size >= 10_000
    for settings in study.settings():
        varied(study.scene(*study.scenes[0]), settings)
