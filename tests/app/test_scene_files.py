from __future__ import annotations

import pytest

from abi.scene.scene import scene_names
from app.panels.files import file_stem


@pytest.mark.parametrize("name", scene_names())
def test_a_shipped_scene_is_saved_under_its_name(name: str) -> None:
    assert file_stem(name) == name


@pytest.mark.parametrize(
    ("name", "stem"),
    [
        ("wall.yaml", "wall"),
        ("paper.YML (opened)", "paper"),
        ("/home/someone/my scenes/two pipes.json", "two-pipes"),
        (r"C:\scenes\v1.2.zip", "v1.2"),
        ("Tür & Tor.yaml", "Tür-Tor"),
        ("..", "scene"),
        ("a/b/..yaml", "scene"),
        ("", "scene"),
        ('<>:"|?*', "scene"),
    ],
)
def test_a_file_is_named_after_its_scene(name: str, stem: str) -> None:
    assert file_stem(name) == stem


@pytest.mark.parametrize("name", ["two pipes.yaml", "Tür & Tor.zip (opened)", "..", "v1.2.json"])
def test_a_file_that_is_opened_and_saved_keeps_its_name(name: str) -> None:
    stem = file_stem(name)
    assert file_stem(f"{stem}.zip") == file_stem(f"{stem}.yaml (opened)") == stem
