"""Scenes from numpy's poses and trimesh's meshes, beside the same in plain data."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from abi.errors import SceneError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.pose import rotation
from abi.scene.scene import Scene

WHOLE = {"version": 1, "workspace": {"min": [-9] * 3, "max": [9] * 3}, "mesh": {"pitch": 6.0}}


def pose_of(position: tuple[float, float, float], turn: tuple[float, float, float]) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.from_rotvec(turn).as_matrix(), position
    return pose


def test_a_pose_is_the_goal_and_stands_an_obstacle_where_it_says() -> None:
    pose = pose_of((1.0, 2.0, 0.5), (0.3, -1.2, 2.0))
    arm = {"model": "urdf", "urdf": "ur5e", "base": np.zeros(3)}
    box = {"shape": "box", "size": np.array([1, 2, 3.0]), "pose": pose}

    made = Scene.from_dict(
        WHOLE
        | {"unit": "m", "start": np.array([0, 0, 1.0]), "goal": pose, "arm": arm}
        | {"obstacles": [box]}
    )

    end, placed = made.arm.goal, made.obstacles[0]
    assert end is not None
    assert end.wxyz is not None
    assert made.goal == placed.position == (1.0, 2.0, 0.5)
    for wxyz in (end.wxyz, placed.wxyz):
        np.testing.assert_allclose(rotation(wxyz), pose[:3, :3], atol=1e-15)
    assert Scene.from_dict(made.to_dict()) == made
    assert made.replace(goal=pose) == made


def test_a_mesh_of_trimesh_is_an_obstacle_where_it_stands_in_its_own_unit() -> None:
    ball = trimesh.creation.icosphere(subdivisions=2, radius=10.0)
    ball.apply_translation([5.0, 20.0, 30.0])
    ball.units = "mm"
    made = Scene.from_dict(WHOLE | {"obstacles": [ball]})
    (shape,) = made.obstacles

    assert isinstance(shape, MeshShape)
    np.testing.assert_allclose(shape.bounds(), ball.bounds / 10, atol=1e-12)
    assert made.replace(obstacles=[ball]) == made
    assert made.replace(obstacles=[ball, *made.obstacles]).obstacles == (shape, shape)


@pytest.mark.parametrize(
    "start",
    [
        np.array([1, 2, 3j]),
        np.array([1, 2, 3], "timedelta64[ns]"),
        np.array([1, 2, 3], "datetime64[ns]"),
        np.ma.array([1.0, 2, 3], mask=[False, True, False]),
        [np.timedelta64(1), 2, 3],
    ],
)
def test_numbers_that_would_be_read_otherwise_are_refused(start: object) -> None:
    with pytest.raises(SceneError, match="real numbers"):
        Scene.from_dict(WHOLE | {"start": start})


@pytest.mark.parametrize("start", [{6, 5, 0}, frozenset((6, 5, 0)), {6: 1, 5: 1, 0: 1}.keys()])
def test_a_point_is_no_set_which_has_no_order(start: object) -> None:
    with pytest.raises(SceneError, match=r"start .* a list"):
        Scene.from_dict(WHOLE | {"start": start})


class Place(NamedTuple):
    x: float
    y: float
    z: float


def test_a_named_tuple_is_a_tuple() -> None:
    box = {"shape": "box", "size": Place(1, 1, 2)}
    made = Scene.from_dict(WHOLE | {"start": Place(1, 2, 3), "obstacles": (box,)})
    assert made.start == (1, 2, 3)
    assert made.obstacles[0].size == (1, 1, 2)  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "changed",
    [
        {"vertices": np.eye(3) + 1j},
        {"vertices": np.ma.array(np.eye(3), mask=np.eye(3) > 0)},
        {"faces": np.ma.array([[0, 1, 2]], mask=[[False, False, True]])},
        {"faces": np.array([[0, 1, 2, 2]])},
        {"faces": np.array([[0.0, 1, 2]])},
        {"faces": np.array([[0, 1, -1]])},
    ],
)
def test_a_mesh_of_other_numbers_is_refused_by_its_field(changed: dict[str, np.ndarray]) -> None:
    mesh = SimpleNamespace(**{"vertices": np.eye(3), "faces": np.array([[0, 1, 2]])} | changed)
    with pytest.raises(SceneError) as refusal:
        Scene.from_dict(WHOLE | {"obstacles": [mesh]})
    assert refusal.value.field == f"obstacles[0].{next(iter(changed))}"


@pytest.mark.parametrize(
    "wrong",
    [
        2 * np.eye(4),
        np.diag([1.0, 1, -1, 1]),
        np.full((4, 4), math.nan),
        np.vstack([np.eye(4)[:3], [[0, 0, 1, 1]]]),
    ],
)
def test_what_is_no_pose_is_refused_by_its_field(wrong: np.ndarray) -> None:
    with pytest.raises(SceneError) as refusal:
        Scene.from_dict(WHOLE | {"goal": wrong})

    assert refusal.value.field == "goal"


@pytest.mark.parametrize("section", ["obstacles", "workspace", "mesh", "arm"])
def test_a_pose_of_plain_data_changes_no_field_beside_it(section: str) -> None:
    box = {"shape": "box", "size": [1, 1, 1], "pose": {"position": [3, 3, 3], "size": [2, 2, 2]}}
    fields = {
        "obstacles": [box],
        "workspace": {"min": [-9] * 3, "max": [9] * 3, "pose": {"max": [5, 5, 5]}},
        "mesh": {"pitch": 6.0, "pose": {"pitch": 3.0}},
        "arm": {"pose": {"base": [1, 0, 0]}},
    }
    with pytest.raises(SceneError) as refusal:
        Scene.from_dict(WHOLE | {section: fields[section]})
    assert refusal.value.field.endswith("pose")


@pytest.mark.parametrize("beside", [{"position": [1, 2, 3]}, {"wxyz": [1, 0, 0, 0]}])
def test_an_obstacle_stands_at_one_place(beside: dict[str, list[int]]) -> None:
    box = {"shape": "box", "size": [1, 1, 1], "pose": np.eye(4), **beside}
    with pytest.raises(SceneError, match=f"no {next(iter(beside))} beside a pose"):
        Scene.from_dict(WHOLE | {"obstacles": [box]})
