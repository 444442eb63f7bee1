from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st

from abi.arrays import FloatArray, flat, read_only
from abi.curves.clearance.certificate import Certificate, certify
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.obstacles.packing import pack
from abi.obstacles.primitives import Box, Capsule, Cylinder, Primitive, Sphere
from abi.obstacles.triangle_mesh.repair import clean
from abi.planner.planner import Planner
from abi.scene.scene import Scene
from abi.scene.settings import Workspace
from abi.search.taut.geodesic_kernels import around_ball, solid_bounds
from abi.search.taut.lower_bound import Bound, lower_bound
from abi.search.taut.obstacle_edges import obstacle_edges
from abi.search.taut.taut_kernels import taut_paths
from abi.search.taut.tighten_kernels import FreeSpace
from tests.abi import meshes
from tests.abi.bezier import polyline
from tests.abi.scene.test_scene import obstacles, points
from tests.thorough import examples

CLEARANCE = 0.1
PLANNER = Planner()
ROOMY = Workspace(min=(-50.0, -50.0, -50.0), max=(50.0, 50.0, 50.0))


def scene_of(bodies: list[dict[str, Any]], start: list[float], goal: list[float]) -> Scene:
    return Scene.from_dict({"version": 1, "obstacles": bodies, "start": start, "goal": goal})


def _tightened(path: FloatArray, solids: tuple[Primitive, ...]) -> float:
    """Length of the path and of short ones by the obstacles' edges, tightened repeatedly."""
    x, y, z = (path[-1] - path[0]).tolist()
    edges = obstacle_edges(solids, CLEARANCE, (x, y, z))
    limits = read_only(np.full(4 * len(solids), CLEARANCE))
    space = FreeSpace(pack(solids), limits, (-20.0, -20.0, -20.0), (20.0, 20.0, 20.0))
    length = math.inf
    pull: Any = taut_paths
    for _ in range(20):
        begins = read_only(np.array([0, len(path)], dtype=np.int32))
        found, begins, lengths = pull(flat(path), begins, edges, space, 21, 30, 1.0, 10**9)
        best = int(np.argmin(lengths))
        path = found[begins[best] : begins[best + 1]]
        if lengths[best] > (1 - 1e-5) * length:
            break
        length = float(lengths[best])
    return float(lengths[best])


@pytest.mark.slow
@settings(max_examples=24, suppress_health_check=list(HealthCheck))
@example(
    body={"shape": "sphere", "radius": 0.5, "position": [0.0, 0.75, 0.75], "wxyz": [0, 0, 0, 1]},
    start=[0.0, 0.0, 1.0],
    goal=[1.0, 3.0, 0.0],
)
@given(body=obstacles, start=points, goal=points)
def test_an_exact_bound_is_the_length_of_the_shortest_way_by_many_places(
    body: dict[str, Any], start: list[float], goal: list[float]
) -> None:
    scene = scene_of([body], start, goal)
    room = Workspace(min=(-20.0, -20.0, -20.0), max=(20.0, 20.0, 20.0))
    solids = tuple(solid for solid in scene.obstacles if not isinstance(solid, MeshShape))
    ends = np.array([start, goal])
    assume(math.dist(start, goal) > 0.1)
    assume(min(float(solid.signed_distance(ends).min()) for solid in solids) > CLEARANCE + 0.01)

    bound = lower_bound(scene.start, scene.goal, ObstacleSet(solids), CLEARANCE, room)

    # a way far round to begin with
    far = [ends + 9.0 * sign * np.eye(3)[axis] for axis in range(3) for sign in (-1, 1)]
    detours = [np.array([ends[0], *corners, ends[1]]) for corners in far]
    clear = [
        path for path in detours if ObstacleSet(solids).segment_clearances(path).min() > CLEARANCE
    ]
    assume(clear)
    length = min(_tightened(path, solids) for path in clear)
    assert length >= bound.length * (1 - 1e-8)
    if bound.exact:
        assert length <= bound.length * 1.002


@settings(max_examples=examples(20))
@given(bodies=st.lists(obstacles, max_size=3), start=points, goal=points)
def test_compiled_and_plain_bounds_are_the_same(
    bodies: list[dict[str, Any]], start: list[float], goal: list[float]
) -> None:
    scene = scene_of(bodies, start, goal)
    solids = tuple(solid for solid in scene.obstacles if not isinstance(solid, MeshShape))
    packed = pack(solids)
    kernel: Any = solid_bounds

    lengths, exact = kernel(packed, CLEARANCE, scene.start, scene.goal)
    plain, plain_exact = kernel.py_func(packed.tolist(), CLEARANCE, scene.start, scene.goal)

    np.testing.assert_allclose(lengths, plain, rtol=1e-12)
    np.testing.assert_array_equal(exact, plain_exact)


def test_past_a_long_box_it_is_the_straight_way_over_the_faces() -> None:
    # over the top of a wall of no end: three sides of the section, unrolled
    box = {"shape": "box", "size": [1.0, 90.0, 2.0], "position": [3, 3, 1]}
    scene = scene_of([box], [1, 1, 1], [5, 5, 1])

    bound = lower_bound(scene.start, scene.goal, ObstacleSet(scene.obstacles), 0.0, ROOMY)

    assert bound.exact
    assert bound.length == pytest.approx(math.hypot(2 * math.hypot(1.5, 1) + 1, 4), rel=1e-9)


def _bound(scene: Scene, room: Workspace | None = None, clearance: float = CLEARANCE) -> Bound:
    room = room or scene.workspace
    return lower_bound(scene.start, scene.goal, ObstacleSet(scene.obstacles), clearance, room)


def _best(scene: Scene, pitch: float = 0.4, clearance: float = CLEARANCE) -> float:
    """Length of the shortest certified way of a fine plan; inf where there is none."""
    changes: dict[str, Any] = {
        "mesh": {"pitch": pitch},
        "spline": {"clearance": clearance},
        "arm": {"avoid": False},
    }
    made = PLANNER(scene.replace(**changes), True)
    lengths = [math.inf]
    for found in (made.path, made.taut):
        if found is not None:
            # the bound leaves out as much as counts as rounding
            proof = certify(polyline(found.points), ObstacleSet(scene.obstacles), clearance - 1e-9)
            assert isinstance(proof, Certificate)
            lengths.append(float(np.linalg.norm(np.diff(found.points, axis=0), axis=1).sum()))
    for curve, arc in ((made.bspline, made.bspline_arc), (made.quadratic, made.quadratic_arc)):
        if curve is not None and arc is not None and curve.holds:
            lengths.append(arc.length)
    return min(lengths)


def _box(size: tuple[float, float, float], position: tuple[float, float, float]) -> dict[str, Any]:
    return {"shape": "box", "size": list(size), "position": list(position)}


def _mesh(mesh: meshes.Mesh, **pose: Any) -> MeshShape:
    return MeshShape.of(clean(*mesh), **pose)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("upper", [False, True])
def test_a_way_that_leaves_the_workspace_is_not_the_optimum(axis: int, upper: bool) -> None:
    # The wall itself ends 0.05 below the side of the workspace, and with its clearance above it.
    along, across = (axis + 1) % 3, (axis + 2) % 3
    size, middle = np.ones(3), np.full(3, 3.0)
    size[[axis, across]] = 5.5, 5.2
    middle[axis] = 3.2 if upper else 2.8
    ends = np.full((2, 3), 3.0)
    ends[:, axis] = 5.5 if upper else 0.5
    ends[:, along] = 1.0, 5.0
    wall = {"shape": "box", "size": size.tolist(), "position": middle.tolist()}
    scene = scene_of([wall], *ends.tolist())

    alone, here = _bound(scene, ROOMY), _bound(scene)

    assert alone.exact
    assert here.length == pytest.approx(alone.length, rel=1e-12)
    assert not here.exact
    assert _best(scene) > 1.5 * here.length


def test_past_a_wall_across_the_whole_workspace_there_is_no_optimum() -> None:
    scene = scene_of([_box((1, 6, 6), (3, 3, 3))], [1, 3, 5.5], [5, 3, 5.5])

    assert _best(scene) == math.inf
    assert not _bound(scene).exact


ON_TOP: dict[str, Obstacle] = {
    "box": Box(size=(1, 2, 1.9), position=(3, 3, 5.04)),
    "cylinder": Cylinder(radius=0.9, height=1.8, position=(3, 3, 5.0)),
    "sphere": Sphere(radius=0.9, position=(3, 3, 5.0)),
    "mesh": _mesh(meshes.box((1, 2, 1.9)), position=(3, 3, 5.04)),
}


@pytest.mark.parametrize("kind", ON_TOP)
@pytest.mark.parametrize("first", [True, False])
def test_what_stands_in_the_way_past_another_makes_it_no_optimum(kind: str, first: bool) -> None:
    # The middle of what is on top lies outside the ellipsoid of all ways of that length.
    alone = scene_of([_box((1, 2, 2), (3, 3, 3))], [1, 3, 3.5], [5, 3, 3.5])
    (low,) = alone.obstacles
    both = (ON_TOP[kind], low) if first else (low, ON_TOP[kind])
    scene = alone.model_copy(update={"obstacles": both})
    bound, crowded = _bound(alone), _bound(scene)

    assert bound.exact
    assert bound.length <= _best(alone) <= 1.003 * bound.length
    assert not crowded.exact
    assert crowded.length == pytest.approx(bound.length, rel=1e-12)
    assert _best(scene) > 1.02 * bound.length


def test_a_speck_stands_in_the_way_by_its_clearance() -> None:
    # It lies outside the ellipsoid of all ways of that length, but what has to be kept clear of it
    # does not.
    alone = scene_of([_box((1, 2, 2), (3, 3, 3))], [1, 3, 3.5], [5, 3, 3.5])
    speck = Sphere(radius=0.05, position=(3, 3, 4.85))
    scene = alone.model_copy(update={"obstacles": (*alone.obstacles, speck)})
    bound, crowded = _bound(alone, clearance=0.5), _bound(scene, clearance=0.5)
    to_speck = sum(math.dist(end, speck.position) for end in (scene.start, scene.goal))

    assert bound.exact
    assert to_speck - 2 * speck.radius * math.sqrt(3) > bound.length
    assert not crowded.exact
    assert crowded.length == pytest.approx(bound.length, rel=1e-12)
    assert _best(scene, clearance=0.5) > 1.02 * bound.length


def test_what_lies_beyond_all_ways_of_that_length_leaves_it_the_optimum() -> None:
    alone = scene_of([_box((1, 2, 2), (3, 3, 3))], [1, 3, 3.5], [5, 3, 3.5])
    corners = [0.4, 5.6]
    aside: list[Obstacle] = [
        Box(size=(0.5, 0.5, 0.5), position=(x, y, 0.4)) for x in corners for y in corners
    ]
    aside.append(_mesh(meshes.sphere(1, 0.3), position=(0.4, 0.4, 5.6)))
    scene = alone.model_copy(update={"obstacles": (*alone.obstacles, *aside)})

    assert _bound(scene).length == pytest.approx(_bound(alone).length, rel=1e-12)
    assert _bound(scene).exact


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_a_mesh_bounds_no_more_than_the_solid_it_lies_in(seed: int) -> None:
    random = np.random.default_rng(seed)
    radius = float(random.uniform(0.5, 1.5))
    x, y, z = random.uniform(-1, 1, 3).tolist()
    w, i, j, k = random.normal(size=4).tolist()
    pose: Any = {"position": (x, y, z), "wxyz": (w, i, j, k)}
    ends = random.normal(size=(2, 3))
    ends *= random.uniform(2.5, 5, (2, 1)) / np.linalg.norm(ends, axis=1, keepdims=True)
    a, b, c = ends[0].tolist()
    d, e, f = ends[1].tolist()
    straight = math.dist(*ends)
    bounds = [
        lower_bound((a, b, c), (d, e, f), ObstacleSet((body,)), CLEARANCE, ROOMY)
        for body in (Sphere(radius=radius, **pose), _mesh(meshes.sphere(3, radius), **pose))
    ]
    ball, mesh = bounds

    assert straight * (1 - 1e-14) <= mesh.length <= ball.length + 1e-9
    assert ball.exact
    in_the_way = mesh.length > straight * (1 + 1e-12)
    assert mesh.exact != in_the_way


def test_past_the_middle_of_a_round_mesh_the_bound_is_nearly_the_length() -> None:
    pose: Any = {"position": (3.0, 3.0, 3.0)}
    ball = Sphere(radius=1.0, **pose)
    round_mesh = _mesh(meshes.sphere(3), **pose)
    within, without = (
        lower_bound((1.0, 3.0, 3.0), (5.0, 3.1, 3.0), ObstacleSet((body,)), CLEARANCE, Workspace())
        for body in (round_mesh, ball)
    )

    assert without.exact
    assert not within.exact
    assert 0.99 * without.length <= within.length <= without.length


@pytest.mark.parametrize(
    "body",
    [
        Box(size=(1, 1, 5)),
        Cylinder(radius=0.5, height=5),
        Capsule(radius=0.5, height=4),
        Sphere(radius=2.5),
        _mesh(meshes.box((1, 1, 5))),
    ],
    ids=lambda body: str(body.shape),
)
@pytest.mark.parametrize("back", [False, True])
def test_from_too_near_an_obstacle_there_is_no_way_to_bound(body: Obstacle, back: bool) -> None:
    # 0.05 from its end, to the other side of its middle: a ball there does not hold the point
    ends = ((0.1, 0.0, 2.55), (-4.0, 0.0, -4.0))
    start, goal = ends[::-1] if back else ends

    bound = lower_bound(start, goal, ObstacleSet((body,)), CLEARANCE, ROOMY)

    assert bound.length == pytest.approx(math.dist(start, goal), rel=1e-14)
    assert not bound.exact


def _crowd(seed: int) -> Scene:
    """One obstacle on the straight line and up to four elsewhere; in every third scene a mesh."""
    random = np.random.default_rng(seed)
    start, goal = random.uniform(0, [0.8, 6, 6]), random.uniform([5.2, 0, 0], 6)
    bodies: list[dict[str, Any]] = []
    for k in range(int(random.integers(2, 6))):
        a, b, c = random.uniform(0.3, 1.0 if k else 1.6, 3).tolist()
        middle = (start + goal) / 2 + random.uniform(-0.3, 0.3, 3)
        place = random.uniform(1, 5, 3) if k else np.clip(middle, 1, 5)
        shape = str(random.choice(["box", "sphere", "cylinder", "capsule"]))
        sizes: dict[str, dict[str, Any]] = {
            "box": {"size": [a, b, c]},
            "sphere": {"radius": a / 2},
            "cylinder": {"radius": a / 2, "height": b},
            "capsule": {"radius": a / 3, "height": b},
            "mesh": {"file": "blob.stl", "scale": a / 3},
        }
        if k and not seed % 3:
            shape = "mesh"
        pose = {"position": place.tolist(), "wxyz": random.normal(size=4).tolist()}
        bodies.append({"shape": shape, **sizes[shape], **pose})
    return scene_of([], start.tolist(), goal.tolist()).replace(
        {"blob.stl": meshes.stl(meshes.bumpy(2))}, obstacles=bodies
    )


@pytest.mark.slow
def test_no_certified_way_among_several_obstacles_is_shorter_than_the_bound() -> None:
    exact = bounded = 0
    for seed in range(36):
        scene = _crowd(seed)
        bound, best = _bound(scene), _best(scene, 0.8)
        straight = math.dist(scene.start, scene.goal)
        assert straight * (1 - 1e-14) <= bound.length <= best * (1 + 1e-9), seed
        if bound.exact:
            assert best <= 1.01 * bound.length, seed
        exact += bound.exact and bound.length > 1.001 * straight
        bounded += not bound.exact and math.isfinite(best)
    # Otherwise the scenes would have tested nothing.
    assert exact >= 3
    assert bounded >= 10


@given(st.integers(0, 2**32 - 1))
def test_around_a_ball_there_is_no_shorter_way_than_the_bound(seed: int) -> None:
    """Down to the ball, around and up again: as short as any way where both ends nearly touch."""
    random = np.random.default_rng(seed)
    up, other = random.normal(size=(2, 3))
    up /= np.linalg.norm(up)
    down = -up + 10 ** random.uniform(-12, 0) * other
    down /= np.linalg.norm(down)
    start, goal = (end * (1 + 10 ** random.uniform(-15, -6)) for end in (up, down))
    heights = np.linalg.norm([start, goal], axis=1)
    assume((heights > 1).all())
    angle = math.atan2(np.linalg.norm(np.cross(start, goal)), start @ goal)
    around = float(heights.sum()) - 2 + angle
    assert around_ball(1.0, tuple(start.tolist()), tuple(goal.tolist())) <= around + 1e-14
