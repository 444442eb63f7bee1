from __future__ import annotations

import copy
import json
import math
import sys
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from abi.arrays import FloatArray
from abi.curves.bspline import BSpline, clamped
from abi.curves.clearance.certificate import Certificate, certify
from abi.curves.quadratic import Quadratic
from abi.errors import SceneError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacles, ObstacleSet
from abi.obstacles.primitives import Box, Capsule, Cylinder, Sphere
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.obstacles.triangle_mesh.repair import clean
from abi.obstacles.triangle_mesh.surface import Surface
from abi.planner.planner import plan
from abi.scene.scene import load_scene, scene_names
from abi.verify.exact.mesh import ExactMesh
from abi.verify.exact.solids import ExactSolid, exact_spline, in_body, sqrt_bounds, vector
from abi.verify.verify import Verdict, verify
from app.__main__ import main
from benchmarks.certificates import as_plan, name_of, true_clearance
from tests.abi import meshes
from tests.abi.solids import support
from tests.abi.verify.verdicts import verdict_on
from tests.random_geometry import random_curve, random_obstacle
from tests.thorough import examples, of_each_kind

seeds = st.integers(0, 2**32 - 1)
Data = dict[str, Any]


def certified(
    curve: BSpline | Quadratic, obstacles: Obstacles, part: float = 0.999
) -> Certificate | None:
    clearance = true_clearance(curve, obstacles)
    found = certify(curve, ObstacleSet(obstacles), part * clearance) if clearance > 0 else None
    return found if isinstance(found, Certificate) else None


def verdict(data: Data, name: str = "bspline", folder: MeshSource | None = None) -> Verdict:
    return verdict_on(name, data, folder)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", of_each_kind(scene_names(), "paper", "two-boxes", "sculpture", "kitchen-ur5e", "no-way")
)
def test_every_certificate_of_a_plan_is_accepted(name: str) -> None:
    scene = load_scene(name)
    data = json.loads(json.dumps(plan(scene).to_dict(), allow_nan=False))
    for one in verify(data, scene.meshes):
        section = data[one.curve]
        assert one.proven == (section is not None and section["certificate"] is not None)
        if not one.proven:
            continue
        margin = section["certificate"]["margin"]
        assert section["clearance"] == margin
        touching = one.curve == "arm" and margin == 0
        kept = "touch no obstacle" if touching else f"{margin or 0:.9g} {scene.unit}"
        assert margin is None or kept in one.reason
        if one.curve == "arm":
            assert section["certified"]
            continue
        enough = margin is None or margin >= scene.spline.clearance - 1e-9
        assert section["certified"] == enough
        assert ("less than" in one.reason) == (not enough)


def test_of_a_plan_without_curves_nothing_is_proven() -> None:
    scene = load_scene("no-way")
    data = json.loads(json.dumps(plan(scene).to_dict(), allow_nan=False))
    found = verify(data, scene.meshes)

    assert [one.curve for one in found] == ["bspline", "quadratic", "arm"]
    for one in found:
        assert not one.proven
        assert one.reason in ("the plan has no such curve", "the plan has no motion")
        assert "NOT proven" in str(one)


@pytest.mark.slow
@settings(max_examples=12)
@given(seeds, st.sampled_from([0.5, 0.999, 1 - 1e-7]))
def test_honest_certificates_are_accepted(seed: int, part: float) -> None:
    random = np.random.default_rng(seed)
    curve = random_curve(random)
    obstacles = tuple(random_obstacle(random) for _ in range(random.integers(1, 7)))
    result = certified(curve, obstacles, part)
    if result is not None:
        data = json.loads(json.dumps(as_plan(curve, obstacles, result)))
        assert verdict(data, name_of(curve)).proven


@pytest.fixture(scope="module")
def honest() -> Data:
    points = np.array([[0, 0, 0], [0, 3, 1], [2, 5, 3], [4.5, 5, 2], [6, 3, 1], [6, 0.5, 0.2]])
    obstacles: Obstacles = (
        Box(size=(1.5, 3.4, 3), position=(3, 2, 2), wxyz=(0.8, -0.3, 0.4, 0.2)),
        Cylinder(radius=0.4, height=1, position=(0.5, 5, 3), wxyz=(0.5, 0.5, 0.1, 0)),
        Capsule(radius=0.4, height=1, position=(5, 2.5, 4)),
    )
    curve = clamped(points, 3)
    result = certified(curve, obstacles)
    assert result is not None
    data: Data = json.loads(json.dumps(as_plan(curve, obstacles, result)))
    assert verdict(data).proven
    assert min(np.bincount(result.obstacle)) > 1
    return data


def moved_control_point(data: Data) -> None:
    data["bspline"]["control_points"][3][1] -= 0.02


def changed_direction(data: Data) -> None:
    plane = data["bspline"]["certificate"]["planes"][0]
    x, y, z = plane["direction"]
    plane["direction"] = [y, -x, z]


def reversed_direction(data: Data) -> None:
    plane = data["bspline"]["certificate"]["planes"][0]
    plane["direction"] = [-part for part in plane["direction"]]


def lengthened_direction(data: Data) -> None:
    # the products grow, and so must what they are compared with
    for plane in data["bspline"]["certificate"]["planes"]:
        plane["direction"] = [1000 * part for part in plane["direction"]]
    wrong_margin(data)


def no_direction(data: Data) -> None:
    data["bspline"]["certificate"]["planes"][0]["direction"] = [0.0, 0.0, 0.0]


def dropped_first_piece(data: Data) -> None:
    planes = data["bspline"]["certificate"]["planes"]
    planes.remove(next(plane for plane in planes if plane["t0"] == 0))


def dropped_last_piece(data: Data) -> None:
    planes = data["bspline"]["certificate"]["planes"]
    planes.remove(next(plane for plane in planes if plane["t1"] == 1))


def dropped_obstacle(data: Data) -> None:
    planes = data["bspline"]["certificate"]["planes"]
    planes[:] = [plane for plane in planes if plane["obstacle"] != 1]


def dropped_planes(data: Data) -> None:
    data["bspline"]["certificate"]["planes"].clear()


def gap(data: Data) -> None:
    plane = next(p for p in data["bspline"]["certificate"]["planes"] if p["t0"] > 0)
    plane["t0"] = math.nextafter(plane["t0"], 1)


def stretched_piece(data: Data) -> None:
    planes = data["bspline"]["certificate"]["planes"]
    kept = min(planes, key=lambda plane: plane["t1"] - plane["t0"])
    planes[:] = [plane for plane in planes if plane["obstacle"] != kept["obstacle"]]
    planes.append({**kept, "t0": 0.0, "t1": 1.0})


def backward_piece(data: Data) -> None:
    plane = data["bspline"]["certificate"]["planes"][0]
    plane["t0"], plane["t1"] = plane["t1"], plane["t0"]


def other_start(data: Data) -> None:
    data["scene"]["start"] = data["scene"]["goal"]


def other_goal(data: Data) -> None:
    data["scene"]["goal"][2] += 1e-6


def wrong_margin(data: Data) -> None:
    data["bspline"]["clearance"] *= 1.01
    data["bspline"]["certificate"]["margin"] = data["bspline"]["clearance"]


def wrong_clearance(data: Data) -> None:
    data["bspline"]["clearance"] *= 0.99


def no_margin(data: Data) -> None:
    data["bspline"]["clearance"] = data["bspline"]["certificate"]["margin"] = None


def negative_margin(data: Data) -> None:
    data["bspline"]["clearance"] = data["bspline"]["certificate"]["margin"] = -0.5


def grown_obstacle(data: Data) -> None:
    data["scene"]["obstacles"][0]["size"][1] += 0.01


def moved_obstacle(data: Data) -> None:
    data["scene"]["obstacles"][0]["position"][1] += 0.01


def turned_obstacle(data: Data) -> None:
    data["scene"]["obstacles"][0]["wxyz"] = [1.0, 0.0, 0.0, 0.0]


def thicker_cylinder(data: Data) -> None:
    data["scene"]["obstacles"][1]["radius"] += 0.5


def swapped_obstacles(data: Data) -> None:
    data["scene"]["obstacles"].reverse()


def one_obstacle_more(data: Data) -> None:
    data["scene"]["obstacles"].append({"shape": "sphere", "radius": 0.1, "position": [9, 9, 9]})


def changed_knot(data: Data) -> None:
    data["bspline"]["knots"][4] = 0.55


def lower_degree(data: Data) -> None:
    data["bspline"]["degree"] = 2
    data["bspline"]["knots"] = [0, 0, 0, 0.25, 0.5, 0.75, 1, 1, 1]


def not_said(data: Data) -> None:
    data["bspline"]["certified"] = False


def not_carried(data: Data) -> None:
    data["bspline"]["certificate"] = None


DAMAGES = [
    moved_control_point,
    changed_direction,
    reversed_direction,
    lengthened_direction,
    no_direction,
    dropped_first_piece,
    dropped_last_piece,
    dropped_obstacle,
    dropped_planes,
    gap,
    stretched_piece,
    backward_piece,
    other_start,
    other_goal,
    wrong_margin,
    wrong_clearance,
    no_margin,
    negative_margin,
    grown_obstacle,
    moved_obstacle,
    turned_obstacle,
    thicker_cylinder,
    swapped_obstacles,
    one_obstacle_more,
    changed_knot,
    lower_degree,
    not_said,
    not_carried,
]


@pytest.mark.parametrize("damage", DAMAGES, ids=lambda damage: str(damage.__name__))
def test_damaged_certificates_are_refused(honest: Data, damage: Callable[[Data], None]) -> None:
    data = copy.deepcopy(honest)
    damage(data)
    found = verdict(data)
    assert not found.proven
    assert "\n" not in str(found)


def test_longer_directions_and_overlapping_pieces_prove_as_much(honest: Data) -> None:
    data = copy.deepcopy(honest)
    planes = data["bspline"]["certificate"]["planes"]
    for plane in planes:
        plane["direction"] = [8 * part for part in plane["direction"]]
    planes.append(dict(planes[0]))
    planes.reverse()
    assert verdict(data).proven


def planes_of(margin: float, rows: FloatArray) -> Certificate:
    """Certificate of a curve by rows of two parameters, an obstacle and a normal."""
    whose, none = rows[:, 2].astype(np.int32), np.full(len(rows), -1, dtype=np.int32)
    return Certificate(margin, rows[:, :2], whose, rows[:, 3:], rows[:, 0], none)


def test_a_margin_that_is_too_large_by_next_to_nothing_is_refused() -> None:
    curve = clamped(np.array([[-2.0, 1.5, 0], [2, 1.5, 0]]), 1)
    proof = planes_of(0.5, np.array([[0.0, 1.0, 0.0, 0.0, 1.0, 0.0]]))
    for margin, proven in ((0.5, False), (math.nextafter(0.5, 0), True)):
        data = as_plan(curve, (Sphere(radius=1),), proof)
        data["bspline"]["clearance"] = data["bspline"]["certificate"]["margin"] = margin
        assert verdict(data).proven == proven


def down(obstacles: Obstacles, planes: list[list[float]], margin: float = -0.9e-9) -> Verdict:
    """Certificate of a line along z by planes of two parameters, an obstacle and a normal."""
    line = clamped(np.array([[0.0, 0, 1], [0, 0, 0], [0, 0, -1]]), 1)
    proof = planes_of(margin, np.array(planes))
    data = as_plan(line, obstacles, proof)
    data["scene"]["spline"] = {"clearance": 0.0}
    data["bspline"]["certified"] = margin >= -1e-9
    files = {one.file: one.surface for one in obstacles if isinstance(one, MeshShape)}
    return verdict(data, folder=MeshSource(files))


THIN: list[Box | MeshShape] = [
    Box(size=(2, 2, 1e-9)),
    MeshShape.of(clean(np.array([[-1.0, -1, 0], [1, -1, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))),
]


@pytest.mark.parametrize("thin", THIN, ids=["box", "triangle"])
def test_a_line_right_through_what_is_thin_is_not_proven_by_a_negative_margin(
    thin: Box | MeshShape,
) -> None:
    # Onto either side it goes in by less than rounding, so two planes prove as much: that it
    # touches. What is thick beside it does not make that mean anything.
    thick = Sphere(radius=1, position=(4, 0, 0))
    planes: list[list[float]] = [[0, 0.5, 0, 0, 0, 1], [0.5, 1, 0, 0, 0, -1], [0, 1, 1, -1, 0, 0]]

    found = down((thin, thick), planes)

    assert not found.proven
    assert "negative" in found.reason


@pytest.mark.parametrize(
    ("thickness", "proven"), [(1.0, True), (9e-9, True), (7e-9, False), (1e-9, False)]
)
def test_a_line_may_touch_what_is_thick(thickness: float, proven: bool) -> None:
    # along its face, in by half of what counts as rounding
    box = Box(size=(thickness, 2, 2), position=(thickness / 2 - 0.5e-9, 0, 0))
    found = down((box,), [[0, 1, 0, -1, 0, 0]])

    assert found.proven == proven
    assert proven or "negative" in found.reason


def test_that_a_line_goes_no_deeper_is_nothing_that_a_plan_may_claim() -> None:
    box = Box(size=(2, 2, 2), position=(0.75, 0, 0))

    found = down((box,), [[0, 1, 0, -1, 0, 0]], -0.3)

    assert not found.proven
    assert "negative" in found.reason


def test_without_obstacles_there_is_nothing_to_prove(honest: Data) -> None:
    data = copy.deepcopy(honest)
    data["scene"]["obstacles"] = []
    for margin, proven in ((0.3, False), (None, True)):
        data["bspline"]["certificate"] = {"margin": margin, "planes": []}
        data["bspline"]["clearance"] = margin
        assert verdict(data).proven == proven


@pytest.mark.parametrize("jump", [0.0, 1e-12, 3.0])
def test_a_curve_that_jumps_is_refused(honest: Data, jump: float) -> None:
    # two straight ways, one below and one above what is in the middle
    points = [[0, 0, 0], [0, 0, 0.5], [0, 0, 0.5 + jump], [0, 0, 6]]
    wall = {"shape": "box", "size": [50, 50, 1], "position": [0, 0, 2], "wxyz": [1, 0, 0, 0]}
    data = copy.deepcopy(honest)
    data["scene"] |= {"start": points[0], "goal": points[-1], "obstacles": [wall]}
    data["scene"]["workspace"] = {"min": [-1, -1, -1], "max": [6, 6, 6]}
    data["bspline"] |= {"degree": 1, "control_points": points, "knots": [0, 0, 0.5, 0.5, 1, 1]}
    data["bspline"]["clearance"] = 0.5
    data["bspline"]["certificate"] = {
        "margin": 0.5,
        "planes": [
            {"t0": 0.0, "t1": 0.5, "obstacle": 0, "direction": [0, 0, -1.0]},
            {"t0": 0.5, "t1": 1.0, "obstacle": 0, "direction": [0, 0, 1.0]},
        ],
    }
    reason = verdict(data).reason
    assert ("the curve jumps at 0.5" in reason) == (jump > 1)


@pytest.mark.parametrize(
    ("shape", "thickness", "jump", "where"),
    [
        ("mesh", 0, 0, 0.5),
        ("mesh", 0, 4e-10, 0.5),
        ("box", 1e-10, 4e-10, 0.5),
        ("box", 1e-4, 1e-4, 4e5),
    ],
)
def test_no_touch_and_no_gap_of_rounding_leads_through_a_thin_wall(
    honest: Data, shape: str, thickness: float, jump: float, where: float
) -> None:
    points = [[0, 0, 0], [0, 0, where - jump], [0, 0, where + jump], [0, 0, 2 * where]]
    wall = clean(np.array([[-9, -9, 0.5], [9, -9, 0.5], [0, 9, 0.5]]), np.array([[0, 1, 2]]))
    data = copy.deepcopy(honest)
    data["scene"] |= {"start": points[0], "goal": points[-1]}
    data["scene"]["workspace"]["max"][2] = 2 * where
    own = {"file": "wall.stl"} if shape == "mesh" else {"size": [9, 9, thickness]}
    place = [0, 0, where if shape == "box" else 0]
    data["scene"]["obstacles"] = [{"shape": shape, **own, "position": place}]
    data["scene"]["spline"] = {"clearance": 0.0}
    data["bspline"] |= {"degree": 1, "control_points": points, "knots": [0, 0, 0.5, 0.5, 1, 1]}
    planes = [
        {"t0": t0, "t1": t0 + 0.5, "obstacle": 0, "direction": [0, 0, way]}
        for t0, way in ((0.0, -1.0), (0.5, 1.0))
    ]
    data["bspline"] |= {"clearance": 0.0, "certificate": {"margin": 0.0, "planes": planes}}
    found = verdict(data, folder=MeshSource({"wall.stl": wall}))
    assert "keeps no distance from an obstacle" in found.reason


def test_quaternions_of_any_length_turn_alike(honest: Data) -> None:
    data = copy.deepcopy(honest)
    for obstacle in data["scene"]["obstacles"]:
        obstacle["wxyz"] = [4 * part for part in obstacle["wxyz"]]
    assert verdict(data).proven


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("scene",), None),
        (("scene", "obstacles"), {}),
        (("scene", "version"), 7),
        (("version",), 99),
        (("version",), True),
        (("version",), None),
        (("bspline",), [1]),
        (("bspline", "degree"), 3.0),
        (("bspline", "degree"), True),
        (("bspline", "knots"), None),
        (("bspline", "knots", 3), 2.0),
        (("bspline", "knots", 3), "0"),
        (("bspline", "control_points", 0), [0.0, 0.0]),
        (("bspline", "control_points", 0, 0), math.inf),
        (("bspline", "control_points", 0, 0), math.nan),
        (("bspline", "control_points", 0, 0), 10**400),
        (("bspline", "certificate"), 5),
        (("bspline", "certificate", "margin"), "0.1"),
        (("bspline", "certificate", "planes"), None),
        (("bspline", "certificate", "planes", 0), None),
        (("bspline", "certificate", "planes", 0, "obstacle"), 9),
        (("bspline", "certificate", "planes", 0, "obstacle"), -1),
        (("bspline", "certificate", "planes", 0, "obstacle"), True),
        (("bspline", "certificate", "planes", 0, "t0"), None),
        (("bspline", "certificate", "planes", 0, "direction"), [1.0]),
    ],
)
def test_what_is_not_a_plan_is_named(
    honest: Data, place: tuple[str | int, ...], value: Any
) -> None:
    data: Any = copy.deepcopy(honest)
    target = data
    for part in place[:-1]:
        target = target[part]
    target[place[-1]] = value
    with pytest.raises(SceneError):
        verify(data)


@pytest.mark.parametrize("data", [None, [], {}, {"scene": {}}, "plan"])
def test_other_data_is_not_a_plan(data: Any) -> None:
    with pytest.raises(SceneError):
        verify(data)


@pytest.mark.parametrize("pieces", [[], [{"t0": 0.0, "t1": 1.0, "coefficients": [[0, 0, 0]]}]])
def test_quadratics_need_pieces_of_three_rows(honest: Data, pieces: list[Data]) -> None:
    data = {**honest, "quadratic": {"pieces": pieces, "certificate": None}}
    with pytest.raises(SceneError):
        verify(data)


@pytest.mark.slow
@given(st.fractions(0, 10**30), st.integers(-200, 200))
@settings(max_examples=examples(26))
def test_roots_are_bounded_from_both_sides(number: Fraction, power: int) -> None:
    square = number * Fraction(2) ** power
    below, above = sqrt_bounds(square)
    assert 0 <= below <= above
    assert below**2 <= square <= above**2
    assert above - below <= above / 2**99


@given(seeds)
@settings(max_examples=50)
def test_rotations_are_those_of_scipy(seed: int) -> None:
    random = np.random.default_rng(seed)
    v, (w, x, y, z) = random.normal(size=3), random.normal(size=4)
    found = in_body(vector(v.tolist()), (w, x, y, z))
    expected = Rotation.from_quat([x, y, z, w]).inv().apply(v)
    assert [float(part) for part in found] == pytest.approx(expected.tolist(), abs=1e-14)
    # Turning keeps the length: exactly.
    assert sum(part * part for part in found) == sum(Fraction(part) ** 2 for part in v.tolist())


@pytest.mark.slow
@given(seeds)
@settings(max_examples=20)
def test_exact_bezier_points_are_the_rounded_ones(seed: int) -> None:
    random = np.random.default_rng(seed)
    degree = int(random.integers(1, 6))
    curve = clamped(random.uniform(0, 6, (int(random.integers(degree + 1, 9)), 3)), degree)
    control = tuple(vector(point) for point in curve.control_points.tolist())
    exact = exact_spline(degree, [*map(Fraction, curve.knots.tolist())], control)
    pieces = curve.bezier()
    for span, points in zip(exact, pieces.points, strict=True):
        found = np.array(span.points(span.start, span.end), dtype=float)
        assert np.abs(found - np.array(span.bezier, dtype=float)).max() == 0
        assert np.abs(found - points).max() <= 1e-14 * 6


@pytest.mark.parametrize("shape", ["box", "sphere", "cylinder", "capsule"])
def test_solids_are_separated_up_to_their_support(shape: str) -> None:
    random = np.random.default_rng(7)
    pose: Any = {"position": (1.0, -2.0, 0.5), "wxyz": (0.4, 0.3, -0.8, 0.1)}
    zero = Fraction(0)
    sizes: dict[str, tuple[Any, tuple[float, float, float], float, float]] = {
        "box": (Box(size=(1, 2, 3), **pose), (0.5, 1.0, 1.5), 0.0, 0.0),
        "sphere": (Sphere(radius=0.7, **pose), (0.0, 0.0, 0.0), 0.0, 0.7),
        "cylinder": (Cylinder(radius=0.7, height=3, **pose), (0.0, 0.0, 1.5), 0.7, 0.0),
        "capsule": (Capsule(radius=0.7, height=3, **pose), (0.0, 0.0, 1.5), 0.0, 0.7),
    }
    solid, half, disc, ball = sizes[shape]
    exact = ExactSolid(
        vector(half), Fraction(disc), Fraction(ball), vector(pose["position"]), solid.wxyz
    )
    for normal in random.normal(size=(30, 3)):
        direction = vector(normal.tolist())
        for margin in (zero, Fraction(1, 3), Fraction(-1, 9)):
            edge = support(solid, normal[None])[0] + float(margin) * np.linalg.norm(normal)
            assert exact.separated(direction, Fraction(edge + 1e-12), margin)
            assert not exact.separated(direction, Fraction(edge - 1e-12), margin)
    assert float(exact.depth) == pytest.approx(
        -solid.signed_distance(np.array([solid.position]))[0]
    )


def blob() -> tuple[Surface, MeshShape]:
    surface = Surface(*meshes.bumpy(3), closed=True)
    pose: Any = {"position": (3.0, 3.0, 3.0), "wxyz": (0.5, 0.2, -0.7, 0.1), "scale": 0.6}
    return surface, MeshShape.of(surface, "blob.stl", **pose)


def past_the_blob() -> tuple[Data, MeshSource]:
    surface, shape = blob()
    points = np.array([[0.0, 0, 0], [0.5, 5, 2], [4, 6, 3], [6, 4, 5.0], [6.0, 2, 3]])
    curve = clamped(points, 4)
    result = certified(curve, (shape,))
    assert result is not None
    assert len(result.pieces) > 10
    return as_plan(curve, (shape,), result), MeshSource({"blob.stl": surface})


@pytest.mark.slow
def test_certificates_of_meshes_are_accepted_and_damaged_ones_refused() -> None:
    data, files = past_the_blob()
    assert verdict(data, folder=files).proven
    planes = data["bspline"]["certificate"]["planes"]
    # the tree's upper planes leave others nothing to do, so not every plane is missed
    missed = 0
    for k in range(0, len(planes), 5):
        damaged = copy.deepcopy(data)
        del damaged["bspline"]["certificate"]["planes"][k]
        missed += not verdict(damaged, folder=files).proven
    assert missed >= 1
    for damage in (wrong_margin, gap, reversed_direction, dropped_planes, moved_control_point):
        damaged = copy.deepcopy(data)
        if damage is moved_control_point:
            damaged["bspline"]["control_points"][2] = [3.0, 3.0, 3.0]
        else:
            damage(damaged)
        assert not verdict(damaged, folder=files).proven, damage


def test_a_curve_inside_a_closed_mesh_is_refused() -> None:
    vertices, faces = meshes.sphere(2)
    ball = MeshShape.of(clean(vertices, faces), "ball.stl")
    shell = MeshShape.of(clean(vertices, faces[1:]), "ball.stl")
    line = clamped(np.array([[-0.2, 0, 0], [0.2, 0, 0]]), 1)
    result = certify(line, ObstacleSet((shell,)), 0.1)
    assert isinstance(result, Certificate)
    data = as_plan(line, (shell,), result)
    assert verdict(data, folder=MeshSource({"ball.stl": shell.surface})).proven
    closed = verdict(data, folder=MeshSource({"ball.stl": ball.surface}))
    assert not closed.proven
    assert "obstacle 1" in closed.reason


@pytest.mark.slow
@given(seeds)
@settings(max_examples=12)
def test_inside_is_where_the_mesh_winds_around(seed: int) -> None:
    random = np.random.default_rng(seed)
    vertices, faces = meshes.box((2, 2, 2))
    quaternion = (1.0, 0.0, 0.0, 0.0) if seed % 2 else tuple(random.normal(size=4).tolist())
    w, x, y, z = quaternion
    one = ExactMesh(vertices, faces, True, 0.5, vector((1.0, 2.0, 3.0)), (w, x, y, z))
    box = Box(size=(1, 1, 1), position=(1, 2, 3), wxyz=(w, x, y, z))
    # multiples of a quarter meet edges and corners along the ray
    points = random.integers(-4, 5, (20, 3)) / 4 if seed % 2 else random.uniform(-1, 1, (20, 3))
    points = points + np.array([1, 2, 3])
    distance = box.signed_distance(points)
    for point, away in zip(points.tolist(), distance, strict=True):
        if abs(away) > 1e-9:
            assert one.inside(vector(point)) == (away < 0)


def run(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], path: Path
) -> tuple[int, str, str]:
    monkeypatch.setattr(sys, "argv", ["abi", "verify", str(path)])
    code = 0
    try:
        main()
    except SystemExit as stop:
        code = stop.code if isinstance(stop.code, int) else 0
    out, err = capsys.readouterr()
    return code, out, err


@pytest.mark.slow
def test_the_command_accepts_refuses_and_complains(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    path = tmp_path / "plan.json"
    data = plan(load_scene("paper")).to_dict()
    path.write_text(json.dumps(data))
    code, out, err = run(monkeypatch, capsys, path)
    assert (code, err) == (0, "")
    assert [line.partition(":")[0] for line in out.splitlines()] == [
        *("bspline", "quadratic", "arm", "not checked")
    ]

    data["quadratic"]["certificate"]["planes"].pop()
    path.write_text(json.dumps(data))
    code, out, err = run(monkeypatch, capsys, path)
    assert (code, err) == (3, "")
    assert "quadratic: NOT proven" in out

    data["bspline"]["certificate"] = None
    path.write_text(json.dumps(data))
    assert run(monkeypatch, capsys, path)[0] == 3

    twice = '{"version": 1, "version": 1}'
    for text in (twice, "", "[1", "[]", '{"scene": NaN}', "[" * 100_000, '{"scene": 1e999}'):
        path.write_text(text)
        code, out, err = run(monkeypatch, capsys, path)
        assert (code, out) == (2, "")
        assert len(err.strip().splitlines()) == 1
        assert err.startswith("abi: ")
    path.write_bytes(b"\xff\xfe\x00")
    assert run(monkeypatch, capsys, path)[0] == 2
    assert run(monkeypatch, capsys, tmp_path / "missing.json")[0] == 2
    assert run(monkeypatch, capsys, tmp_path)[0] == 2


def test_a_plan_without_anything_to_check_is_not_proven() -> None:
    scene = load_scene("two-boxes").to_dict()
    empty = {"version": 1, "scene": scene, "bspline": None, "quadratic": None, "joint_search": {}}
    assert [(one.curve, one.proven) for one in verify(empty)] == [("arm", False)]
