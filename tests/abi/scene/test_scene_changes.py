"""A changed scene is the one that its plain data would make, and keeps what is not changed."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel

from abi.errors import SceneError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.primitives import Sphere
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.scene.scene import Scene, load_scene, scene_names
from abi.scene.without_obstacles import without_obstacles
from tests.abi import meshes
from tests.abi.robot.robots import arm, packed

NUMBERS = st.sampled_from([0, 1, 1.0, 2.0, 0.2, True, -1.0, float("nan"), "2", None])
POINTS = st.lists(st.sampled_from([0.0, 3.0, 3, 6.0, 7.0, float("inf")]), min_size=2, max_size=4)
SPHERE = {"shape": "sphere", "radius": 0.5, "position": [1, 1, 1]}
BOX = load_scene("paper").to_dict()["obstacles"][0]
CHANGES = st.fixed_dictionaries(
    {},
    optional={
        "start": POINTS,
        "goal": POINTS,
        "unit": st.sampled_from(["cm", "mm", "ell"]),
        "mesh": st.dictionaries(st.sampled_from(["pitch", "seed", "pich"]), NUMBERS),
        "search": st.dictionaries(st.sampled_from(["taut", "weight"]), NUMBERS),
        "spline": st.dictionaries(st.sampled_from(["degree", "clearance"]), NUMBERS),
        "arm": st.dictionaries(st.sampled_from(["a1", "elbow", "forces"]), NUMBERS | POINTS),
        "obstacles": st.lists(
            st.sampled_from([BOX, SPHERE, {**SPHERE, "radius": -1}, {**BOX, "size": 3}, 5]),
            max_size=3,
        ),
        "version": NUMBERS,
    },
)


LONG = arm(('size="0.1 0.1 0.3"', 'size="0.1 0.1 0.5"'))
SRDF = '<robot name="r"><disable_collisions link1="b" link2="d"/></robot>'
KITCHEN = load_scene("kitchen-ur5e")


def checked_whole(scene: Scene, changes: dict[str, Any], files: Any = None) -> Scene:
    """The changed scene by way of plain data, all of it checked."""
    data = scene.to_dict()
    for name, change in changes.items():
        data[name] = {**data[name], **change} if isinstance(change, dict) else change
    return Scene.from_dict(data, files)


def outcome(make: Callable[[], Scene]) -> Scene | str:
    """The scene made, or the sentence that says why there is none."""
    try:
        return make()
    except SceneError as error:
        return f"{error.field}: {error}"


@pytest.mark.slow
@given(changes=CHANGES)
def test_a_change_makes_what_all_the_plain_data_would_make(changes: dict[str, Any]) -> None:
    scene = load_scene("paper")
    expected = outcome(partial(checked_whole, scene, changes))
    assert outcome(partial(scene.replace, **changes)) == expected


@pytest.mark.parametrize("name", scene_names())
def test_a_scene_told_what_it_holds_is_the_same_object(name: str) -> None:
    scene = load_scene(name)
    assert scene.replace() is scene
    assert scene.replace(**scene.to_dict()) is scene
    assert scene.replace(**dict(scene)) is scene


@pytest.mark.parametrize("name", scene_names())
def test_only_what_is_changed_is_another_object(name: str) -> None:
    scene = load_scene(name)
    data = scene.to_dict()["obstacles"]
    data[-1]["position"][2] += 1e-3
    moved = scene.replace(obstacles=data)
    assert moved.obstacles[-1].position == pytest.approx(data[-1]["position"])
    kept = [a is b for a, b in zip(scene.obstacles, moved.obstacles, strict=True)]
    assert kept == [True] * (len(kept) - 1) + [False]
    for field, value in scene:
        if isinstance(value, BaseModel):
            assert getattr(moved, field) is value


def test_a_mesh_file_with_another_content_is_read_again() -> None:
    small, large = (meshes.stl(meshes.box((size, size, size))) for size in (1.0, 2.0))
    mesh = {"shape": "mesh", "file": "part.stl", "position": [3, 3, 3]}
    data = {"version": 1, "obstacles": [mesh, SPHERE]}
    scene = Scene.from_dict(data, MeshSource({"part.stl": small}))
    files = {"part.stl": large}
    for changes in ({}, {"obstacles": scene.to_dict()["obstacles"]}, {"start": [0, 0, 1]}):
        changed = scene.replace(files, **changes)
        assert changed == checked_whole(scene, changes, MeshSource(files))
        part, sphere = changed.obstacles
        assert isinstance(part, MeshShape)
        assert isinstance(sphere, Sphere)
        np.testing.assert_allclose(np.ptp(part.surface.vertices, axis=0), 2.0)
        assert sphere is scene.obstacles[1]


@pytest.mark.parametrize(
    ("fields", "changed"),
    [
        ({"urdf": "r.zip"}, {"r.zip": packed({"a.urdf": LONG})}),
        ({"urdf": "q.urdf"}, {"q.urdf": LONG.encode()}),
        ({"urdf": "several.zip/one.urdf"}, {"several.zip": packed({"one.urdf": LONG})}),
        ({"urdf": "r.zip", "srdf": "r.srdf"}, {"r.srdf": SRDF.replace('"b"', '"c"').encode()}),
        (
            {"urdf": "r.zip", "attached": {"shape": "mesh", "file": "hält.stl"}},
            {unicodedata.normalize("NFD", "hält.stl"): meshes.stl(meshes.box((2.0, 1.0, 1.0)))},
        ),
    ],
)
def test_what_an_arm_is_read_of_is_read_again_when_it_has_changed(
    fields: dict[str, Any], changed: dict[str, bytes]
) -> None:
    files = {
        "r.zip": packed({"a.urdf": arm()}),
        "q.urdf": arm().encode(),
        "several.zip": packed({"one.urdf": arm(), "two.urdf": arm()}),
        "r.srdf": SRDF.encode(),
        "hält.stl": meshes.stl(meshes.box()),
    }
    data = {
        **{"version": 1, "unit": "m", "workspace": {"min": [-3] * 3, "max": [3] * 3}},
        **{"start": [0, 0, 1], "goal": [0, 0, 1], "arm": {"model": "urdf", **fields}},
    }
    scene = Scene.from_dict(data, MeshSource(files))
    named = {unicodedata.normalize("NFC", name): one for name, one in changed.items()}
    expected = Scene.from_dict(data, MeshSource({**files, **named}))
    assert scene != expected
    for changes in ({}, {"arm": fields}, {"start": [0, 0, 1.5]}, {"arm": {"clearance": 0.5}}):
        found = scene.replace(changed, **changes)
        assert found == checked_whole(expected, changes, expected.meshes)
        assert found.replace(changed, **changes) == found
        assert found.replace(found.meshes.files) is found


def test_a_mesh_counts_in_the_unit_that_the_scene_is_changed_to() -> None:
    mesh = {"shape": "mesh", "file": "part.stl", "unit": "cm", "position": [3, 3, 3]}
    files = MeshSource({"part.stl": meshes.stl(meshes.box())})
    scene = Scene.from_dict({"version": 1, "obstacles": [mesh]}, files)
    changed = scene.replace(unit="mm")
    assert changed == checked_whole(scene, {"unit": "mm"}, files)
    assert changed != scene


@given(
    numbers=st.sets(st.integers(0, 3)),
    asked=st.lists(st.tuples(st.just("forearm_link"), st.integers(0, 3) | st.just("base_link"))),
)
def test_contacts_stay_with_their_obstacles(
    numbers: set[int], asked: list[tuple[str, str | int]]
) -> None:
    scene = KITCHEN.replace(arm={"allowed": asked})
    left = scene.replace(**without_obstacles(scene, numbers))
    kept = [one for number, one in enumerate(scene.obstacles) if number not in numbers]
    assert list(left.obstacles) == kept
    gone = [scene.obstacles[number] for number in numbers]
    contacts = [(link, meant(scene, other)) for link, other in scene.arm.allowed]
    expected = [(link, other) for link, other in contacts if other not in gone]
    assert [(link, meant(left, other)) for link, other in left.arm.allowed] == expected


PICK = load_scene("pick-and-place")


@pytest.mark.parametrize("number", range(len(PICK.obstacles)))
def test_legs_attach_the_same_objects_where_others_are_deleted(number: int) -> None:
    left = PICK.replace(**without_obstacles(PICK, (number,)))
    pairs = zip(PICK.tasks, left.tasks, strict=True)
    holds = False
    for before, after in pairs:
        is_gone = before.attach == number
        if before.attach is not None and not is_gone:
            assert after.attach is not None
            assert left.obstacles[after.attach] == PICK.obstacles[before.attach]
        assert (after.attach is None) == (before.attach is None or is_gone)
        holds = holds or after.attach is not None
        assert after.release == (before.release and holds)
        holds = holds and not after.release
        assert (after.goal, after.name) == (before.goal, before.name)
    assert left.arm.grasping == left.tasks[0].grasps


def test_whether_something_is_taken_follows_from_the_first_leg() -> None:
    legs = [leg.model_dump(mode="json") for leg in PICK.tasks]
    taking = [{**legs[0], "attach": 0}, {**legs[1], "attach": None}, *legs[2:]]
    for before, after in ((legs, taking), (taking, legs)):
        scene = PICK.replace(tasks=before)
        for changed in (
            scene.replace(tasks=after),
            Scene.from_dict({**scene.to_dict(), "tasks": after}),
        ):
            assert changed.arm.grasping == changed.tasks[0].grasps == (after is taking)
            assert changed.replace(arm={"clearance": 0.001}).arm.grasping == (after is taking)


def test_legs_that_begin_in_joints_are_not_sought_on_the_mesh() -> None:
    with pytest.raises(SceneError, match="only the tool's place is kept"):
        PICK.replace(arm={"search": "mesh"})


POINT = [0.3, 0.3, 0.5]


@pytest.mark.parametrize("end", ["start", "goal"])
@pytest.mark.parametrize("beside", [{}, {"arm": {"clearance": 0.001}}])
def test_an_end_that_is_changed_to_a_point_is_that_point(end: str, beside: dict[str, Any]) -> None:
    joints: dict[str, Any] = {"joints": [0.1, -1.2, 1.3, -1.4, -1.5, 0.2]}
    room = {"min": [-0.9, -0.9, 0.0], "max": [0.9, 0.9, 1.2]}
    scene = KITCHEN.replace(workspace=room, arm={"axis": None}, **{end: joints})
    assert getattr(scene.arm, end) is not None
    changes: dict[str, Any] = {end: POINT, **beside}
    changed = scene.replace(**changes)
    assert getattr(changed, end) == tuple(POINT)
    assert getattr(changed.arm, end) is None
    again = changed.replace(**{**changes, end: joints})
    assert getattr(again, end) == getattr(scene, end)
    # a file that says both, and not the same, is no change but a contradiction
    both = scene.to_dict()
    assert Scene.from_dict(both) == scene
    for other in (POINT, {"joints": [0.0, *joints["joints"][1:]]}):
        with pytest.raises(SceneError, match=rf"^(arm\.)?{end} is"):
            Scene.from_dict({**both, end: other})


@pytest.mark.parametrize(
    "said",
    [
        {"goal": POINT},
        {"arm": {"gripper": {"panda_finger_joint1": 0.01}}},
        {"arm": {"axis": {"direction": [0, 0, -1], "tolerance": 0.5}}},
    ],
)
def test_what_a_file_says_of_its_first_leg_twice_is_said_alike(said: dict[str, Any]) -> None:
    data = PICK.to_dict()
    first: dict[str, Any] = {
        "gripper": "closed",
        "axis": {"direction": [0, 0, -1], "tolerance": 0.4},
    }
    first["goal"] = [0.31, 0.3, 0.5]
    name = next(iter(said.get("arm", said)))
    wanted = {name: first[name]}
    arm = {**data["arm"], "gripper": {}, "axis": None, "goal": None}
    legs = [{**data["tasks"][0], **wanted}, *data["tasks"][1:]]
    data = {**data, "tasks": legs, "arm": arm, "goal": None if name == "goal" else data["goal"]}
    data = {key: value for key, value in data.items() if value is not None}
    Scene.from_dict(data)
    both = {**data, **said, "arm": {**arm, **said.get("arm", {})}}
    with pytest.raises(SceneError, match=rf"^tasks\[0\]\.{name} is"):
        Scene.from_dict(both)


def meant(scene: Scene, other: str | int) -> object:
    """The link or obstacle that a contact is with."""
    return other if isinstance(other, str) else scene.obstacles[other]


def test_what_the_first_task_takes_or_sets_down_is_as_its_plain_data_would_have_it() -> None:
    scene = load_scene("pick-and-place")
    tasks = scene.to_dict()["tasks"]
    taken = scene.replace(tasks=tasks[1:5])
    assert taken.arm.grasping
    assert taken.replace(tasks=[taken.tasks[0], *tasks[4:5]]).arm.grasping
    assert taken.replace(obstacles=list(taken.obstacles)).arm.grasping
    for changed in ([{"goal": [0.5, 0, 0.5]}], [{"goal": [0.5, 0, 0.5], "attach": None}]):
        assert not taken.replace(tasks=changed).arm.grasping
        data = taken.to_dict() | {"tasks": changed, "goal": [0.5, 0, 0.5]}
        data["arm"] = data["arm"] | {"goal": None}
        assert not Scene.from_dict(data).arm.grasping
    assert not taken.replace(tasks=[]).arm.grasping
    alone = taken.replace(tasks=[], arm={"grasping": True})
    assert alone.arm.grasping
