from __future__ import annotations

import json
import re
from typing import Any

import networkx
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy import ndimage

from abi import Scene, load_scene, plan
from abi.arrays import FloatArray
from abi.errors import BLOCKED, NO_PATH
from abi.explain.diagnosis import explain
from abi.explain.nearest_free_point import nearest_free_point, rounded
from abi.explain.reason import Reason
from abi.explain.what_if import MOST_NODES, WhatIf, rounded_down
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.branch import STAGE_NAMES
from abi.planner.plan import Plan
from abi.scene.settings import MeshSettings, Workspace
from abi.tet_mesh import tet_mesh
from abi.tet_mesh import tet_mesh as mesh
from abi.tet_mesh.exclusion import FreeMesh
from tests.abi.scene.test_scene import obstacles, points
from tests.thorough import examples


def is_within(box: Workspace, point: Any) -> bool:
    return bool(np.all(np.array(box.min) <= point) and np.all(point <= np.array(box.max)))


def passes(made: Plan, stage: str) -> bool:
    return made.error is None or STAGE_NAMES.index(made.error.stage) > STAGE_NAMES.index(stage)


def reason_of(scene: Scene) -> tuple[Plan, Reason]:
    made = plan(scene)
    found = explain(scene, made)
    assert found is not None
    for sentence in (found.message, found.hint):
        assert sentence[0].isupper()
        assert sentence.endswith(".")
    assert found.points.shape == (len(found.points), 3)
    json.dumps(found.to_dict(), allow_nan=False)
    return made, found


@st.composite
def walls_with_a_gap(draw: st.DrawFn) -> Scene:
    """Four slabs across the workspace, a window between them; start before and goal behind."""
    y, z = draw(st.floats(1.5, 4.5)), draw(st.floats(1.5, 4.5))
    half = draw(st.floats(0.02, 0.8))
    thick = draw(st.floats(0.1, 0.6))

    def slab(low: tuple[float, float], high: tuple[float, float]) -> dict[str, Any]:
        size = [thick, high[0] - low[0], high[1] - low[1]]
        return {
            "shape": "box",
            "size": size,
            "position": [3.0, (low[0] + high[0]) / 2, (low[1] + high[1]) / 2],
        }

    slabs = [
        slab((-1, -1), (y - half, 7)),
        slab((y + half, -1), (7, 7)),
        slab((y - half, -1), (y + half, z - half)),
        slab((y - half, z + half), (y + half, 7)),
    ]
    return Scene.from_dict(
        {
            "version": 1,
            "start": [draw(st.floats(0, 1.2)), draw(st.floats(0, 6)), draw(st.floats(0, 6))],
            "goal": [draw(st.floats(4.8, 6)), draw(st.floats(0, 6)), draw(st.floats(0, 6))],
            "obstacles": slabs,
            "mesh": {
                "lattice": draw(st.sampled_from(["bcc", "kuhn"])),
                "pitch": draw(st.floats(0.5, 2)),
                "max_nodes": 20_000,
            },
            "spline": {"clearance": draw(st.floats(0.05, 0.9))},
        }
    )


@pytest.mark.slow
@settings(max_examples=8)
@given(walls_with_a_gap())
def test_a_gap_that_is_too_narrow_is_explained_with_what_works(scene: Scene) -> None:
    made = plan(scene)
    assume(made.error is not None and made.error.kind == NO_PATH)
    _, found = reason_of(scene)

    if found.change is None or found.obstacle is not None:
        assert "walled in" in found.message
        what_if = WhatIf(scene)
        pitches = [scene.mesh.pitch, *what_if.finer_pitches()]
        assert not any(what_if.connected(0.0, pitch) for pitch in pitches)
        return
    changed = scene.replace(**found.change)
    assert passes(plan(changed), "search")
    assert len(found.points) == 1
    if "With that" in found.hint:  # and what mends the next error
        return
    lower = found.change.get("spline", {}).get("clearance")
    finer = found.change.get("mesh", {}).get("pitch")
    if finer is not None:
        assert finer < scene.mesh.pitch
        assert changed.mesh.node_count(changed.workspace) <= min(MOST_NODES, scene.mesh.max_nodes)
    if lower is not None:
        assert lower < scene.spline.clearance
        if lower > 0:
            more = changed.replace(spline={"clearance": 1.05 * lower})
            assert not passes(plan(more), "search")
        if finer is None:
            # a finer pitch alone would have been the better advice
            what_if = WhatIf(scene)
            assert not any(
                what_if.connected(scene.spline.clearance, pitch)
                for pitch in what_if.finer_pitches()
            )


@pytest.mark.parametrize(
    ("change", "helps"),
    [
        ({"spline": {"clearance": 0.7}}, {"spline"}),
        ({"mesh": {"pitch": 2.0}}, {"mesh"}),
    ],
)
def test_a_window_says_whether_clearance_or_pitch_is_in_the_way(
    change: dict[str, Any], helps: set[str]
) -> None:
    scene = load_scene("wall-with-window").replace(**change)
    _, found = reason_of(scene)

    assert found.change is not None
    assert set(found.change) == helps
    assert plan(scene.replace(**found.change)).error is None
    assert "(tested)" in found.hint
    # the mark stands in the window
    assert abs(found.points[0][1] - 3) <= 0.3 + 0.7


@pytest.mark.slow
def test_a_gap_too_narrow_for_both_gets_both() -> None:
    walls = [
        {"shape": "box", "size": [0.2, 10, 10], "position": [3.0, y, 3.0]} for y in (-1.96, 8.16)
    ]
    scene = load_scene("paper").replace(
        obstacles=walls, mesh={"pitch": 0.9}, spline={"clearance": 0.2}
    )
    made, found = reason_of(scene)

    assert made.error is not None
    assert made.error.kind == NO_PATH
    assert found.change is not None
    assert set(found.change) == {"mesh", "spline"}
    assert plan(scene.replace(**found.change)).error is None
    assert not passes(plan(scene.replace(mesh=found.change["mesh"])), "search")
    assert not passes(plan(scene.replace(spline=found.change["spline"])), "search")


@pytest.mark.slow
@pytest.mark.parametrize("start", [[0.6, 0.6, 3.0], [0.0, 0.0, 0.0], [0.61, 0.57, 2.93]])
def test_walled_in_agrees_with_networkx_and_with_a_flood(start: list[float]) -> None:
    scene = load_scene("no-way").replace(start=start)
    made, found = reason_of(scene)
    assert made.graph is not None
    assert made.free is not None

    graph = made.graph.to_networkx()
    sides = [
        networkx.node_connected_component(graph, node)
        for node in (made.graph.start, made.graph.goal)
    ]
    assert found.message == "No path: the goal is walled in by obstacles 1–6."
    assert found.obstacle is not None
    assert found.change is not None
    assert passes(plan(scene.replace(**found.change)), "search")
    assert len(found.points) == min(map(len, sides))

    count = 121
    axes = np.linspace(0, 6, count)
    grid = np.stack(np.meshgrid(axes, axes, axes, indexing="ij"), axis=-1).reshape(-1, 3)
    free = (ObstacleSet(scene.obstacles).nearest(grid)[0] > 0).reshape((count,) * 3)
    labels, _ = ndimage.label(free)
    parts = [
        labels[tuple(np.round(np.array(end) / 6 * (count - 1)).astype(int))]
        for end in (scene.start, scene.goal)
    ]
    assert 0 not in parts
    assert parts[0] != parts[1]


def test_no_mesh_of_a_trial_is_made_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[float] = []
    original = mesh.tetrahedralise

    def counted(workspace: Workspace, settings: MeshSettings) -> mesh.TetMesh:
        made.append(settings.pitch)
        return original(workspace, settings)

    scene = load_scene("no-way").replace(mesh={"pitch": 1.5})
    without = plan(scene)
    monkeypatch.setattr(tet_mesh, "tetrahedralise", counted)
    found = explain(scene, without)

    assert found is not None
    assert "walled in" in found.message
    finer = [pitch for pitch in made if pitch != scene.mesh.pitch]
    assert finer == WhatIf(scene).finer_pitches()
    assert len(finer) > 1


def test_no_finer_pitch_is_tried_than_a_scene_may_have() -> None:
    side = [1e-6, 1e-6, 1e-6]
    scene = Scene.from_dict(
        {"version": 1, "workspace": {"max": side}, "goal": side, "mesh": {"pitch": 3e-6}}
    )
    finer = WhatIf(scene).finer_pitches()

    assert finer == [1.5e-6]
    assert scene.replace(mesh={"pitch": finer[-1]}).mesh.pitch == finer[-1]


def test_the_obstacle_that_shuts_the_way_is_named() -> None:
    # a box in a corner and a far sphere; the lid alone can be taken off
    scene = load_scene("no-way")
    more = scene.replace(
        obstacles=[
            {"shape": "sphere", "radius": 0.3, "position": [1.0, 5.0, 1.0]},
            *scene.to_dict()["obstacles"],
        ]
    )
    _, found = reason_of(more)
    assert "obstacles 2–7" in found.message
    assert found.obstacle is not None
    k = found.obstacle
    assert f"Removing obstacle {k + 1} opens a way" in found.hint
    left = [body for number, body in enumerate(more.to_dict()["obstacles"]) if number != k]
    assert found.change == {"obstacles": left}
    assert passes(plan(more.replace(obstacles=left)), "search")


def _sees_a_node(place: FloatArray, free: FreeMesh, scene: Scene) -> bool:
    """Check whether a node that is free is a cell away at most, and nothing between them."""
    nodes = free.mesh.points[~free.excluded]
    near = nodes[np.linalg.norm(nodes - place, axis=1) <= free.mesh.longest_edge]
    here = np.broadcast_to(place, near.shape)
    return not ObstacleSet(scene.obstacles).blocked(here, near, scene.spline.clearance).all()


@pytest.mark.slow
@settings(max_examples=10)
@given(
    start=points,
    goal=points,
    bodies=st.lists(obstacles, min_size=1, max_size=4),
    clearance=st.floats(0, 0.4),
    seed=st.integers(0, 2**32 - 1),
)
def test_a_blocked_end_is_told_the_nearest_free_point(
    start: Any, goal: Any, bodies: Any, clearance: float, seed: int
) -> None:
    scene = Scene.from_dict(
        {
            "version": 1,
            "start": start,
            "goal": goal,
            "obstacles": bodies,
            "spline": {"clearance": clearance},
        }
    )
    made = plan(scene)
    assume(made.error is not None and made.error.kind in BLOCKED)
    _, found = reason_of(scene)
    slack = scene.workspace.slack
    ends = {"start": np.array(scene.start), "goal": np.array(scene.goal)}
    distances, _ = ObstacleSet(scene.obstacles).nearest(np.array(list(ends.values())))
    blocked = {
        which: point
        for (which, point), distance in zip(ends.items(), distances, strict=True)
        if distance < clearance - 1e-9
    }
    for which in blocked:
        assert f"he {which} is " in found.message
    if found.change is not None:
        assert passes(plan(scene.replace(**found.change)), "graph")
    if found.change is None or "spline" in found.change or "With that" in found.hint:
        return
    assert set(found.change) == set(blocked)
    grid = np.random.default_rng(seed).uniform(0, 6, (1000, 3))
    assert made.free is not None
    mesh = made.free.mesh
    # between several obstacles a nearest point is sought from the nodes, to within a cell; what no
    # node sees may be a pocket of its own
    seen = np.array([_sees_a_node(place, made.free, scene) for place in grid])
    known = [(mesh.points, slack), (grid[seen], mesh.longest_edge)]
    for which, point in blocked.items():
        place = np.array(found.change[which])
        assert is_within(scene.workspace, place)
        assert ObstacleSet(scene.obstacles).nearest(place[None])[0][0] >= clearance
        for free, error in known:
            kept = free[ObstacleSet(scene.obstacles).nearest(free)[0] >= clearance + slack]
            away = np.linalg.norm(kept - point, axis=1).min(initial=np.inf)
            assert np.linalg.norm(place - point) <= away + error


@settings(max_examples=examples(20))
@given(body=obstacles, place=points, margin=st.floats(0, 0.5))
def test_next_to_one_obstacle_no_point_is_nearer(body: Any, place: Any, margin: float) -> None:
    scene = Scene.from_dict(
        {
            "version": 1,
            "workspace": {"min": [-40] * 3, "max": [40] * 3},
            "mesh": {"pitch": 20},
            "obstacles": [body],
        }
    )
    point = np.array(place)
    distance = float(ObstacleSet(scene.obstacles).nearest(point[None])[0][0])
    assume(distance < margin)
    none = np.zeros((0, 3))
    found = nearest_free_point(ObstacleSet(scene.obstacles), scene.workspace, point, margin, none)

    assert found is not None
    assert ObstacleSet(scene.obstacles).nearest(found[None])[0][0] >= margin
    # the distance is 1-Lipschitz: no free point can be nearer than what it lacks
    assert np.linalg.norm(found - point) == pytest.approx(margin - distance, abs=1e-6)


@pytest.mark.slow
@settings(max_examples=24)
@given(place=points, error=st.floats(1e-6, 1))
def test_rounding_moves_a_point_by_no_more_than_told(place: Any, error: float) -> None:
    box = load_scene("paper").workspace
    moved = rounded(np.array(place), box, error)

    assert is_within(box, moved)
    assert np.linalg.norm(moved - place) <= error * (1 + 1e-9)


def test_too_near_by_the_clearance_alone_offers_a_clearance_that_works() -> None:
    scene = load_scene("paper").replace(start=[1.2, 3.0, 2.5], spline={"clearance": 0.9})
    made, found = reason_of(scene)
    assert made.error is not None
    assert made.error.kind == "start_blocked"

    told = re.search(r"clearance to ([\d.]+)", found.hint)
    assert told is not None
    lower = float(told[1].rstrip("."))
    assert plan(scene.replace(spline={"clearance": lower})).error is None
    assert not passes(plan(scene.replace(spline={"clearance": 1.1 * lower + 0.01})), "graph")
    assert found.change is not None
    assert plan(scene.replace(**found.change)).error is None


def test_a_change_that_leads_to_the_next_error_is_told_with_what_mends_that_or_is_not_whole() -> (
    None
):
    scene = load_scene("drag-a-box").replace(
        obstacles=[{"shape": "box", "size": [2, 2, 2], "position": [0.6, 0.4, 3.7]}]
    )
    assert plan(scene).error is not None  # the forearm, whatever the clearance
    told = []
    for clearance in (0.97, 1.0):
        _, found = reason_of(scene.replace(spline={"clearance": clearance}))
        assert found.change is not None
        assert "spline" in found.change
        made = plan(scene.replace(spline={"clearance": clearance}).replace(**found.change))
        told.append(made.error is None)
        assert found.is_whole == ("but then" not in found.hint) == told[-1]
    assert told


def test_each_change_that_is_named_gives_a_plan() -> None:
    scene = load_scene("wall-with-window").replace(spline={"clearance": 0.6})
    _, found = reason_of(scene)
    assert found.change is not None
    changes = (found.change, *found.others)
    assert [list(change) for change in changes] == [["mesh"], ["spline"]]
    for change in changes:
        ((_, ((_, number),)),) = ((name, value.items()) for name, value in change.items())
        assert f"{number:g} cm" in found.hint
        assert plan(scene.replace(**change)).error is None


def test_a_start_at_the_clearance_itself_is_told_the_clearance_that_is_held() -> None:
    # A taut path leaves it along the widened ball, where the curve has no room to bend.
    told = 0
    for radius, away, goal, degree in (
        (0.3, [0.18, -0.94, 0.28], [3.2, 3.8, 0.5], 3),
        (0.7, [-0.84, -0.54, -0.06], [1.1, 4.7, 1.6], 2),
    ):
        start = 3.0 + np.array(away) / np.linalg.norm(away) * (radius + 0.1)
        scene = load_scene("paper").replace(
            obstacles=[{"shape": "sphere", "radius": radius, "position": [3.0, 3.0, 3.0]}],
            start=start.tolist(),
            goal=goal,
            spline={"clearance": 0.1, "degree": degree},
            search={"taut": True},
        )
        made = plan(scene)
        if made.error is None:
            continue
        assert made.error.kind == "clearance_not_held"
        told += 1
        _, found = reason_of(scene)
        assert found.change is not None
        assert passes(plan(scene.replace(**found.change)), "bspline")
        lower = found.change["spline"]["clearance"]
        assert lower < 0.1
        assert not passes(plan(scene.replace(spline={"clearance": 1.05 * lower})), "bspline")
    assert told


@pytest.mark.parametrize("model", ["abi", "urdf"])
def test_a_base_that_helps_an_arm_changes_no_elbow_that_it_has_not(model: str) -> None:
    arm: dict[str, Any] = {"urdf": "panda", "search": "mesh", "base": [0.0, 0.0, 0.3]}
    if model == "abi":
        lengths = {"a1": 0.167, "a2": 0.333, "a3": 1.0, "a4": 0.5, "a5": 0.417}
        arm = {"model": "abi", "axis": None, "elbow": "auto", **lengths}
    scene = load_scene("kitchen-ur5e").replace(arm=arm)
    made, found = reason_of(scene)
    assert made.error is not None
    assert made.error.stage == "arm"
    assert found.change is not None
    assert list(found.change["arm"]) == ["base"]
    if model == "abi":  # a change that is told of has been tried
        assert plan(scene.replace(**found.change)).error is None


@pytest.mark.parametrize("name", ["paper", "forest"])
def test_a_plan_needs_no_reason(name: str) -> None:
    scene = load_scene(name)
    assert explain(scene, plan(scene)) is None


def test_other_errors_have_no_reason_but_their_own() -> None:
    for change in ({"goal": [0.0, 0.0, 0.0]}, {"arm": {"base": [3.0, -9.0, 0.0]}}):
        scene = load_scene("paper").replace(**change)
        made = plan(scene)
        assert made.error is not None
        assert explain(scene, made) is None


def test_cancelling_ends_the_trials_at_once() -> None:
    scene = load_scene("no-way")
    made = plan(scene)
    for most in range(4):
        asked = 0

        def cancelled(most: int = most) -> bool:
            nonlocal asked
            asked += 1
            return asked > most

        assert explain(scene, made, cancelled) is None
        assert asked == most + 1


@pytest.mark.slow
@settings(max_examples=32)
@given(asked=st.floats(1e-3, 1e3), part=st.floats(0, 0.999))
def test_the_largest_clearance_works_and_five_per_cent_more_does_not(
    asked: float, part: float
) -> None:
    scene = load_scene("paper").replace(spline={"clearance": asked})
    threshold = part * asked
    found = WhatIf(scene).largest_clearance(lambda value: value <= threshold)

    assert found is not None
    assert found <= threshold
    if found > 0:
        assert 1.05 * found > threshold
        assert float(f"{found:.3g}") == found
    else:
        assert threshold <= 2e-3 * asked
    assert WhatIf(scene).largest_clearance(lambda value: False) is None


@settings(max_examples=examples(33))
@given(st.floats(1e-6, 1e6), st.integers(1, 4))
def test_rounding_down_loses_less_than_a_last_digit(value: float, digits: int) -> None:
    short = rounded_down(value, digits)

    assert short <= value * (1 + 1e-12)
    assert value - short <= 10.0 ** (1 - digits) * value
    assert float(f"{short:.{digits}g}") == short
