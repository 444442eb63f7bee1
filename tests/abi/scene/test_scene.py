from __future__ import annotations

import errno
import itertools
import math
import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from abi.errors import SceneError
from abi.scene import scene_file
from abi.scene.lattices import LATTICES
from abi.scene.scene import Scene, load_scene, scene_names
from abi.scene.scene_file import dump, parse_bytes, yaml_text
from abi.scene.settings import MeshSettings, Workspace
from tests.thorough import examples

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
            {"lattice": st.sampled_from(list(LATTICES)), "pitch": st.floats(0.2, 3)}
        ),
        "spline": st.fixed_dictionaries({"degree": st.integers(2, 5), "clearance": numbers}),
        "arm": st.fixed_dictionaries({"elbow": st.sampled_from(["up", "down"]), "a3": lengths}),
    },
)


odd_words = st.sampled_from(
    ["on", "n", "1:30", "0o17", "017", "1e3", "~", "=", "<<", "2001-01-01", "a: b", "0?", "a\x85b"]
)
words = odd_words | st.text(max_size=6)
finite = st.floats(allow_nan=False, allow_infinity=False)


@given(st.dictionaries(words, st.lists(words | finite | st.integers() | st.none()), max_size=3))
def test_readers_of_both_versions_of_yaml_find_what_was_written(data: dict[str, Any]) -> None:
    text = yaml_text(data)
    assert parse_bytes(text.encode(), "a.yaml") == data
    assert yaml.safe_load(text) == data


@pytest.mark.slow
@settings(max_examples=40)
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
        ({"mesh": {"pitch": -1}}, "mesh.pitch", "above 0"),
        ({"arm": {"base_wxyz": [0, 1, 0, 0]}}, "arm.base_wxyz", "the paper's arm stands upright"),
        ({"mesh": {"pitch": 0}}, "mesh.pitch", "above 0"),
        ({"mesh": {"pitch": 5e-324}}, "mesh.pitch", "at least 0.000001"),
        ({"mesh": {"pitch": 0.99e-6}}, "mesh.pitch", "at least 0.000001"),
        ({"mesh": {"pitch": 1e-6}}, "mesh.pitch", "at least"),
        ({"mesh": {"pitch": 2e6}}, "mesh.pitch", "at most 1,000,000"),
        ({"mesh": {"pitch": math.nan}}, "mesh.pitch", "finite"),
        ({"mesh": {"pitch": math.inf}}, "mesh.pitch", "finite"),
        ({"mesh": {"pitch": "1"}}, "mesh.pitch", "a number"),
        ({"mesh": {"pitch": True}}, "mesh.pitch", "a number"),
        ({"mesh": {"seed": 1.5}}, "mesh.seed", "a whole number"),
        ({"mesh": []}, "mesh", "the fields lattice"),
        ({"spline": {"degree": 6}}, "spline.degree", "5"),
        ({"spline": {"clearance": -0.1}}, "spline.clearance", "0"),
        ({"motion": {"speed": 0}}, "motion.speed", "above 0"),
        ({"search": {"algorithm": "bfs"}}, "search.algorithm", "dijkstra"),
        ({"arm": {"model": "x.urdf"}}, "arm.model", "abi"),
        ({"start": [0, 0]}, "start[2]", "missing"),
        ({"start": [0, 0, 7]}, "start", "z between 0 and 6 cm"),
        ({"goal": "abc"}, "goal", "a list"),
        ({"workspace": {"min": [0, 0, 0], "max": [0, 6, 6]}}, "workspace.max", "above"),
        ({"obstacles": [BOX, {**BOX, "size": [1, 1, 0]}]}, "obstacles[1].size[2]", "above 0"),
        ({"obstacles": [{**BOX, "siez": 1}]}, "obstacles[0].siez", "did you mean size"),
        ({"obstacles": [{"shape": "box"}]}, "obstacles[0].size", "missing"),
        ({"obstacles": [{**BOX, "shape": "blob"}]}, "obstacles[0].shape", "'blob'; expected box"),
        ({"obstacles": [{"size": [1, 1, 1]}]}, "obstacles[0].shape", "missing; expected box"),
        ({"obstacles": [{"shape": "mesh", "file": ""}]}, "obstacles[0].file", "a name"),
        ({"arm": {"urdf": "mine.urdf"}}, "arm.model", "urdf, to which arm.urdf belongs"),
        (
            {"arm": {"base": [1, 0, 0], "tip": "hand"}},
            "arm.model",
            "urdf, to which arm.tip belongs",
        ),
        ({"arm": {"urdf": ""}}, "arm.urdf", "''; expected a name."),
        ({"arm": {"tip": "t" * 101}}, "arm.tip", "; expected at most 100 characters."),
        ({"version": 2}, "version", "2; expected 1."),
        ({"version": True}, "version", "True; expected 1."),
        ({"workspace": {"min": [1, 0, 0]}}, "start", "missing; expected a point of the workspace"),
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


def test_what_was_done_to_the_data_of_a_file_is_not_read_from_the_next() -> None:
    for _ in range(2):
        data: Any = parse_bytes(b"obstacles: [{size: [1, 2]}]", "a.yaml")
        assert data == {"obstacles": [{"size": [1, 2]}]}
        data["obstacles"][0]["size"].clear()


def test_a_file_without_an_ending_is_no_missing_scene(tmp_path: Path) -> None:
    (tmp_path / "mine").write_text("version: 1")
    for path in (tmp_path / "mine", tmp_path, Path(os.devnull), tmp_path / "mine.txt"):
        with pytest.raises(SceneError, match=r"a file that ends in \.yaml, \.yml, \.json or \.zip"):
            load_scene(path)
    with pytest.raises(SceneError, match="a file or one of paper"):
        load_scene("nosuch")


@pytest.mark.parametrize("data", [None, 3, "paper", [1], [], {}])
def test_what_is_no_scene_at_all_is_refused(data: object) -> None:
    with pytest.raises(SceneError):
        Scene.from_dict(data)


@pytest.mark.parametrize("shape", ["box", "sphere", "cylinder", "capsule"])
def test_what_would_do_for_a_missing_field_does(shape: str) -> None:
    obstacle: dict[str, Any] = {"shape": shape}
    while True:
        try:
            assert Scene.from_dict({"version": 1, "obstacles": [obstacle]}).obstacles
            break
        except SceneError as error:
            text = str(error).removesuffix(".").rpartition("such as ")[2]
        example = parse_bytes(text.encode(), "a.yaml")
        assert isinstance(example, dict)
        assert example.keys().isdisjoint(obstacle)
        obstacle |= example


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.yaml", "version: 1\nstart: [0, 0, 0]\nstart: [1, 1, 1]", "stands there twice"),
        ("a.json", '{"version": 1, "version": 1}', "twice"),
        ("a.yaml", "a: &x [1]\nb: *x", "anchors"),
        ("a.yaml", "a: [1]\n<<: {a: [2]}", "merge keys"),
        ("a.yaml", "a: [1_000]", "1_000"),
        ("a.yaml", "%YAML 1.3\n---\na: 1", "declares 1.3"),
        ("a.yaml", "%YAML 1.1\n---\na: [1:30]", "declares 1.1"),
        ("a.yaml", "a: !!python/object/apply:os.system [x]", "tags"),
        ("a.yaml", "a: [", "YAML"),
        ("a.json", '{"a": NaN}', "NaN"),
        ("a.json", '{"a": 1', "JSON"),
        ("a.json", "[" * 90_000, "plain"),
        ("a.yaml", "[" * 20_000, "levels"),
        ("a.yaml", "a: " + "9" * 50_000, "plain"),
        ("a.yaml", "#" * 400_001, "400 kB"),
        ("a.yaml", "a: \x00", "YAML"),
    ],
    ids=lambda value: value[:12] if isinstance(value, str) else None,
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


@pytest.mark.parametrize("mask", [0o022, 0o077, 0o002])
def test_a_saved_file_has_the_permissions_of_any_other(tmp_path: Path, mask: int) -> None:
    scene, before = load_scene("paper"), os.umask(mask)
    try:
        (tmp_path / "other").touch()
        scene.save(tmp_path / "scene.yaml")
    finally:
        os.umask(before)
    assert (tmp_path / "scene.yaml").stat().st_mode == (tmp_path / "other").stat().st_mode

    for mode in (0o600, 0o644, 0o640):
        (tmp_path / "scene.yaml").chmod(mode)
        scene.replace(goal=[6.0, 6.0, 5.0]).save(tmp_path / "scene.yaml")
        assert (tmp_path / "scene.yaml").stat().st_mode & 0o777 == mode


def test_what_cannot_be_saved_leaves_nothing_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = load_scene("paper")
    (tmp_path / "folder.yaml").mkdir()
    for path in (tmp_path / "folder.yaml", tmp_path / "none" / "scene.yaml"):
        with pytest.raises(SceneError, match="can be written") as caught:
            scene.save(path)
        assert str(path) in caught.value.message
    assert [path.name for path in tmp_path.iterdir()] == ["folder.yaml"]

    scene.save(tmp_path / "scene.yaml")
    content = (tmp_path / "scene.yaml").read_bytes()

    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(SceneError, match="no space left"):
        scene.replace(goal=[6.0, 6.0, 5.0]).save(tmp_path / "scene.yaml")
    assert (tmp_path / "scene.yaml").read_bytes() == content
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder.yaml", "scene.yaml"]


def test_what_could_not_be_read_again_is_not_saved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = load_scene("paper")
    with pytest.raises(SceneError, match="ends in"):
        scene.save(tmp_path / "scene.txt")
    box = {"shape": "box", "size": [0.0123456, 0.0234567, 0.0345678], "position": [1, 1, 1]}
    monkeypatch.setattr(scene_file, "MAX_BYTES", 40_000)
    with pytest.raises(SceneError, match="40 kB"):
        scene.replace(obstacles=400 * [box]).save(tmp_path / "scene.yaml")
    assert list(tmp_path.iterdir()) == []
    scene.replace(obstacles=200 * [box]).save(tmp_path / "scene.yaml")

    scene.replace(obstacles=1_000 * [box]).save(str(tmp_path / "scene.json"))
    assert len(load_scene(tmp_path / "scene.json").obstacles) == 1_000


@pytest.mark.parametrize("name", [300 * "x", 300 * "x" + ".yaml", "a\0b.yaml", "a\0b"])
def test_a_name_that_can_be_no_files_is_refused(name: str) -> None:
    with pytest.raises(SceneError):
        load_scene(name)


@pytest.mark.parametrize(
    "change",
    [{"start": "x"}, {"unit": {"a": 1}}, {"foo": {"a": 1}}, {"mesh": 3}, {"obstacles": {}}],
)
def test_a_change_of_another_kind_names_the_field(change: dict[str, object]) -> None:
    with pytest.raises(SceneError) as caught:
        load_scene("paper").replace(None, **change)
    assert caught.value.field == next(iter(change))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"start": [0, 0, 0, 0]}, "start is [0, 0, 0, 0]; expected a list of 3."),
        ({"obstacles": [5]}, "obstacles[0] is 5; expected a mapping."),
        (
            {"arm": {"attached": 5}},
            "attached is 5; expected a mapping with shape: box, sphere, cylinder, capsule or mesh.",
        ),
        ({"arm": {"attached": {**BOX, "siez": 1}}}, "(did you mean size?)."),
        (
            {"arm": {"attached": {**BOX, "size": [1, 1, 0]}}},
            "arm.attached.size[2] is 0; expected above 0.",
        ),
        ({"mesh": 5}, "mesh is 5; expected the fields lattice, pitch, seed, max_nodes."),
        ({"search": {"taut": "yes"}}, "search.taut is 'yes'; expected true or false."),
        ({"mesh": {"pitch": "1"}}, "mesh.pitch is '1'; expected a number."),
        ({(1, 2): 3}, "expected names of fields as text."),
        *(
            ({"search": {"astar": many}}, "expected a number of fewer digits.")
            for many in (16**5000, [16**5000], {"a": -(16**5000)})
        ),
        (
            {"mesh": {16**5000: 1}},
            "mesh.[key] is a number of thousands of digits; expected names of fields as text.",
        ),
    ],
)
def test_what_would_work_is_said_in_plain_words(change: dict[object, object], words: str) -> None:
    with pytest.raises(SceneError) as caught:
        Scene.from_dict({"version": 1, **change})
    assert caught.value.message.endswith(words)


@pytest.mark.parametrize("ending", ["yaml", "json"])
@pytest.mark.parametrize("level", ["", '{"start": {"joints": ', "[[", '{"goal": [{"a": '])
def test_a_field_that_stands_there_twice_is_named(ending: str, level: str) -> None:
    closing = {"{": "}", "[": "]"}
    ends = "".join(closing[sign] for sign in reversed(level) if sign in closing)
    text = f'{level}{{"x": 1, "unit": "m", "unit": "cm"}}{ends}'
    with pytest.raises(SceneError, match="each field once, unit stands there twice"):
        parse_bytes(text.encode(), f"a.{ending}")


def test_a_mesh_that_is_held_has_the_notes_that_it_has_as_an_obstacle() -> None:
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    text = f"# File units = inches\n{corners}f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\nl 1 2\n"
    mesh = {"shape": "mesh", "file": "part.obj"}
    base = load_scene("paper").replace(arm={"model": "urdf", "urdf": "ur5e"})
    files = {"part.obj": text.encode()}
    told = [
        [note for note in scene.notes if note.startswith("part.obj: ")]
        for scene in (
            base.replace(files=files, obstacles=[mesh]),
            base.replace(files=files, arm={"attached": mesh}),
        )
    ]
    assert told[0] == told[1]
    assert len(told[0]) == 2


OF_ONE_MODEL: dict[str, dict[str, Any]] = {
    "abi": {
        "urdf": "panda",
        "srdf": "a.srdf",
        "tip": "a",
        "base_link": "a",
        "gripper": {"a": 1.0},
        "allowed": [["a", 0]],
        "grasping": True,
    },
    "urdf": {
        **dict.fromkeys(("a1", "a2", "a3", "a4", "a5", "q5"), 1.5),
        **{name: [2, 2, 2] for name in ("forces", "masses", "radii")},
        "elbow": "down",
        "dynamics": "as_printed",
    },
}
OF_BOTH = {"model", "base", "base_wxyz", "avoid", "clearance"}
REFUSED = {"axis", "start", "goal", "search", "attached"}
"""Fields that the paper's arm does not pass over, but refuses."""


@pytest.mark.parametrize("model", OF_ONE_MODEL)
def test_what_is_said_of_the_other_arm_is_told(model: str) -> None:
    others = OF_ONE_MODEL[model]
    usual = Scene.from_dict({"version": 1, "arm": {"model": model}})
    assert not any("Not used, as" in note for note in usual.notes)
    for name, value in others.items():
        told = usual.replace(arm={name: value}).notes
        assert told == (*usual.notes, f"Not used, as arm.model is {model}: arm.{name}.")
    (told_of,) = set(usual.replace(arm=others).notes) - set(usual.notes)
    assert all(f"arm.{name}" in told_of for name in others)
    # whoever adds a field says which arms it is of
    assert OF_BOTH | REFUSED | set().union(*OF_ONE_MODEL.values()) == set(
        type(usual.arm).model_fields
    )


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


@pytest.mark.parametrize("lattice", LATTICES)
@settings(max_examples=40)
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
    finest = float(caught.value.expected.split("at least ")[1].split()[0])
    Scene.from_dict({"version": 1, "mesh": {"pitch": finest}})


@pytest.mark.parametrize("lattice", LATTICES)
@settings(max_examples=examples(20))
@given(
    low=st.floats(-1e6, 0),
    size=st.tuples(*[st.floats(-6, 6).map(lambda power: 10.0**power)] * 3),
    pitch=st.floats(-6, 6).map(lambda power: 10.0**power),
    budget=st.integers(8, 60),
)
def test_what_is_advised_for_too_many_nodes_is_no_longer_refused(
    lattice: str, low: float, size: tuple[float, float, float], pitch: float, budget: int
) -> None:
    high = [min(low + side, 1e6) for side in size]
    assume(min(high) - low >= 1e-6)
    data: dict[str, Any] = {
        "version": 1,
        "workspace": {"min": [low] * 3, "max": high},
        "start": [low] * 3,
        "goal": high,
        "mesh": {"lattice": lattice, "pitch": pitch, "max_nodes": budget},
    }
    try:
        Scene.from_dict(data)
    except SceneError as error:
        told = re.match(r"at least ([\d.e+-]+)", error.expected)
        assert told is not None
        name = error.field.removeprefix("mesh.")
        advised = float(told[1]) if name == "pitch" else int(told[1])
        assert advised > data["mesh"][name]
        data["mesh"][name] = advised
        if name == "max_nodes":
            # it was the budget alone: with it the coarsest mesh is accepted
            data["mesh"]["pitch"] = 1e6
        Scene.from_dict(data)


def test_no_pitch_is_advised_that_is_itself_refused() -> None:
    largest = Workspace(min=(-1e6, -1e6, -1e6), max=(1e6, 1e6, 1e6))
    assert MeshSettings(lattice="kuhn", max_nodes=8).finest_pitch(largest) == 1e6
    assert MeshSettings(lattice="kuhn", max_nodes=27).finest_pitch(largest) < 1e6


@pytest.mark.parametrize("pitch", [1.2, 12.0, 1e6])
def test_a_budget_below_one_cell_is_blamed_itself(pitch: float) -> None:
    with pytest.raises(SceneError) as caught:
        Scene.from_dict({"version": 1, "mesh": {"pitch": pitch, "max_nodes": 8}})

    assert caught.value.field == "mesh.max_nodes"
    assert "at least 9" in caught.value.message


def test_counts_and_truth_values_of_numpy_are_taken_as_plain_ones() -> None:
    scene = Scene(version=1)
    changes: dict[str, Any] = {"spline": {"degree": np.int64(3)}, "mesh": {"seed": np.uint8(7)}}
    changed = scene.replace(**changes, search={"taut": np.bool_(False)})

    assert changed == scene.replace(spline={"degree": 3}, mesh={"seed": 7}, search={"taut": False})
    assert [type(value) for value in (changed.spline.degree, changed.search.taut)] == [int, bool]
    for wrong in (np.float64(3), True, np.bool_(True)):
        with pytest.raises(SceneError, match=r"spline\.degree is .*; expected a whole number"):
            scene.replace(spline={"degree": wrong})
