"""Plans go by what a mesh file says: its unit, its concave polygons, all of its parts."""

from __future__ import annotations

from typing import Any

import pytest

import abi
from abi.errors import SceneError
from tests.abi.obstacles.mesh_files.test_left_out import INCH, controller
from tests.abi.obstacles.mesh_files.test_polygons import DOORWAY, files_of


def planned(name: str, data: bytes, scene_unit: str, **fields: Any) -> abi.Plan:
    """A plan from 4 below the file's plane to 4 above it, through its middle."""
    mesh = {"shape": "mesh", "file": name, **fields}
    scene = {
        "version": 1,
        "unit": scene_unit,
        "workspace": {"min": [-3, -3, -4], "max": [3, 3, 4]},
        "start": [0, 0, -4],
        "goal": [0, 0, 4],
        "obstacles": [mesh],
        "mesh": {"pitch": 1.0},
        "spline": {"clearance": 0.1},
        "arm": {"avoid": False},
    }
    return abi.plan(abi.Scene.from_dict(scene, {name: data}))


def length(plan: abi.Plan) -> float:
    path = plan.to_dict()["bspline"]
    assert path["certified"]
    return float(path["length"])


@pytest.mark.slow
@pytest.mark.parametrize("name", files_of(DOORWAY))
def test_a_way_through_a_doorway_is_straight(name: str) -> None:
    # the door is 1 wide and 2 high, its middle at (1.5, 1)
    plan = planned(name, files_of(DOORWAY)[name], "m", position=[-1.5, -1, 0], unit="m")
    assert length(plan) == pytest.approx(8, rel=1e-3)


@pytest.mark.slow
def test_a_way_past_a_part_in_inches_is_longer_and_says_so() -> None:
    plan = planned("a.3mf", INCH, "cm", position=[-2.3 * 2.54, -0.3 * 2.54, 0])
    assert length(plan) > 8.01
    assert plan.to_dict()["notes"][0] == "a.3mf: Its numbers count in inches, the unit of the file."
    # read in centimetres it is smaller, and beside the way
    small = planned("a.3mf", INCH, "cm", position=[-2.3 * 2.54, -0.3 * 2.54, 0], unit="cm")
    assert length(small) == pytest.approx(8, rel=1e-3)
    assert "The file counts in inches" in small.to_dict()["notes"][0]


def test_a_part_that_hangs_on_a_skeleton_is_no_gap() -> None:
    with pytest.raises(SceneError, match="skin and morph controllers"):
        planned("a.dae", controller("skin"), "m")
