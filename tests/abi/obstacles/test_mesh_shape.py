from __future__ import annotations

import math
import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st

from abi import Planner, Scene, load_scene
from abi.arrays import FloatArray, flat
from abi.curves.fit_bspline import fit
from abi.errors import SceneError
from abi.obstacles.mesh_shape import MeshShape, suggest_unit
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import METRES
from abi.obstacles.primitives import Box, Sphere
from abi.obstacles.triangle_mesh import surface_kernels as kernels
from abi.obstacles.triangle_mesh.repair import clean
from abi.obstacles.triangle_mesh.signed_distance import surface_tables
from abi.obstacles.triangle_mesh.surface import Surface
from abi.obstacles.triangle_mesh.surface_distance_kernels import bounds_along
from abi.obstacles.triangle_mesh.surface_tables_kernels import new_room, to_surface
from abi.scene.settings import MeshSettings, Workspace
from abi.tet_mesh.exclusion import exclude
from abi.tet_mesh.tet_mesh import tetrahedralise
from tests.abi import meshes
from tests.abi.shape_distances import segment_distance
from tests.abi.solids import world_from_body

Pose = dict[str, Any]

BOX = clean(*meshes.box((2, 1, 3)))
BLOB = clean(*meshes.bumpy(3))
SOUP = clean(*meshes.soup(200))
OPEN_BOX = clean(meshes.box((2, 2, 2))[0], meshes.box((2, 2, 2))[1][:-2])
SURFACES = {"box": BOX, "blob": BLOB, "soup": SOUP, "open-box": OPEN_BOX}

seeds = st.integers(0, 2**32 - 1)
names = st.sampled_from(sorted(SURFACES))


def pose(rng: np.random.Generator) -> Pose:
    return {
        "position": tuple(rng.uniform(-3, 3, 3).tolist()),
        "wxyz": tuple(rng.normal(size=4).tolist()),
        "scale": float(np.exp(rng.uniform(-3, 3))),
    }


def around(shape: MeshShape, rng: np.random.Generator, count: int) -> FloatArray:
    """Points in and around the shape's bounding box, and some next to its surface."""
    low, high = shape.bounds()
    size = high - low
    far = rng.uniform(low - size, high + size, (count, 3))
    triangles = shape.triangles()[rng.integers(0, len(shape.triangles()), count)]
    on = np.einsum("ij,ijk->ik", rng.dirichlet(np.ones(3), count), triangles)
    near = on + rng.normal(size=(count, 3)) * size.max() * 10.0 ** rng.uniform(-9, -1, (count, 1))
    return np.concatenate([far, near])


def size(shape: MeshShape) -> float:
    return float(np.ptp(shape.bounds(), axis=0).max())


def to_triangles(points: FloatArray, triangles: FloatArray) -> FloatArray:
    """Distance of points (n, 3) to the nearest triangle, by brute force over all of them."""
    best = np.full(len(points), np.inf)
    for a, b, c in triangles:
        normal = np.cross(b - a, c - a)
        height = (points - a) @ normal / (normal @ normal)
        over = np.ones(len(points), dtype=bool)
        for p, q in ((a, b), (b, c), (c, a)):
            over &= (points - p) @ np.cross(normal, q - p) >= 0
            t = np.clip((points - p) @ (q - p) / ((q - p) @ (q - p)), 0, 1)
            best = np.minimum(best, np.linalg.norm(points - p - t[:, None] * (q - p), axis=1))
        plane = np.abs(height) * np.linalg.norm(normal)
        best = np.where(over, np.minimum(best, plane), best)
    return best


@settings(max_examples=40)
@given(seeds)
def test_a_mesh_of_a_box_is_the_box(seed: int) -> None:
    rng = np.random.default_rng(seed)
    placed = pose(rng)
    scale = placed["scale"]
    mesh = MeshShape.of(BOX, **placed)
    box = Box(size=(2 * scale, scale, 3 * scale), position=placed["position"], wxyz=placed["wxyz"])
    points = around(mesh, rng, 100)
    p, q = points, np.roll(points, 1, axis=0)
    tolerance = 1e-9 * size(mesh)

    np.testing.assert_allclose(mesh.bounds(), box.bounds(), atol=tolerance)
    expected = box.signed_distance(points)
    np.testing.assert_allclose(mesh.signed_distance(points), expected, atol=tolerance)
    found, least = mesh.segment_distance(p, q), segment_distance(box, p, q)
    outside = least > tolerance
    np.testing.assert_allclose(found[outside], least[outside], atol=tolerance)
    assert (found <= least + tolerance).all()
    assert (found >= least - np.linalg.norm(q - p, axis=1) / 64 - tolerance).all()
    for margin in (0.0, 0.1 * scale, scale):
        sure = np.abs(least - margin) > 1e-7 * size(mesh)
        blocked = ObstacleSet((mesh,)).blocked(p, q, margin)
        np.testing.assert_array_equal(blocked[sure], (least < margin)[sure])


def test_a_mesh_of_a_sphere_is_the_sphere_but_for_its_facets() -> None:
    rng = np.random.default_rng(1)
    mesh = MeshShape.of(clean(*meshes.sphere(4)), position=(1, 2, 3), scale=2.0)
    sphere = Sphere(radius=2.0, position=(1, 2, 3))
    points = rng.uniform(-4, 8, (500, 3))
    gap = mesh.signed_distance(points) - sphere.signed_distance(points)
    facet = 2 * (1 - math.cos(0.0724))  # icosphere: the longest edge spans twice that angle
    assert gap.min() > -1e-9
    assert gap.max() < facet
    toward = np.einsum(
        "ij,ij->i", *(one.signed_distance_gradient(points)[1] for one in (mesh, sphere))
    )
    away = np.abs(sphere.signed_distance(points)) > 0.1
    assert toward[away & (np.linalg.norm(points - (1, 2, 3), axis=1) > 0.3)].min() > 0.9


@pytest.mark.slow
@settings(max_examples=8)
@given(names, seeds)
def test_distances_are_those_of_the_nearest_triangle(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    shape = MeshShape.of(SURFACES[name], **pose(rng))
    points = around(shape, rng, 20)
    expected = to_triangles(points, shape.triangles())
    found = shape.signed_distance(points)
    np.testing.assert_allclose(np.abs(found), expected, atol=1e-9 * size(shape))
    if not shape.closed:
        assert found.min() >= 0


@settings(max_examples=30)
@given(names, seeds)
def test_the_signed_distance_is_1_lipschitz(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    shape = MeshShape.of(SURFACES[name], **pose(rng))
    a = around(shape, rng, 200)
    b = a + rng.normal(size=a.shape) * size(shape) * 10.0 ** rng.uniform(-8, 0, (len(a), 1))
    way = np.linalg.norm(b - a, axis=1)
    change = np.abs(shape.signed_distance(a) - shape.signed_distance(b))
    assert (change <= way + 1e-9 * size(shape)).all()


@settings(max_examples=30)
@given(names, seeds)
def test_bounds_of_the_grid_hold_the_distance(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    shape = MeshShape.of(SURFACES[name])
    points = around(shape, rng, 200)
    lower, upper = shape.distance_bounds(points)
    exact = shape.signed_distance(points)
    assert (lower <= exact).all()
    assert (exact <= upper).all()


@settings(max_examples=15)
@given(names, seeds)
def test_python_answers_by_a_coarse_grid_what_the_kernel_does_by_a_fine_one(
    name: str, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    shape, empty = MeshShape.of(SURFACES[name], **pose(rng)), np.empty(0)
    coarse, fine = (surface_tables(shape.surface, fine) for fine in (False, True))
    on = shape.placed[1]
    assert len(coarse.grid.values) < len(fine.grid.values) / 10
    p = around(shape, rng, 3)
    q = p + rng.normal(size=p.shape) * size(shape) * 10.0 ** rng.uniform(-3, 0, (len(p), 1))
    ends, count, tolerance = (flat(p), flat(q)), len(p), 1e-8 * size(shape)

    exact, found, upper = shape.signed_distance(p), np.empty(count), np.empty(count)
    kernels.measure.interpret(coarse, on, kernels.BOUNDS, ends, found, upper, new_room())
    assert (found <= exact + tolerance).all()
    assert (exact <= upper + tolerance).all()
    kernels.measure.interpret(coarse, on, kernels.DISTANCES, ends, found, empty, new_room())
    np.testing.assert_allclose(found, exact, atol=tolerance)
    # inside, either is a lower bound and off by at most a 64th of the length
    least = np.full(count, np.inf)
    kernels.measure.interpret(coarse, on, kernels.LEAST, ends, least, empty, new_room())
    off = np.where(least < 0, np.linalg.norm(q - p, axis=1) / 64, 0.0) + tolerance
    assert (np.abs(least - shape.segment_distance(p, q)) <= off).all()
    margins = np.abs(exact) * rng.uniform(0, 2, count)
    blocked, sure = margins.copy(), np.abs(least - margins) > off
    kernels.measure.interpret(coarse, on, kernels.BLOCKED, ends, blocked, empty, new_room())
    assert (blocked == shape.blocks(p, q, margins))[sure].all()


@settings(max_examples=20)
@given(names, seeds)
def test_bounds_of_the_grid_hold_the_distance_along_a_segment(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    shape, room = MeshShape.of(SURFACES[name]), new_room()
    tables, placement = shape.placed
    p = around(shape, rng, 10)
    q = p + rng.normal(size=p.shape) * size(shape) * 10.0 ** rng.uniform(-3, 0, (len(p), 1))
    q[0] = p[0]
    exact = shape.segment_distance(p, q) / placement.factor
    for k, most in enumerate(exact + rng.normal(size=len(p)) * tables.grid.step):
        begin, end = (to_surface(placement, tuple(x[k].tolist())) for x in (p, q))
        lower, upper = bounds_along(tables, begin, end, most, room)
        assert lower <= exact[k] + 1e-8 * tables.extent
        assert upper >= exact[k] - 1e-8 * tables.extent


@settings(max_examples=30)
@given(names, seeds)
def test_moving_mesh_and_points_together_changes_nothing(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    still, moved = MeshShape.of(SURFACES[name]), MeshShape.of(SURFACES[name], **pose(rng))
    points = around(still, rng, 50)
    turn = world_from_body(moved)[:3, :3] * moved.scale
    there = points @ turn.T + world_from_body(moved)[:3, 3]
    tolerance = 1e-9 * size(moved)

    expected = still.signed_distance(points) * moved.scale
    np.testing.assert_allclose(moved.signed_distance(there), expected, atol=tolerance)
    low, high = moved.bounds()
    corners = moved.triangles()
    np.testing.assert_allclose(corners.min(axis=(0, 1)), low, atol=tolerance)
    np.testing.assert_allclose(corners.max(axis=(0, 1)), high, atol=tolerance)


@pytest.mark.slow
@settings(max_examples=10)
@given(names, seeds)
def test_no_sample_of_a_segment_is_nearer_than_its_distance(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    shape = MeshShape.of(SURFACES[name], **pose(rng))
    p = around(shape, rng, 20)
    q = p + rng.normal(size=p.shape) * size(shape) * 10.0 ** rng.uniform(-2, 0, (len(p), 1))
    q[:3] = p[:3]
    length = np.linalg.norm(q - p, axis=1)
    share = np.linspace(0, 1, 201)[:, None, None]
    samples = (p + share * (q - p)).reshape(-1, 3)
    sampled = shape.signed_distance(samples).reshape(201, -1).min(axis=0)
    tolerance = 1e-8 * size(shape)

    found = shape.segment_distance(p, q)
    assert (found <= sampled + tolerance).all()
    assert (found >= sampled - length / 64 - tolerance).all()
    margins = sampled + rng.normal(size=len(p)) * 0.1 * size(shape)
    blocked = ObstacleSet((shape,)).blocked(p, q, margins)
    assert blocked[(sampled < margins) & (margins > 0)].all()
    # and none is blocked for nothing: sampling misses no more than half a step
    assert not blocked[sampled - length / 400 > np.maximum(margins, 0) + tolerance].any()


def test_nothing_passes_through_an_open_surface() -> None:
    rng = np.random.default_rng(0)
    shape = MeshShape.of(OPEN_BOX)
    outside = rng.normal(size=(300, 3))
    outside *= 4 / np.abs(outside).max(axis=1, keepdims=True)
    through = outside / np.abs(outside).max(axis=1, keepdims=True)
    hole = shape.surface.vertices[meshes.box((2, 2, 2))[1][-2:]].mean(axis=(0, 1))
    toward_hole = through @ hole >= 1 - 1e-12
    at_the_rim = (through @ hole > 0.99) & ~toward_hole
    blocked = ObstacleSet((shape,)).blocked(np.zeros_like(outside), outside, 1e-6)
    np.testing.assert_array_equal(blocked[~at_the_rim], ~toward_hole[~at_the_rim])
    assert toward_hole.any()


def test_the_gradient_climbs_at_rate_1() -> None:
    rng = np.random.default_rng(3)
    for surface in SURFACES.values():
        shape = MeshShape.of(surface, **pose(rng))
        points = around(shape, rng, 300)
        gradient = shape.signed_distance_gradient(points)[1]
        np.testing.assert_allclose(np.linalg.norm(gradient, axis=1), 1)
        step = 1e-6 * size(shape)
        rise = shape.signed_distance(points + step * gradient) - shape.signed_distance(points)
        off = np.abs(shape.signed_distance(points)) > 10 * step
        # towards the surface exactly; inside, the medial axis may be nearer than the step
        assert np.mean(rise[off] > step * (1 - 1e-3)) > 0.98
    on = MeshShape.of(BOX)
    np.testing.assert_allclose(
        np.abs(on.signed_distance_gradient(np.array([[1.0, 0.1, 0.2]]))[1]), [[1, 0, 0]]
    )


def test_nearest_of_a_mesh_among_others() -> None:
    points = np.random.default_rng(0).uniform(-4, 4, (100, 3))
    mesh, ball = MeshShape.of(BOX), Sphere(radius=1, position=(3, 0, 0))
    distance, index = ObstacleSet((ball, mesh)).nearest(points)
    both = np.stack([ball.signed_distance(points), mesh.signed_distance(points)])
    np.testing.assert_allclose(distance, both.min(axis=0), atol=1e-14)
    np.testing.assert_array_equal(index, both.argmin(axis=0))


def test_the_nodes_excluded_are_those_too_near() -> None:
    mesh = tetrahedralise(Workspace(), MeshSettings(pitch=0.5))
    for surface in SURFACES.values():
        shape = MeshShape.of(surface, position=(3, 3, 3), wxyz=(1, 0.3, 0.2, 0))
        free = exclude(mesh, ObstacleSet((shape,)), 0.2)
        np.testing.assert_array_equal(free.excluded, shape.signed_distance(mesh.points) < 0.2)
        assert 0 < free.excluded.sum() < len(mesh.points)


def test_no_points_and_no_segments() -> None:
    for surface in SURFACES.values():
        shape, none = MeshShape.of(surface), np.empty((0, 3))
        for found in (
            shape.signed_distance(none),
            shape.signed_distance_gradient(none)[1],
            shape.segment_distance(none, none),
            shape.blocks(none, none, np.empty(0)),
        ):
            assert len(found) == 0


# --- in scenes

DATA: dict[str, Any] = {
    "version": 1,
    "obstacles": [{"shape": "mesh", "file": "parts/blob.stl", "position": [3, 3, 3]}],
}
FILES = {"parts/blob.stl": meshes.stl(meshes.bumpy(3)), "box.stl": meshes.stl(meshes.box())}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    inner = tmp_path / "scenes"
    (inner / "parts").mkdir(parents=True)
    (tmp_path / "outside.stl").write_bytes(FILES["box.stl"])
    for name, content in FILES.items():
        (inner / name).write_bytes(content)
    Scene.from_dict(DATA, FILES).save(inner / "scene.yaml")
    return inner


def test_a_scene_file_finds_the_meshes_beside_it(folder: Path) -> None:
    scene = load_scene(folder / "scene.yaml")
    assert scene == Scene.from_dict(DATA, FILES) == Scene.from_dict(DATA, folder)
    assert hash(scene) == hash(Scene.from_dict(DATA, FILES))
    assert scene.to_dict()["obstacles"][0]["file"] == "parts/blob.stl"
    assert Scene.from_dict(scene.to_dict(), folder) == scene
    made = Planner()(scene)
    assert made.error is None
    assert made.path_clearance >= scene.spline.clearance


def test_a_changed_scene_keeps_its_surfaces(folder: Path) -> None:
    scene = load_scene(folder / "scene.yaml")
    (folder / "parts/blob.stl").unlink()
    moved = scene.replace(obstacles=[{**scene.to_dict()["obstacles"][0], "position": [2, 3, 3]}])
    again = moved.replace(obstacles=scene.to_dict()["obstacles"])
    assert moved != scene
    assert again == scene
    assert hash(again) == hash(scene)
    other = scene.replace(start=[0.1, 0.0, 0.0])
    assert other.obstacles == scene.obstacles
    assert other.obstacles[0].surface is scene.obstacles[0].surface
    added = {"shape": "mesh", "file": "box.stl"}
    both = scene.replace(FILES, obstacles=[*scene.to_dict()["obstacles"], added])
    assert len(both.replace(goal=[6.0, 6.0, 5.0]).obstacles) == 2
    with pytest.raises(SceneError) as caught:
        scene.replace(obstacles=[added])
    assert caught.value.field == "obstacles[0].file"


def test_other_content_is_another_scene() -> None:
    other = {**FILES, "parts/blob.stl": meshes.stl(meshes.bumpy(3, seed=1))}
    assert Scene.from_dict(DATA, FILES) != Scene.from_dict(DATA, other)
    mixed = [*Scene.from_dict(DATA, FILES).obstacles, *Scene.from_dict(DATA, other).obstacles]
    with pytest.raises(SceneError, match="other content"):
        Scene(version=1, obstacles=tuple(mixed))


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("../outside.stl", "inside the scene's folder"),
        ("parts/../../outside.stl", "inside the scene's folder"),
        ("/etc/passwd.stl", "inside the scene's folder"),
        ("parts//blob.stl", "inside the scene's folder"),
        ("./box.stl", "inside the scene's folder"),
        ("link.stl", "not a link out of it"),
        ("linked/outside.stl", "not a link out of it"),
        ("C:\\box.stl", "plain name"),
        ("file:///box.stl", "plain name"),
        ("box\n.stl", "plain name"),
        ("parts/missing.stl", "can be read"),
        ("loop.stl", "can be read"),
        ("parts.stl", "not a folder"),
        ("scene.yaml", "ends in .stl"),
        ("box", "ends in .stl"),
        ("broken.stl", "cut off"),
        ("box.obj", "text"),
    ],
)
def test_a_mesh_file_is_in_the_folder_and_whole(folder: Path, name: str, words: str) -> None:
    (folder / "link.stl").symlink_to(folder.parent / "outside.stl")
    (folder / "linked").symlink_to(folder.parent)
    (folder / "loop.stl").symlink_to(folder / "loop.stl")
    (folder / "parts.stl").mkdir()
    (folder / "broken.stl").write_bytes(FILES["box.stl"][:-1])
    (folder / "box.obj").write_bytes(FILES["box.stl"])
    (folder / "inner.stl").symlink_to(folder / "box.stl")
    data = {**DATA, "obstacles": [{"shape": "sphere", "radius": 1.0}, {"shape": "mesh"}]}
    data["obstacles"][1]["file"] = "inner.stl"
    assert len(Scene.from_dict(data, folder).obstacles) == 2

    data["obstacles"][1]["file"] = name
    with pytest.raises(SceneError) as caught:
        Scene.from_dict(data, folder)
    assert caught.value.field == "obstacles[1].file"
    assert words in caught.value.message
    assert "\n" not in caught.value.message


def test_a_pipe_is_not_waited_for(folder: Path) -> None:
    os.mkfifo(folder / "pipe.stl")
    data = {**DATA, "obstacles": [{"shape": "mesh", "file": "pipe.stl"}]}
    with pytest.raises(SceneError, match="a file, not"):
        Scene.from_dict(data, folder)


def test_a_scene_without_files_says_what_is_missing() -> None:
    for given_, words in ((None, "to be given too"), ({"box.stl": b"x"}, "box.stl")):
        with pytest.raises(SceneError) as caught:
            Scene.from_dict(DATA, given_)
        assert caught.value.field == "obstacles[0].file"
        assert words in caught.value.message


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"file": 3}, "obstacles[0].file"),
        ({"file": ""}, "obstacles[0].file"),
        ({"unit": "inch"}, "obstacles[0].unit"),
        ({"scale": 0}, "obstacles[0].scale"),
        ({"scale": True}, "obstacles[0].scale"),
        ({"scale": 1e6}, "obstacles[0].scale"),
        ({"colour": "red"}, "obstacles[0].colour"),
        ({"wxyz": [0, 0, 0, 0]}, "obstacles[0].wxyz"),
    ],
)
def test_wrong_fields_are_named(change: dict[str, Any], field: str) -> None:
    data = {**DATA, "obstacles": [{**DATA["obstacles"][0], **change}]}
    with pytest.raises(SceneError) as caught:
        Scene.from_dict(data, FILES)
    assert caught.value.field == field


def test_units_of_the_file_and_of_the_scene() -> None:
    for scene_unit, file_unit, factor in (
        ("cm", None, 1.0), ("m", "mm", 1e-3), ("mm", "m", 1e3), ("cm", "cm", 1.0), ("cm", "m", 100)
    ):  # fmt: skip
        mesh = {"shape": "mesh", "file": "box.stl", "unit": file_unit, "scale": 2.0}
        scene = Scene.from_dict({"version": 1, "unit": scene_unit, "obstacles": [mesh]}, FILES)
        low, high = scene.obstacles[0].bounds()
        np.testing.assert_allclose(high - low, 2 * factor)
    metres = scene.replace(unit="m")
    np.testing.assert_allclose(np.ptp(metres.obstacles[0].bounds(), axis=0), 2)
    np.testing.assert_allclose(np.ptp(scene.obstacles[0].bounds(), axis=0), 200)


def far(corner: tuple[float, float, float], side: float = 10.0) -> bytes:
    vertices, faces = meshes.box((side, side, side))
    return meshes.stl((vertices - vertices.min(axis=0) + np.array(corner), faces))


@pytest.mark.parametrize(
    ("corner", "change", "field"),
    [
        ((500_000, 540_000, 300), {"unit": "m"}, "file"),
        ((-500_000, 0, 0), {"scale": 4.1}, "file"),
        ((500_000, 540_000, 300), {"scale": 3.0}, "position"),
        ((-500_000, -540_000, 300), {"scale": 3.0, "wxyz": [1, 0.2, 0, 0.1]}, "position"),
        ((0, 0, 0), {"position": [0, 999_995, 0]}, "position"),
        ((0, 0, 0), {"position": [0, 999_990, 0]}, None),
        ((500_000, 540_000, 300), {}, None),
    ],
)
def test_a_mesh_far_from_the_origin_is_refused_with_a_place_that_works(
    corner: tuple[float, float, float], change: dict[str, Any], field: str | None
) -> None:
    entry = {"shape": "mesh", "file": "far.stl", **change}
    data = {"version": 1, "unit": "cm", "obstacles": [entry]}
    files = {"far.stl": far(corner)}
    if field is None:
        assert np.abs(Scene.from_dict(data, files).obstacles[0].bounds()).max() <= 1e6
        return
    with pytest.raises(SceneError) as caught:
        Scene.from_dict(data, files)
    assert caught.value.field == f"obstacles[0].{field}"
    assert "±1e+06 is the limit" in caught.value.message
    if field == "position":
        told = re.search(r"like \((.*?)\)", caught.value.expected)
        assert told is not None
        place = [float(number) for number in told[1].split(",")]
        nearer = {**data, "obstacles": [{**entry, "position": place}]}
        assert np.abs(Scene.from_dict(nearer, files).obstacles[0].bounds()).max() <= 1e6


def test_a_mesh_too_large_only_as_it_is_turned_is_refused() -> None:
    half = {"shape": "mesh", "file": "cube.stl", "position": [0, 0, 600_000]}
    turned = {**half, "wxyz": [math.cos(math.pi / 8), 0, 0, math.sin(math.pi / 8)]}
    files = {"cube.stl": far((-480_000, -480_000, 0), 960_000)}
    data: dict[str, Any] = {"version": 1, "obstacles": [{**half, "position": [0, 0, 0]}]}
    assert Scene.from_dict(data, files).obstacles
    with pytest.raises(SceneError, match="as it is turned") as caught:
        Scene.from_dict({**data, "obstacles": [turned]}, files)
    assert caught.value.field == "obstacles[0].scale"

    fitting = {**turned, "scale": 0.7, "position": [0, 0, 300_000]}
    scene = Scene.from_dict({**data, "obstacles": [fitting]}, files)
    assert np.ptp(scene.obstacles[0].bounds(), axis=0).max() <= 1e6


@settings(max_examples=25)
@given(seeds)
def test_what_a_scene_accepts_can_be_planned_however_far_or_large(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scale = float(10 ** rng.uniform(-1, 5))
    entry = {
        "shape": "mesh",
        "file": "far.stl",
        "scale": scale,
        "position": rng.uniform(-1e6, 1e6, 3).tolist(),
        "wxyz": rng.normal(size=4).tolist(),
    }
    corner = rng.uniform(-1e5, 1e5, 3) / max(scale, 1.0)
    files = {"far.stl": far(tuple(corner.tolist()))}
    try:
        scene = Scene.from_dict({"version": 1, "obstacles": [entry]}, files)
    except SceneError:
        reject()
    made = Planner()(scene)
    assert made.path is None or made.taut is not None


@pytest.mark.parametrize(
    ("extent", "unit", "suggested"),
    [
        (3.0, "cm", None),
        (119.0, "cm", None),
        (121.0, "cm", "mm"),
        (3000.0, "m", "mm"),
        (300.0, "m", "cm"),
        (0.013, "cm", None),
        (0.005, "cm", "m"),
        (0.005, "mm", "m"),
        (1e9, "m", None),
        (3000.0, "mm", None),
    ],
)
def test_a_mesh_out_of_scale_suggests_its_unit(
    extent: float, unit: str, suggested: str | None
) -> None:
    assert suggest_unit(extent, (6.0, 5.0, 4.0), METRES[unit]) == suggested


def test_shapes_from_a_surface_compare_by_content() -> None:
    a, b = MeshShape.of(BOX, "a.stl"), MeshShape.of(clean(*meshes.box((2, 1, 3))), "a.stl")
    assert a == b
    assert hash(a) == hash(b)
    assert a != MeshShape.of(BLOB, "a.stl")
    assert a != MeshShape.of(BOX, "b.stl")
    assert a.closed
    assert isinstance(a.surface, Surface)


@pytest.mark.parametrize("vertices", [2, 3, 4])
def test_a_graded_spline_passes_a_mesh(vertices: int) -> None:
    mesh = MeshShape.of(BOX, position=(3, 3, 3))
    far = float(np.linalg.norm(np.ptp(np.array(mesh.bounds()), axis=0))) + 4
    bend = np.linspace(0, 1, vertices)
    path = np.stack([far * (2 * bend - 1), far + bend * (1 - bend), 0 * bend], axis=1) + 3

    spline = fit(path, 4, ObstacleSet((mesh,)), 0.2, taut=True)

    assert spline.holds
    assert ObstacleSet((mesh,)).polyline_clearance(path) >= spline.clearance.distance > 0.2
