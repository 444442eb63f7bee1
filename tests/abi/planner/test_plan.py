from __future__ import annotations

import copy
import functools
import json
import math
import pickle
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from abi import Plan, Planner, Scene, load_scene, plan, scene_names
from abi.arrays import FloatArray
from abi.errors import StageError
from abi.obstacles.obstacle_set import ObstacleSet
from abi.robot.paper_arm.paper_arm import JOINTS, PaperArm, forward
from abi.scene.lattices import LATTICES
from abi.tet_mesh.lattice import REGULAR
from tests.abi.scene.test_scene import obstacles, points
from tests.abi.shape_distances import segment_distance
from tests.random_scenes import scattered, slalom
from tests.thorough import of_each_kind

TOP = {
    "mesh": {"lattice", "pitch", "nodes", "tetrahedra", "excluded_nodes", "ms"},
    "graph": {"nodes", "edges", "removed_edges", "ms"},
    "path": {"algorithm", "points", "length"},
    "bspline": {
        "degree",
        "control_points",
        "knots",
        "inserted",
        "moved",
        "length",
        "clearance",
        "certified",
        "certificate",
        "ms",
    },
    "quadratic": {
        "mode",
        "pieces",
        "note",
        "length",
        "clearance",
        "certified",
        "certificate",
        "ms",
    },
    "optimum": {"lower_bound", "exact", "best_known", "ratio"},
    "timing": {
        "curve",
        "t1",
        "t2",
        "t3",
        "duration",
        "peak_speed",
        "theorem_residual",
        "ms",
    },
    "arm": {
        "joints",
        "time",
        "positions",
        "tool",
        "elbow",
        "reachable",
        "clearance",
        "certified",
        "nearest",
        "contacts",
        "certificate",
        "clearance_time",
        "clearance_obstacle",
        "peak_joint_speed",
        "joint_speed_limits",
        "peak_joint_acceleration",
        "joint_acceleration_limits",
        "torques",
        "peak_joint_torque",
        "joint_torque_limits",
        "limits_passed",
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
TAUT = {"points", "length", "clearance", "ms"}


@pytest.mark.slow
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
    if name == "find-a-base":  # from where the arm stands there is no way
        assert made.error is not None
        assert made.error.kind == "arm_not_clear"
        return
    assert made.error is None
    if made.scene.arm.model != "abi":
        assert data["arm"]["certified"]  # the rest: test_urdf_plan
        return
    for section, fields in TOP.items():
        assert fields <= set(data[section]), section
    assert (data["taut"] is not None) == made.scene.search.taut
    assert data["taut"] is None or set(data["taut"]) >= TAUT
    assert [search["algorithm"] for search in data["searches"]] == [
        "a_star",
        "dijkstra",
        "bellman_ford",
    ]
    assert all(set(search) == SEARCH for search in data["searches"])
    assert data["arm"]["reachable"]
    assert data["arm"]["joints"] == ["q1", "q2", "q3", "q4", "q5", "q6"]
    assert 100 < len(data["arm"]["time"]) <= 200
    assert data["arm"]["time"][-1] == data["timing"]["duration"]
    assert np.ptp(np.diff(data["arm"]["time"])) < 1e-12


def _shipped(name: str, **changes: Any) -> Callable[[], Scene]:
    return lambda: load_scene(name).replace(**changes)


def _walls(mode: str) -> Scene:
    """Walls that one quadratic does not get past: three pieces do."""
    return slalom(np.random.default_rng(0)).replace(quadratic={"mode": mode})


def _pushed() -> Scene:
    """A scene whose B-spline has control points pushed away from the obstacles."""
    return scattered(np.random.default_rng(1), 6).replace(
        search={"taut": False}, mesh={"pitch": 0.9}, spline={"degree": 5}
    )


def _from_the_clearance_itself() -> Scene:
    """The taut path leaves along the widened ball, where no curve has room to bend."""
    away = np.array([-0.84, -0.54, -0.06])
    return load_scene("paper").replace(
        obstacles=[{"shape": "sphere", "radius": 0.7, "position": [3.0, 3.0, 3.0]}],
        start=(3.0 + 0.8 * away / np.linalg.norm(away)).tolist(),
        goal=[1.1, 4.7, 1.6],
        spline={"clearance": 0.1, "degree": 2},
        search={"taut": True},
        quadratic={"mode": "pieces"},
        motion={"curve": "bspline"},
    )


VARIANTS: dict[str, tuple[Callable[[], Scene], dict[str, Any]]] = {
    "the paper's": (
        _shipped("paper"),
        {"optimum.exact": True, "timing.curve": "bspline", "arm.within_limits": True},
    ),
    "nothing in the way": (
        _shipped("paper", obstacles=[]),
        {
            "bspline.clearance": None,
            "quadratic.certified": True,
            "quadratic.certificate.margin": None,
            "arm.clearance": None,
        },
    ),
    "past the arm's limits": (
        _shipped("paper", arm={"elbow": "down"}, search={"weight": "hops"}),
        {"arm.within_limits": False, "arm.reachable": True},
    ),
    "out of reach": (
        _shipped("paper", arm={"base": [3.0, -9.0, 0.0]}),
        {"arm.reachable": False, "error.kind": "out_of_reach"},
    ),
    "uneven mesh": (
        _shipped("two-boxes", mesh={"lattice": "delaunay"}, search={"algorithm": "dijkstra"}),
        {"path.algorithm": "dijkstra", "optimum.exact": False, "quadratic.certificate": None},
    ),
    "in pieces": (
        lambda: _walls("pieces"),
        {"quadratic.note": None, "quadratic.certified": True, "timing.curve": "quadratic"},
    ),
    "not in one piece": (
        lambda: _walls("clear"),
        {
            "quadratic.certified": False,
            "quadratic.note": "No single quadratic with these ends was found that keeps the "
            "clearance; mode pieces joins several.",
        },
    ),
    "cuts in": (
        _shipped("forest", motion={"curve": "quadratic"}),
        {
            "quadratic.certified": False,
            "quadratic.certificate": None,
            "quadratic.note": None,
            "optimum.ratio": None,
            "timing.curve": "quadratic",
        },
    ),
    "nearer than asked": (
        _shipped("paper", spline={"clearance": 0.6}, motion={"curve": "quadratic"}),
        {"quadratic.certified": False, "optimum.ratio": None, "timing.curve": "quadratic"},
    ),
    "path alone": (
        _from_the_clearance_itself,
        {
            "bspline.certified": False,
            "quadratic.certified": False,
            "optimum.ratio": None,
            "optimum.exact": True,
            "quadratic.note": "No quadratic pieces were found that keep the clearance: the "
            "B-spline does not.",
        },
    ),
    "pushed": (_pushed, {"bspline.moved": 4, "bspline.certified": True}),
    "triangles": (_shipped("sculpture"), {"quadratic.certified": False}),
}
variants = pytest.mark.parametrize("variant", VARIANTS)


@functools.cache
def told(variant: str) -> tuple[Plan, dict[str, Any]]:
    """The plan of a variant, for its tool alone, and what its JSON says."""
    made = plan(VARIANTS[variant][0]().replace(arm={"avoid": False}))
    return made, json.loads(json.dumps(made.to_dict(full=True), allow_nan=False))


def away(made: Plan, places: FloatArray) -> FloatArray:
    return (
        ObstacleSet(made.scene.obstacles)
        .nearest(places.reshape(-1, 3))[0]
        .reshape(places.shape[:-1])
    )


def along(places: Any) -> float:
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())


def drawn(name: str, section: dict[str, Any]) -> FloatArray:
    """Points (n, 3) of a curve, from what the JSON says of it and nothing else."""
    if name == "bspline":
        knots = section["knots"]
        curve = BSpline(knots, section["control_points"], section["degree"])
        return np.asarray(curve(np.linspace(knots[0], knots[-1], 8001)))
    parts = []
    for piece in section["pieces"]:
        t = np.linspace(piece["t0"], piece["t1"], 4001)[:, None]
        c0, c1, c2 = np.array(piece["coefficients"])
        parts.append(c0 + c1 * t + c2 * t * t)
    return np.concatenate(parts)


@pytest.mark.slow
@variants
def test_the_json_says_what_the_variant_is(variant: str) -> None:
    made, data = told(variant)

    for place, value in VARIANTS[variant][1].items():
        found = data
        for part in place.split("."):
            found = found[part]
        assert found == value, place
    assert Scene.from_dict(data["scene"], made.scene.meshes) == made.scene
    assert (data["error"] is None) == (made.error is None) == data["arm"]["reachable"]
    for name in ("mesh", "graph", "bspline", "quadratic", "timing", "arm"):
        assert data[name]["ms"] == made.ms[name], name
    assert data["total_ms"] == made.total_ms > 0


@pytest.mark.slow
@variants
def test_the_json_counts_the_nodes_and_edges_that_are_left(variant: str) -> None:
    made, data = told(variant)
    scene, mesh = made.scene, data["mesh"]
    places, edges = np.array(mesh["points"]), np.array(mesh["edges"])
    margin = scene.spline.clearance + scene.workspace.slack
    gone = away(made, places) < margin
    shut = gone[edges].any(axis=1)
    for obstacle in scene.obstacles:
        shut |= segment_distance(obstacle, places[edges[:, 0]], places[edges[:, 1]]) < margin
    ends = np.array([scene.start, scene.goal])
    own = [end for end in ends if not (places[~gone] == end).all(axis=1).any()]
    assert made.mesh is not None
    assert made.graph is not None

    assert mesh["lattice"] == scene.mesh.lattice
    lengths = np.linalg.norm(np.diff(places[edges], axis=1), axis=2)
    cells = np.divide(scene.workspace.size, scene.mesh.cells(scene.workspace))
    shortest = lengths.min() if mesh["lattice"] in REGULAR else cells.min()
    assert mesh["pitch"] == pytest.approx(shortest)
    assert mesh["nodes"] == len(places)
    assert mesh["excluded"] == np.flatnonzero(gone).tolist()
    assert mesh["excluded_nodes"] == gone.sum()
    assert mesh["tetrahedra"] == (~gone[made.mesh.tetrahedra].any(axis=1)).sum()
    graph = data["graph"]
    assert graph["nodes"] == (~gone).sum() + len(own)
    assert graph["removed_edges"] == shut.sum()
    assert graph["edges"] == (~shut).sum() + len(made.graph.tails) == len(made.graph.edges)


@pytest.mark.slow
@variants
def test_the_json_measures_the_ways_it_tells(variant: str) -> None:
    made, data = told(variant)
    ends = [list(made.scene.start), list(made.scene.goal)]
    places = np.array(data["mesh"]["points"])

    for found, result in zip(data["searches"], made.searches, strict=True):
        assert found["algorithm"] == result.algorithm
        assert found["weight"] == made.scene.search.weight
        vertices, way = np.array(found["vertices"]), np.array(found["points"])
        of_mesh = vertices < len(places)
        np.testing.assert_array_equal(way[of_mesh], places[vertices[of_mesh]])
        assert way[[0, -1]].tolist() == ends
        assert found["length"] == pytest.approx(along(way), rel=1e-12)
        assert found["hops"] == len(vertices) - 1 == len(way) - 1
        assert found["cost"] == pytest.approx(found[found["weight"]], rel=1e-12)
        assert found["expanded"] == len(result.order)
        assert found["relaxed"] == result.relaxed > found["expanded"]
        assert found["ms"] == made.ms[found["algorithm"]]
    chosen = {found["algorithm"]: found for found in data["searches"]}
    best = chosen[made.scene.search.algorithm]
    assert data["path"] == {key: best[key] for key in ("algorithm", "points", "length")}
    string = data["taut"]
    if string is not None:
        way = np.array(string["points"])
        assert way[[0, -1]].tolist() == ends
        assert string["length"] == pytest.approx(along(way), rel=1e-12)
        shares = np.linspace(0, 1, 2001)[:, None, None]
        least = away(made, way[:-1] + shares * np.diff(way, axis=0)).min()
        assert least - 5e-3 <= string["clearance"] <= least + 1e-9
        assert string["ms"] == made.ms["taut"]


@variants
@pytest.mark.parametrize("name", ["bspline", "quadratic"])
def test_the_json_measures_the_curves_it_tells(variant: str, name: str) -> None:
    made, data = told(variant)
    section = data[name]
    curve = getattr(made, name)
    places = drawn(name, section)
    asked = made.scene.spline.clearance

    np.testing.assert_allclose(places[[0, -1]], [made.scene.start, made.scene.goal], atol=1e-9)
    assert section["length"] == pytest.approx(along(places), rel=1e-5)
    proof = section["certificate"]
    assert (proof is None) == (curve.clearance.certificate is None)
    if proof is not None:
        assert proof["margin"] == section["clearance"]
        assert len(proof["planes"]) == len(curve.clearance.certificate.pieces)
    if made.scene.obstacles:
        least = float(away(made, places).min())
        assert least - 0.02 <= section["clearance"] <= least + 1e-9
        assert abs(least - asked) <= 1e-9 or section["certified"] == (least > asked)
        assert section["certified"] == (proof is not None and proof["margin"] >= asked - 1e-9)
    else:
        assert section["clearance"] is None
        assert section["certified"]
    if name == "quadratic":
        assert section["mode"] == made.scene.quadratic.mode
        assert section["note"] == (curve.note or None)
        assert (len(section["pieces"]) > 1) == (variant == "in pieces")
        return
    way = np.array((data["taut"] or data["path"])["points"])
    spline = curve.curve
    assert section["degree"] == spline.degree <= made.scene.spline.degree
    assert section["inserted"] == spline.inserted == len(section["control_points"]) - len(way)
    assert section["moved"] == spline.moved


@variants
def test_the_json_sets_the_lengths_beside_the_bound(variant: str) -> None:
    made, data = told(variant)
    found, followed = data["optimum"], data[data["timing"]["curve"]]
    kept = [along(data["path"]["points"])]
    if data["taut"] is not None:
        kept.append(along(data["taut"]["points"]))
    for name in ("bspline", "quadratic"):
        if data[name]["certified"]:
            kept.append(along(drawn(name, data[name])))
    assert made.optimum is not None

    assert data["timing"]["curve"] == made.followed
    assert found["best_known"] == pytest.approx(min(kept), rel=1e-5)
    straight = math.dist(made.scene.start, made.scene.goal)
    assert straight * (1 - 1e-14) <= found["lower_bound"]
    assert found["lower_bound"] == made.optimum.length <= min(kept) * (1 + 1e-12)
    assert found["exact"] == made.optimum.exact
    if followed["certified"]:
        assert found["ratio"] == pytest.approx(followed["length"] / found["lower_bound"], rel=1e-12)
    else:
        assert found["ratio"] is None


@pytest.mark.slow
@variants
def test_the_json_tells_the_motion_along_the_curve(variant: str) -> None:
    made, data = told(variant)
    asked, found, arm = made.scene.motion, data["timing"], data["arm"]
    t1, t2, t3, peak = (found[key] for key in ("t1", "t2", "t3", "peak_speed"))
    assert isinstance(made.arm, PaperArm)

    assert found["duration"] == pytest.approx(t1 + t2 + t3, rel=1e-12) == arm["time"][-1]
    length = data[found["curve"]]["length"]
    assert peak * (t1 / 2 + t2 + t3 / 2) == pytest.approx(length, rel=1e-9)
    assert asked.acceleration * t1 == pytest.approx(peak) == asked.deceleration * t3
    assert peak <= asked.speed
    assert found["theorem_residual"] == pytest.approx(0, abs=1e-9)

    positions, tool = np.array(arm["positions"]), np.array(arm["tool"])
    time = arm["time"]
    np.testing.assert_allclose(np.diff(time), found["duration"] / (len(time) - 1), rtol=1e-9)
    np.testing.assert_allclose(tool, forward(made.arm, positions), atol=1e-9)
    # on the curve at every sample, between two of those drawn, unless it is out of reach
    way = drawn(found["curve"], data[found["curve"]])
    off = max(float(np.linalg.norm(way - at, axis=1).min()) for at in tool[::10])
    assert arm["reachable"] == (off < 0.05)
    low, high = made.arm.limits.T
    inside = (positions >= low - 1e-6) & (positions <= high + 1e-6)
    assert arm["within_limits"] == inside.all()
    passed = {JOINTS.index(one["joint"]): one for one in arm["limits_passed"]}
    assert set(passed) == set(np.flatnonzero(~inside.all(axis=0)))
    for joint, one in passed.items():
        first = int((~inside[:, joint]).argmax())
        assert one["since"] <= time[first] + 1e-9
        assert one["limit"] in made.arm.limits[joint]
        beyond = np.maximum(low[joint] - positions[:, joint], positions[:, joint] - high[joint])
        assert abs(one["value"] - one["limit"]) >= beyond.max() - 1e-9
    speeds = np.abs(np.diff(positions, axis=0)).max(axis=0) / (time[1] - time[0])
    assert (speeds <= np.array(arm["peak_joint_speed"]) * (1 + 1e-9)).all()
    assert arm["torques"] is arm["peak_joint_torque"] is None  # the paper gives no masses
    assert arm["joint_torque_limits"] == [None] * 6
    assert arm["joint_speed_limits"] == [math.pi] * 3 + [None] * 3
    if not made.scene.obstacles:
        assert arm["clearance"] is arm["clearance_obstacle"] is arm["clearance_time"] is None
        return
    assert 0 <= arm["clearance_obstacle"] < len(made.scene.obstacles)
    assert 0 <= arm["clearance_time"] <= time[-1]
    ends = made.arm.place(positions)
    shares = np.linspace(0, 1, 60)[:, None, None, None]
    links = ends[:, :, 0] + shares * (ends[:, :, 1] - ends[:, :, 0])
    radii = np.array([capsule.radius for capsule in made.arm.capsules])
    least = float((away(made, links) - radii).min())
    assert arm["clearance"] <= least + 1e-9
    assert arm["certificate"] is not None or arm["clearance"] >= least - 0.06


@pytest.mark.parametrize("name", ["paper", "wall-with-window", "sculpture"])
def test_the_json_has_the_clearance_of_the_arm_at_every_time(name: str) -> None:
    made = plan(load_scene(name))
    assert isinstance(made.arm, PaperArm)
    for full in (False, True):
        arm = json.loads(json.dumps(made.to_dict(full=full), allow_nan=False))["arm"]
        found = np.array(arm["clearances"])
        assert found.shape == (len(arm["time"]),)
        ends = made.arm.place(np.array(arm["positions"])[::20])
        shares = np.linspace(0, 1, 200)[:, None, None, None]
        links = ends[:, :, 0] + shares * (ends[:, :, 1] - ends[:, :, 0])
        radii = np.array([capsule.radius for capsule in made.arm.capsules])
        sampled = (away(made, links) - radii).min(axis=(0, 2))
        spacing = float(np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2).max()) / 199
        assert (found[::20] <= sampled + 1e-9).all()
        assert (found[::20] >= sampled - spacing).all()
        assert arm["clearance"] <= found.min() + 1e-9


def test_the_json_has_no_clearances_without_obstacles() -> None:
    assert plan(load_scene("paper").replace(obstacles=[])).to_dict()["arm"]["clearances"] is None


def test_the_paper_shortens_stage_by_stage() -> None:
    made = plan(load_scene("paper"))
    assert made.bspline_arc is not None
    assert made.quadratic_arc is not None
    assert made.path is not None
    lengths = [result.length for result in made.searches]

    assert max(lengths) - min(lengths) <= 1e-9 * max(lengths)
    assert made.path.length > made.bspline_arc.length > made.quadratic_arc.length
    assert made.quadratic_arc.length > made.straight_length


@pytest.mark.parametrize("name", ["paper", "two-boxes", "forest"])
def test_forward_kinematics_of_the_plan_meet_its_tool(name: str) -> None:
    made = plan(load_scene(name))
    data = made.to_dict(full=True)
    assert isinstance(made.arm, PaperArm)

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
    [named] = re.findall(r"nearest free point is \(([^)]*)\)", made.error.hint)
    free = np.array([named.replace("−", "-").split(",")], dtype=float)  # of two digits
    assert ObstacleSet(scene.obstacles).nearest(free)[0][0] >= scene.spline.clearance - 0.01


def test_out_of_reach_is_said_with_times_and_the_arm_still_has_a_pose() -> None:
    made = plan(load_scene("paper").replace(arm={"base": [3.0, -9.0, 0.0]}))

    assert made.error is not None
    assert made.error.kind == "out_of_reach"
    assert made.motion is not None
    assert not made.motion.reachable
    assert np.isfinite(made.motion.positions).all()


@pytest.mark.slow
@settings(max_examples=24)
@given(
    start=points,
    goal=points,
    bodies=st.lists(obstacles, max_size=5),
    lattice=st.sampled_from(list(LATTICES)),
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
    for fit in (made.bspline, made.quadratic):
        if fit is not None and fit.holds and scene.obstacles:
            dense = fit.curve(np.linspace(*fit.curve.interval, 2000))
            assert ObstacleSet(scene.obstacles).nearest(dense)[0].min() >= clearance - 1e-9
    if made.followed is not None and scene.motion.curve == "auto":
        assert made.followed_curve is not None
        assert made.followed_curve.holds


def _without_times(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _without_times(value) for key, value in data.items() if not key.endswith("ms")}
    return [_without_times(item) for item in data] if isinstance(data, list) else data


def arrays_of(value: object) -> Iterator[FloatArray]:
    """Every array that an object holds, however deep."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, tuple | list):
        for one in value:
            yield from arrays_of(one)
    elif isinstance(value, Mapping):
        yield from arrays_of(list(value.values()))
    elif type(value).__module__.startswith("abi."):
        private = getattr(value, "__pydantic_private__", None)
        yield from arrays_of([*vars(value).values(), private])


def sent(result: Plan) -> Plan:
    """The plan, sent through pickle."""
    received: Plan = pickle.loads(pickle.dumps(result))
    return received


@pytest.mark.parametrize("send", [sent, copy.deepcopy])
@pytest.mark.parametrize(
    "name", of_each_kind(scene_names(), "arm-in-the-way", "no-way", "sculpture", "kitchen-ur5e")
)
def test_a_plan_that_is_sent_or_copied_is_the_same(name: str, send: Callable[[Plan], Plan]) -> None:
    result = plan(load_scene(name).replace(arm={"elbow": "down"}))
    again = send(result)

    assert again.to_dict(full=True) == result.to_dict(full=True)
    assert (again.scene, hash(again.scene)) == (result.scene, hash(result.scene))
    assert plan(again.scene).lengths == result.lengths
    assert not any(array.flags.writeable for array in arrays_of(again))


def distances(timing: dict[str, Any], length: float, time: FloatArray) -> FloatArray:
    """Distance travelled at each time, as docs/scene-and-plan.md says."""
    v, t1, t2, t3 = (timing[name] for name in ("peak_speed", "t1", "t2", "t3"))
    last = length - v * (timing["duration"] - time) ** 2 / (2 * t3)
    cruise = np.where(time <= t1 + t2, v * (time - t1 / 2), last)
    return np.asarray(np.where(time <= t1, v * time**2 / (2 * t1), cruise))


@pytest.mark.parametrize("law", ["three_phase", "slowed"])
@pytest.mark.parametrize("name", ["paper", "thin-plate", "kitchen-ur5e"])
def test_the_tool_follows_from_the_json_alone(name: str, law: str) -> None:
    data = json.loads(json.dumps(plan(load_scene(name).replace(motion={"law": law})).to_dict()))
    spline, arm = data["bspline"], data["arm"]
    assert data["timing"]["curve"] == "bspline"
    curve = BSpline(spline["knots"], np.array(spline["control_points"]), spline["degree"])
    grid = np.linspace(0, 1, 200_001)
    steps = np.linalg.norm(np.diff(curve(grid), axis=0), axis=1)
    travelled = np.concatenate([[0], np.cumsum(steps)])
    assert travelled[-1] == pytest.approx(spline["length"], rel=1e-8)

    asked = distances(data["timing"], spline["length"], np.array(arm["time"]))
    found = curve(np.interp(asked, travelled, grid))
    size = np.ptp(found, axis=0).max()
    assert np.abs(found - arm["tool"]).max() < 1e-7 * size
