from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from abi import Planner, Scene, load_scene, plan, scene_names
from abi.arm import forward
from abi.errors import StageError
from abi.shapes import nearest
from tests.abi.test_scene import obstacles, points

TOP = {
    "mesh": {"lattice", "pitch", "nodes", "tetrahedra", "excluded_nodes", "ms"},
    "graph": {"nodes", "edges", "removed_edges", "ms"},
    "path": {"algorithm", "points", "length"},
    "bspline": {"degree", "control_points", "knots", "length", "clearance", "certified", "ms"},
    "quadratic": {"pieces", "length", "clearance", "certified", "ms"},
    "optimum": {"lower_bound", "ratio"},
    "timing": {"t1", "t2", "t3", "duration", "peak_speed", "theorem_residual"},
    "arm": {
        "joints",
        "time",
        "positions",
        "tool",
        "reachable",
        "clearance",
        "within_limits",
        "ms",
    },
}
SEARCH = {
    "algorithm",
    "weight",
    "vertices",
    "points",
    "length",
    "hops",
    "cost",
    "expanded",
    "relaxed",
    "ms",
}


@pytest.mark.parametrize("name", scene_names())
def test_every_shipped_scene_plans_as_it_says(name: str) -> None:
    made = plan(load_scene(name))
    data = json.loads(json.dumps(made.to_dict(), allow_nan=False))

    if name == "no-way":
        assert made.error is not None
        assert made.error.kind == "no_path"
        assert data["error"]["stage"] == "search"
        assert data["error"]["hint"]
        assert data["graph"]["nodes"] > 0
        assert data["searches"] is data["path"] is data["bspline"] is data["arm"] is None
        return
    assert made.error is None
    for section, fields in TOP.items():
        assert fields <= set(data[section]), section
    assert [search["algorithm"] for search in data["searches"]] == [
        "a_star",
        "dijkstra",
        "bellman_ford",
    ]
    assert all(set(search) == SEARCH for search in data["searches"])
    assert data["arm"]["reachable"]
    assert data["arm"]["joints"] == ["q1", "q2", "q3", "q4", "q5", "q6"]
    assert len(data["arm"]["time"]) <= 200


def test_the_paper_shortens_stage_by_stage() -> None:
    made = plan(load_scene("paper"))
    assert made.bspline_arc is not None
    assert made.quadratic_arc is not None
    assert made.path is not None
    lengths = [result.length for result in made.searches]

    assert max(lengths) - min(lengths) <= 1e-9 * max(lengths)
    assert made.path.length > made.bspline_arc.length > made.quadratic_arc.length
    assert made.quadratic_arc.length > made.lower_bound


@pytest.mark.parametrize("name", ["paper", "two-boxes", "forest"])
def test_forward_kinematics_of_the_plan_meet_its_tool(name: str) -> None:
    made = plan(load_scene(name))
    data = made.to_dict(full=True)
    assert made.arm is not None

    tool = forward(made.arm, np.array(data["arm"]["positions"]))

    np.testing.assert_allclose(tool, data["arm"]["tool"], atol=1e-9)
    np.testing.assert_allclose(data["arm"]["tool"][0], made.scene.start, atol=1e-9)
    np.testing.assert_allclose(data["arm"]["tool"][-1], made.scene.goal, atol=1e-9)


def test_full_adds_the_mesh_and_every_sample() -> None:
    made = plan(load_scene("paper"))
    brief, full = made.to_dict(), made.to_dict(full=True)

    assert len(full["mesh"]["points"]) == full["mesh"]["nodes"]
    assert np.max(full["mesh"]["edges"]) < full["mesh"]["nodes"]
    assert "points" not in brief["mesh"]
    assert len(full["arm"]["time"]) >= len(brief["arm"]["time"])


@pytest.mark.parametrize(
    ("change", "same", "new"),
    [
        (
            {"motion": {"speed": 3.0}},
            ("mesh", "free", "graph", "path", "bspline", "quadratic"),
            ("profile", "motion"),
        ),
        (
            {"spline": {"degree": 3}},
            ("mesh", "free", "graph", "path"),
            ("bspline", "quadratic", "motion"),
        ),
        (
            {"arm": {"elbow": "down"}},
            ("graph", "bspline", "quadratic", "profile"),
            ("arm", "motion"),
        ),
        ({"search": {"algorithm": "dijkstra"}}, ("mesh", "free", "graph"), ("path",)),
        ({"goal": [6.0, 6.0, 5.0]}, ("mesh", "free"), ("graph", "path", "bspline")),
        ({"mesh": {"pitch": 1.0}}, (), ("mesh", "free", "graph", "path")),
    ],
)
def test_only_what_lies_downstream_of_a_change_runs(
    change: dict[str, Any], same: tuple[str, ...], new: tuple[str, ...]
) -> None:
    planner = Planner()
    scene = load_scene("paper")
    before = planner(scene)
    after = planner(scene.replace(**change))

    assert all(getattr(before, name) is getattr(after, name) for name in same)
    assert all(getattr(before, name) is not getattr(after, name) for name in new)


def test_a_planner_gives_what_a_fresh_one_gives() -> None:
    scenes = [load_scene(name) for name in ("paper", "no-way", "thin-plate", "paper")]
    planner = Planner()
    for scene in scenes:
        kept, fresh = planner(scene).to_dict(), plan(scene).to_dict()
        assert _without_times(kept) == _without_times(fresh)


def test_same_start_and_goal_say_so() -> None:
    made = plan(load_scene("paper").replace(goal=[0.0, 0.0, 0.0]))

    assert made.error is not None
    assert made.error.kind == "start_is_goal"


def test_a_blocked_start_names_the_obstacle_and_a_way_out() -> None:
    scene = load_scene("paper").replace(start=[3.0, 3.0, 2.0])
    made = plan(scene)

    assert made.error is not None
    assert made.error.kind == "start_blocked"
    assert "obstacle 1" in made.error.message
    free = getattr(made.error, "nearest", None)
    assert free is not None
    assert nearest(scene.obstacles, free[None])[0][0] >= scene.spline.clearance


def test_out_of_reach_is_said_with_times_and_the_arm_still_has_a_pose() -> None:
    made = plan(load_scene("paper").replace(arm={"base": [3.0, -9.0, 0.0]}))

    assert made.error is not None
    assert made.error.kind == "out_of_reach"
    assert made.motion is not None
    assert not made.motion.reachable
    assert np.isfinite(made.motion.positions).all()


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    start=points,
    goal=points,
    bodies=st.lists(obstacles, max_size=5),
    lattice=st.sampled_from(["bcc", "kuhn", "delaunay"]),
    pitch=st.floats(0.7, 3.0),
    degree=st.integers(2, 5),
    clearance=st.floats(0, 0.5),
    weight=st.sampled_from(["length", "hops"]),
)
def test_any_scene_has_a_plan_or_a_reason(
    start: Any,
    goal: Any,
    bodies: Any,
    lattice: str,
    pitch: float,
    degree: int,
    clearance: float,
    weight: str,
) -> None:
    scene = Scene.from_dict(
        {
            "version": 1,
            "start": start,
            "goal": goal,
            "obstacles": bodies,
            "mesh": {"lattice": lattice, "pitch": pitch},
            "spline": {"degree": degree, "clearance": clearance},
            "search": {"weight": weight},
        }
    )
    made = plan(scene)
    json.dumps(made.to_dict(), allow_nan=False)

    if made.error is not None:
        assert isinstance(made.error, StageError)
        assert made.error.message.endswith(".")
        assert made.error.hint
    if made.path is not None:
        key = "length" if weight == "length" else "hops"
        values = [getattr(result, key) for result in made.searches]
        assert max(values) - min(values) <= 1e-9 * max(values)
    for curve in (made.bspline, made.quadratic):
        if curve is not None and curve.holds and scene.obstacles:
            dense = curve(np.linspace(*curve.interval, 2000))
            assert nearest(scene.obstacles, dense)[0].min() >= clearance - 1e-9
    if made.followed is not None and scene.motion.curve == "auto":
        assert made.followed_curve is not None
        assert made.followed_curve.holds


def _without_times(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _without_times(value) for key, value in data.items() if not key.endswith("ms")}
    return [_without_times(item) for item in data] if isinstance(data, list) else data
