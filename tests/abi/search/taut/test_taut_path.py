from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from abi.arrays import FloatArray
from abi.errors import StageError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacles, ObstacleSet
from abi.obstacles.primitives import Box
from abi.obstacles.triangle_mesh.repair import clean
from abi.obstacles.triangle_mesh.surface import Surface
from abi.planner.planner import plan
from abi.scene.lattices import LATTICES
from abi.scene.scene import Scene, load_scene
from abi.search.build_graph import build_graph
from abi.search.graph import Graph
from abi.search.search import SearchResult, search
from abi.search.taut import taut_path as stage
from abi.search.taut.geodesic_kernels import around_ball
from abi.search.taut.lower_bound import lower_bound
from abi.search.taut.taut_path import TautPath, taut
from abi.search.taut.theta_star_kernels import any_angle
from abi.tet_mesh import tet_mesh as mesh
from abi.tet_mesh.exclusion import exclude
from abi.tet_mesh.lattice import REGULAR
from abi_sweep.random_boxes import CLEARANCE
from tests.abi.scene.test_scene import obstacles, points
from tests.abi.shape_distances import segment_distance
from tests.kernel_forms import kernels_as
from tests.random_scenes import box_scene

CUBE = {"shape": "box", "size": [3, 3, 3], "position": [3, 3, 3]}


def made(scene: Scene, margin: float, clearance: float) -> tuple[Graph, SearchResult]:
    free = exclude(
        mesh.tetrahedralise(scene.workspace, scene.mesh), ObstacleSet(scene.obstacles), margin
    )
    nodes = build_graph(
        free, ObstacleSet(scene.obstacles), margin, scene.start, scene.goal, clearance
    )
    return nodes, search("a_star", nodes, "length")


def pulled(scene: Scene, margin: float) -> TautPath:
    nodes, path = made(scene, margin, margin)
    return taut(nodes, ObstacleSet(scene.obstacles), margin, path)


def scene_of(bodies: list[Any], **fields: Any) -> Scene:
    mesh_fields = {"lattice": fields.pop("lattice", "bcc"), "pitch": fields.pop("pitch", 1.0)}
    return Scene.from_dict({"version": 1, "obstacles": bodies, "mesh": mesh_fields, **fields})


def round_cube(clearance: float) -> float:
    """Shortest way from corner to corner past a vertical edge of the cube, rounded: a helix."""
    x, y = 4.5, 1.5
    away = math.hypot(x, y)
    before = math.atan2(y, x) - math.asin(clearance / away)
    level = 2 * math.sqrt(away**2 - clearance**2) + clearance * (math.pi / 2 - 2 * before)
    return math.hypot(level, 6)


def keeps(found: TautPath, path: SearchResult, solids: Obstacles, margin: float) -> bool:
    """Each segment keeps the margin or the distance of an end of the path that it has."""
    p, q = found.points[:-1], found.points[1:]
    asked = np.full(len(p), margin)
    for solid in solids:
        own = solid.signed_distance(found.points[[0, -1]])
        asked[0] = min(asked[0], own[0])
        asked[-1] = min(asked[-1], own[1])
    return all((segment_distance(solid, p, q) >= asked - 2e-9).all() for solid in solids)


@pytest.mark.slow
@settings(max_examples=12, suppress_health_check=list(HealthCheck))
@given(
    bodies=st.lists(obstacles, min_size=1, max_size=6),
    start=points,
    goal=points,
    pitch=st.floats(0.6, 2),
    lattice=st.sampled_from(list(LATTICES)),
    clearance=st.sampled_from([0.0, 0.1, 0.3]),
    slack=st.sampled_from([0.0, 0.006, 0.1]),
)
def test_taut_is_shorter_and_clear_and_the_same_again(
    bodies: list[Any],
    start: list[float],
    goal: list[float],
    pitch: float,
    lattice: str,
    clearance: float,
    slack: float,
) -> None:
    scene = scene_of(bodies, start=start, goal=goal, pitch=pitch, lattice=lattice)
    try:
        nodes, path = made(scene, clearance + slack, clearance)
    except StageError:
        assume(False)
    found = taut(nodes, ObstacleSet(scene.obstacles), clearance + slack, path)

    assert found.length <= path.length
    assert keeps(found, path, scene.obstacles, clearance + slack)
    np.testing.assert_array_equal(found.points[[0, -1]], path.points[[0, -1]])
    lengths = np.linalg.norm(np.diff(found.points, axis=0), axis=1)
    assert found.length == pytest.approx(lengths.sum(), rel=1e-12)
    assert found.clearance == ObstacleSet(scene.obstacles).polyline_clearance(found.points)
    assert (found.points >= -1e-9).all()
    assert (found.points <= 6 + 1e-9).all()
    again = taut(nodes, ObstacleSet(scene.obstacles), clearance + slack, path)
    np.testing.assert_array_equal(found.points, again.points)


@pytest.mark.parametrize("clearance", [0.02, 0.2])
@pytest.mark.parametrize(("lattice", "pitch"), [("bcc", 1.3), ("kuhn", 1.2), ("bcc", 0.6)])
@pytest.mark.parametrize("ends", [([0, 0, 0], [6, 6, 6]), ([6, 0, 0], [0, 6, 6])])
def test_past_a_cube_it_is_the_helix(
    clearance: float, lattice: str, pitch: float, ends: tuple[list[float], list[float]]
) -> None:
    scene = scene_of([CUBE], start=ends[0], goal=ends[1], pitch=pitch, lattice=lattice)

    found = pulled(scene, clearance)

    assert round_cube(clearance) * (1 - 1e-9) <= found.length <= round_cube(clearance) * 1.001
    if clearance == 0.2:
        assert round_cube(clearance) == pytest.approx(11.389313, abs=1e-6)
        assert found.length < 11.450764  # the optimum for the cube widened with sharp edges


@settings(max_examples=25)
@given(
    radius=st.floats(0.3, 2),
    centre=st.tuples(*[st.floats(2.2, 3.8)] * 3),
    clearance=st.floats(0, 0.3),
)
def test_past_a_ball_it_is_two_tangents_and_an_arc(
    radius: float, centre: tuple[float, float, float], clearance: float
) -> None:
    scene = scene_of([{"shape": "sphere", "radius": radius, "position": list(centre)}])
    start, goal = ((np.array(end) - centre).tolist() for end in (scene.start, scene.goal))
    shortest = around_ball(radius + clearance, tuple(start), tuple(goal))

    found = pulled(scene, clearance)

    # nearly opposite each other, all ways round are about as short, and the string slides slowly
    opposite = np.dot(start, goal) < -0.99 * math.hypot(*start) * math.hypot(*goal)
    assert shortest * (1 - 1e-9) <= found.length <= shortest * (1.02 if opposite else 1.002)


@settings(max_examples=25, suppress_health_check=list(HealthCheck))
@given(body=obstacles, start=points, goal=points)
def test_past_one_obstacle_it_is_the_optimum_where_that_is_known(
    body: Any, start: list[float], goal: list[float]
) -> None:
    scene = scene_of([body], start=start, goal=goal, pitch=0.8)
    optimum = lower_bound(
        scene.start, scene.goal, ObstacleSet(scene.obstacles), 0.05, scene.workspace
    )
    try:
        found = pulled(scene, 0.05)
    except StageError:
        assume(False)

    assert found.length >= optimum.length * (1 - 1e-8)
    if optimum.exact:
        # on the wrong side it would be longer by far more
        assert found.length <= optimum.length * 1.05


@pytest.mark.parametrize("seed", range(4))
def test_mirrored_and_turned_round_it_is_as_long(seed: int) -> None:
    random = np.random.default_rng(seed)
    centres, sizes = random.uniform(1.2, 4.8, (5, 3)), random.uniform(0.5, 1.5, (5, 3))
    lengths = []
    for flip in ([1, 1, 1], [-1, 1, 1], [1, -1, -1]):
        turned = 3 + (centres - 3) * flip
        bodies = [
            {"shape": "box", "size": size.tolist(), "position": centre.tolist()}
            for size, centre in zip(sizes, turned, strict=True)
        ]
        ends = [(3 + sign * 3 * np.array(flip)).tolist() for sign in (-1.0, 1.0)]
        for start, goal in (ends, ends[::-1]):
            lengths.append(pulled(scene_of(bodies, start=start, goal=goal, pitch=0.7), 0.1).length)

    assert max(lengths) <= min(lengths) * 1.003


def test_where_nothing_is_in_the_way_it_is_straight() -> None:
    found = pulled(scene_of([], start=[0.5, 1, 0], goal=[5, 4.7, 6]), 0.2)

    assert len(found.points) == 2
    assert found.length == pytest.approx(math.dist([0.5, 1, 0], [5, 4.7, 6]), rel=1e-14)
    assert found.clearance == math.inf


def test_a_coarse_mesh_does_not_send_it_the_long_way_round() -> None:
    scene = load_scene("thin-plate")
    margin = scene.spline.clearance
    optimum = lower_bound(
        scene.start, scene.goal, ObstacleSet(scene.obstacles), margin, scene.workspace
    )

    nodes, path = made(scene, margin, margin)
    found = taut(nodes, ObstacleSet(scene.obstacles), margin, path)

    assert optimum.exact
    assert path.length > 1.1 * optimum.length
    assert found.length <= 1.001 * optimum.length


def test_start_and_goal_may_stand_nearer_than_the_margin() -> None:
    start, goal = [1.45, 2.0, 3.0], [4.55, 4.0, 3.0]  # 0.05 beside the cube
    scene = scene_of([CUBE], start=start, goal=goal, pitch=0.7)
    nodes, path = made(scene, 0.1, 0.05)

    found = taut(nodes, ObstacleSet(scene.obstacles), 0.1, path)

    assert found.clearance == pytest.approx(0.05, abs=2e-9)
    assert keeps(found, path, scene.obstacles, 0.1)
    inner = found.points[1:-1]
    assert ObstacleSet(scene.obstacles).polyline_clearance(inner) >= 0.1 - 1e-9
    assert found.length < 0.95 * path.length


def test_compiled_and_plain_give_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = scene_of(
        [
            {"shape": "box", "size": [2, 1, 3], "position": [2, 2, 3], "wxyz": [1, 0.2, 0.1, 0.4]},
            {"shape": "cylinder", "radius": 0.8, "height": 3, "position": [4, 4, 3]},
            {"shape": "capsule", "radius": 0.5, "height": 2, "position": [4, 3, 5]},
            {"shape": "sphere", "radius": 0.6, "position": [3.2, 2.8, 1.2]},
        ],
        start=[0.5, 0.5, 3],
        goal=[5.5, 5.5, 3],
        pitch=0.8,
    )
    nodes, path = made(scene, 0.1, 0.1)
    with kernels_as(compiled=True):
        compiled = taut(nodes, ObstacleSet(scene.obstacles), 0.1, path)
    with kernels_as(compiled=False):
        plain = taut(nodes, ObstacleSet(scene.obstacles), 0.1, path)

    np.testing.assert_allclose(compiled.points, plain.points, atol=1e-12)


def with_and_without_any_angle(
    scene: Scene, margin: float, monkeypatch: pytest.MonkeyPatch
) -> tuple[float, float]:
    nodes, path = made(scene, margin, CLEARANCE)
    whole = taut(nodes, ObstacleSet(scene.obstacles), margin, path).length
    with monkeypatch.context() as patch:
        patch.setattr(stage, "_any_angle_path", lambda *_: np.empty((0, 3)))
        return whole, taut(nodes, ObstacleSet(scene.obstacles), margin, path).length


def test_the_path_for_any_angle_finds_a_shorter_way_round(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = box_scene(59, 0.25)
    margin = CLEARANCE + scene.workspace.slack

    whole, without = with_and_without_any_angle(scene, margin, monkeypatch)

    assert whole < 10.856
    assert without > 10.866


@pytest.mark.parametrize("seed", [28, 40])
def test_the_path_for_any_angle_hides_no_way_nearly_as_short(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = box_scene(seed, 0.5)
    margin = CLEARANCE + scene.workspace.slack

    whole, without = with_and_without_any_angle(scene, margin, monkeypatch)

    assert whole <= without * (1 + 1e-5)


@pytest.mark.parametrize("lattice", LATTICES)
def test_how_many_nodes_are_searched_for_any_angle_is_bounded(
    lattice: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = scene_of([CUBE], pitch=0.6, lattice=lattice)
    nodes, path = made(scene, 0.1, 0.1)
    count = len(nodes.mesh.points)
    strides = []

    def recorded(*arguments: Any) -> Any:
        strides.append(arguments[2])
        return any_angle(*arguments)

    monkeypatch.setattr(stage, "any_angle", recorded)
    monkeypatch.setattr(stage, "_SEARCHED_NODES", count // 8)
    for most in (count, count - 1):
        monkeypatch.setattr(stage, "_MOST_NODES", most)
        found = taut(nodes, ObstacleSet(scene.obstacles), 0.1, path)
        assert found.length < path.length

    # every second node along each axis; where that has no meaning all of them, or none
    assert strides == ([2, 2] if lattice in REGULAR else [1])


def test_a_mesh_is_passed_as_the_box_that_it_is() -> None:
    box = Box(size=(3, 2, 2.5), position=(3, 3, 3))
    shape = MeshShape.of(_cuboid(box.size), position=box.position)
    scene = scene_of([box.model_dump()], pitch=0.8)
    margin = 0.15
    free = exclude(mesh.tetrahedralise(scene.workspace, scene.mesh), ObstacleSet((shape,)), margin)
    nodes = build_graph(free, ObstacleSet((shape,)), margin, scene.start, scene.goal, margin)
    path = search("a_star", nodes, "length")

    found = taut(nodes, ObstacleSet((shape,)), margin, path)

    assert keeps(found, path, (shape,), margin)
    assert keeps(found, path, (box,), margin)
    assert found.length <= 1.01 * pulled(scene, margin).length


def test_plans_go_on_with_the_taut_path() -> None:
    on = plan(load_scene("two-boxes"))
    off = plan(load_scene("two-boxes").replace(search={"taut": False}))

    assert off.taut is None
    assert on.taut is not None
    assert on.path is not None
    assert on.bspline is not None
    assert on.bspline_arc is not None
    assert off.bspline_arc is not None
    assert on.taut.length < on.path.length
    assert on.bspline.holds
    assert on.bspline_arc.length <= on.taut.length
    assert on.bspline_arc.length < 0.97 * off.bspline_arc.length
    assert on.to_dict()["taut"]["length"] == on.taut.length
    assert off.to_dict()["taut"] is None


def _cuboid(size: tuple[float, float, float]) -> Surface:
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    squares = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [face for a, b, c, d in squares for face in ((a, b, c), (a, c, d))]
    half: FloatArray = np.array(size) / 2
    return clean(corners * half, np.array(faces, dtype=np.int32))
