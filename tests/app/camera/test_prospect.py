"""The camera of a shipped scene keeps what one looks at in view while the arm moves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import abi
from abi.obstacles.obstacle_set import ObstacleSet
from abi.scene.scene import load_scene, scene_names
from app.camera.camera import _view
from app.camera.occlusion import hidden
from app.camera.prospect import USUAL, best_direction, in_view
from tests.thorough import of_each_kind

_number = st.floats(-3, 3, allow_nan=False).map(lambda number: round(number, 2))
_point = st.tuples(_number, _number, _number)


@given(_point, _point, _point, _point, st.floats(0.05, 1.0))
def test_an_arm_hides_what_a_solid_of_its_capsule_would(
    eye: tuple[float, float, float],
    point: tuple[float, float, float],
    a: tuple[float, float, float],
    b: tuple[float, float, float],
    radius: float,
) -> None:
    ends = np.array([[[a, b]]], float)
    steps = np.linspace(0, 1, 2001)[:, None]
    way, bone = np.array(b) - a, np.array(eye) + steps * np.subtract(point, eye)
    foot = np.clip((bone - a) @ way / max(float(way @ way), 1e-9), 0, 1)
    away = np.linalg.norm(a + foot[:, None] * way - bone, axis=1).min()
    assume(abs(away - radius) > 0.01)
    found = hidden(np.array([eye], float), np.array([point], float), ends, np.array([radius]), 0.0)
    assert found.tolist() == [[[bool(away < radius)]]]


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    of_each_kind(
        sorted(set(scene_names()) - {"no-way"}),
        *("paper", "wall-with-window", "sculpture", "kitchen-ur5e", "pick-and-place"),
    ),
)
def test_path_ends_and_obstacles_stay_in_view(name: str) -> None:
    plan = abi.plan(load_scene(name))
    assert plan.bspline is not None
    curve = plan.bspline.curve(np.linspace(*plan.bspline.curve.interval, 24))
    _, target, size = _view(plan.scene, 1.0)
    x, y, z = target.tolist()
    seen = [
        in_view(plan, curve, (target + size * direction)[None], size).mean()
        for direction in (best_direction(plan, (x, y, z), size), USUAL)
    ]
    assert seen[0] >= 0.9
    assert seen[0] >= seen[1]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["arm-in-the-way", "find-a-base"])
@pytest.mark.parametrize("factor", [1.0, 1.72])
def test_no_end_is_behind_the_other_nor_the_curve_behind_obstacles(
    name: str, factor: float
) -> None:
    plan = abi.plan(load_scene(name))
    assert plan.bspline is not None
    curve = plan.bspline.curve(np.linspace(*plan.bspline.curve.interval, 24))
    _, target, size = _view(plan.scene, factor)
    x, y, z = target.tolist()
    direction = best_direction(plan, (x, y, z), factor * size)
    way, eye = curve[-1] - curve[0], target + factor * size * direction
    across = np.linalg.norm(np.cross(way, direction)) / np.linalg.norm(direction)
    assert across >= 0.5 * np.linalg.norm(way)
    eyes = np.tile(eye, (len(curve), 1))
    assert ObstacleSet(plan.scene.obstacles).blocked(curve, eyes, 0.0).mean() <= 0.5
