from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.errors import SceneError
from abi.scene import MeshSettings, Scene, Workspace, load_scene, scene_names
from abi.scene_file import dump, parse_bytes

BOX = {"shape": "box", "size": [1, 1, 1]}

numbers = st.floats(0, 6, allow_nan=False)
points = st.tuples(numbers, numbers, numbers).map(list)
lengths = st.floats(1e-3, 10)
poses = {
    "position": points,
    "wxyz": st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: max(map(abs, q)) > 0.1).map(list),
}
obstacles = st.one_of(
    st.fixed_dictionaries(
        {"shape": st.just("box"), "size": st.tuples(lengths, lengths, lengths).map(list), **poses}
    ),
    st.fixed_dictionaries({"shape": st.just("sphere"), "radius": lengths, **poses}),
    st.fixed_dictionaries(
        {
            "shape": st.sampled_from(["cylinder", "capsule"]),
            "radius": lengths,
            "height": lengths,
            **poses,
        }
    ),
)
scenes = st.fixed_dictionaries(
    {"version": st.just(1), "start": points, "goal": points},
    optional={
        "unit": st.sampled_from(["m", "cm", "mm"]),
        "obstacles": st.lists(obstacles, max_size=4),
        "mesh": st.fixed_dictionaries(
            {"lattice": st.sampled_from(["bcc", "kuhn", "delaunay"]), "pitch": st.floats(0.2, 3)}
        ),
        "spline": st.fixed_dictionaries({"degree": st.integers(2, 5), "clearance": numbers}),
        "arm": st.fixed_dictionaries({"elbow": st.sampled_from(["up", "down"]), "a3": lengths}),
    },
)


@settings(max_examples=100, deadline=None)
@given(scenes, st.sampled_from(["scene.yaml", "scene.json"]))
def test_a_saved_scene_loads_equal_to_itself(data: dict[str, Any], name: str) -> None:
    scene = Scene.from_dict(data)
    text = dump(scene.to_dict(), name)

    loaded = Scene.from_dict(parse_bytes(text.encode(), name))

    assert loaded == scene
    assert hash(loaded) == hash(scene)
    assert loaded.to_dict() == scene.to_dict()


@pytest.mark.parametrize(
    ("change", "field", "words"),
    [
        ({"version": 2}, "version", "2"),
        ({"version": True}, "version", "True"),
        ({"pitch": 2}, "pitch", "mesh"),
        ({"mesh": {"pich": 1}}, "mesh.pich", "did you mean pitch"),
        ({"mesh": {"pitch": -1}}, "mesh.pitch", "greater than 0"),
        ({"mesh": {"pitch": math.nan}}, "mesh.pitch", "finite"),
        ({"mesh": {"pitch": math.inf}}, "mesh.pitch", "finite"),
        ({"mesh": {"pitch": "1"}}, "mesh.pitch", "a number"),
        ({"mesh": {"pitch": True}}, "mesh.pitch", "a number"),
        ({"mesh": {"seed": 1.5}}, "mesh.seed", "a whole number"),
        ({"mesh": []}, "mesh", "a mapping"),
        ({"spline": {"degree": 6}}, "spline.degree", "5"),
        ({"spline": {"clearance": -0.1}}, "spline.clearance", "0"),
        ({"motion": {"speed": 0}}, "motion.speed", "greater"),
        ({"search": {"algorithm": "bfs"}}, "search.algorithm", "dijkstra"),
        ({"arm": {"model": "x.urdf"}}, "arm.model", "abi"),
        ({"start": [0, 0]}, "start[2]", "missing"),
        ({"start": [0, 0, 7]}, "start", "between"),
        ({"goal": "abc"}, "goal", "a list"),
        ({"workspace": {"min": [0, 0, 0], "max": [0, 6, 6]}}, "workspace.max", "above"),
        ({"obstacles": [BOX, {**BOX, "size": [1, 1, 0]}]}, "obstacles[1].size[2]", "greater"),
        ({"obstacles": [{**BOX, "siez": 1}]}, "obstacles[0].siez", "did you mean size"),
        ({"obstacles": [{"shape": "box"}]}, "obstacles[0].size", "missing"),
        ({"obstacles": [{"shape": "blob"}]}, "obstacles[0]", "sphere"),
        ({"obstacles": [{"size": [1, 1, 1]}]}, "obstacles[0]", "shape"),
        ({"obstacles": [{**BOX, "wxyz": [0, 0, 0, 0]}]}, "obstacles[0].wxyz", "rotation"),
    ],
)
def test_what_is_wrong_is_named(change: dict[str, Any], field: str, words: str) -> None:
    with pytest.raises(SceneError) as caught:
        Scene.from_dict({"version": 1, **change})

    assert caught.value.field == field
    assert field in caught.value.message
    assert words in caught.value.message
    assert "\n" not in caught.value.message


@pytest.mark.parametrize("data", [None, 3, "paper", [1], [], {}])
def test_what_is_no_scene_at_all_is_refused(data: object) -> None:
    with pytest.raises(SceneError):
        Scene.from_dict(data)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.yaml", "version: 1\nstart: [0, 0, 0]\nstart: [1, 1, 1]", "duplicate"),
        ("a.json", '{"version": 1, "version": 1}', "twice"),
        ("a.yaml", "a: &x [1]\nb: *x", "anchors"),
        ("a.yaml", "a: !!python/object/apply:os.system [x]", "tags"),
        ("a.yaml", "a: [", "YAML"),
        ("a.json", '{"a": NaN}', "NaN"),
        ("a.json", '{"a": 1', "JSON"),
        ("a.json", "[" * 90_000, "plain"),
        ("a.yaml", "[" * 20_000, "levels"),
        ("a.yaml", "a: " + "9" * 50_000, "plain"),
        ("a.yaml", "#" * 100_001, "100 kB"),
        ("a.yaml", "a: \x00", "YAML"),
    ],
)
def test_hostile_files_get_one_sentence(name: str, text: str, words: str) -> None:
    with pytest.raises(SceneError) as caught:
        parse_bytes(text.encode(), name)

    assert words in caught.value.message
    assert "\n" not in caught.value.message


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    for name in ("none.yaml", "none.txt", "none"):
        with pytest.raises(SceneError, match="none"):
            load_scene(tmp_path / name)


def test_save_and_load_a_file(tmp_path: Path) -> None:
    scene = load_scene("forest")
    for name in ("scene.yaml", "scene.json"):
        scene.save(tmp_path / name)
        assert load_scene(tmp_path / name) == scene
    assert sorted(path.name for path in tmp_path.iterdir()) == ["scene.json", "scene.yaml"]


def test_the_shipped_scenes_are_there() -> None:
    assert scene_names()[0] == "paper"
    assert {"two-boxes", "wall-with-window", "thin-plate", "no-way"} <= set(scene_names())
    assert 180 <= load_scene("paper").mesh.node_count(load_scene("paper").workspace) <= 230


def test_replace_checks_again() -> None:
    scene = load_scene("paper")
    assert scene.replace(spline={"degree": 3}).spline.degree == 3
    assert scene.replace(spline={"degree": 3}).spline.clearance == scene.spline.clearance
    with pytest.raises(SceneError, match=r"spline\.degree"):
        scene.replace(spline={"degree": 1})


@pytest.mark.parametrize("lattice", ["bcc", "kuhn", "delaunay"])
@settings(max_examples=40, deadline=None)
@given(
    size=st.tuples(st.floats(0.1, 50), st.floats(0.1, 50), st.floats(0.1, 50)),
    budget=st.integers(50, 10_000_000),
)
def test_the_finest_pitch_fits_and_little_finer_does_not(
    lattice: Any, size: tuple[float, float, float], budget: int
) -> None:
    workspace = Workspace(min=(0, 0, 0), max=size)
    mesh = MeshSettings(lattice=lattice, max_nodes=budget)
    finest = mesh.finest_pitch(workspace)

    counts = {
        factor: mesh.model_copy(update={"pitch": finest * factor}).node_count(workspace)
        for factor in (1.0, 0.95, 0.9, 0.5)
    }

    assert counts[1.0] <= budget
    assert counts[0.5] > budget or counts[0.5] == counts[1.0]
    assert all(a >= b for b, a in itertools.pairwise(counts.values()))


def test_a_pitch_over_the_budget_is_refused_with_one_that_fits() -> None:
    with pytest.raises(SceneError, match="at least") as caught:
        Scene.from_dict({"version": 1, "mesh": {"pitch": 0.001}})

    assert caught.value.field == "mesh.pitch"
    finest = float(caught.value.expected.split("at least ")[1].split(":")[0])
    Scene.from_dict({"version": 1, "mesh": {"pitch": finest}})
