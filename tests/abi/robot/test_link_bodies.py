from __future__ import annotations

import numpy as np
import pytest
import scipy
import trimesh
from hypothesis import example, given
from hypothesis import strategies as st

from abi.arrays import FloatArray
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.bodies.bounding_capsules import capsule_volume, smallest_capsule
from abi.robot.bodies.link_bodies import Body, Fit, link_bodies
from abi.robot.urdf.link import Link
from abi.robot.urdf.robot_files import SHIPPED, load_robot, robot_from_archive
from tests.abi.robot.robots import arm, packed


def lacks(bodies: tuple[Body, ...], points: FloatArray) -> float:
    """Largest distance by which points stick out of all bodies, of capsule or hull."""
    away = np.full(len(points), np.inf)
    for (low, high), radius, corners, rounding, _, _ in bodies:
        way = high - low
        share = np.clip((points - low) @ way / max(float(way @ way), 1e-300), 0, 1)
        of_capsule = np.linalg.norm(points - low - share[:, None] * way, axis=1) - radius
        if len(corners) == 1:
            of_hull = np.linalg.norm(points - corners[0], axis=1) - rounding
        else:
            sides = scipy.spatial.ConvexHull(corners).equations
            of_hull = (points @ sides[:, :3].T + sides[:, 3]).max(axis=1) - rounding
        away = np.minimum(away, np.maximum(of_capsule, of_hull))
    return float(away.max())


def surface(link: Link) -> FloatArray:
    """Points on a link's shapes, made by another way than ours."""
    parts = []
    for shape in link.shapes:
        radius, length, _ = shape.size
        if shape.kind == "mesh":
            solid = trimesh.Trimesh(shape.vertices, shape.faces, process=False)
        elif shape.kind == "box":
            solid = trimesh.creation.box(shape.size)
        elif shape.kind == "sphere":
            solid = trimesh.creation.icosphere(4, radius)
        else:
            solid = trimesh.creation.cylinder(radius, length, sections=97)
        points = np.concatenate([solid.sample(2000, seed=1), solid.vertices])
        parts.append(points @ shape.pose[:3, :3].T + shape.pose[:3, 3])
    return np.concatenate(parts)


@given(st.integers(0, 10**6))
@example(785)
@example(974)
def test_a_capsule_holds_its_points(seed: int) -> None:
    points = np.random.default_rng(seed).uniform(-1, 1, (8, 3))
    (low, high), radius = smallest_capsule(points)
    way = high - low
    share = np.clip((points - low) @ way / max(float(way @ way), 1e-300), 0, 1)
    assert np.linalg.norm(points - low - share[:, None] * way, axis=1).max() <= radius


@pytest.mark.parametrize("name", SHIPPED)
def test_bodies_contain_the_links(name: str) -> None:
    for link in load_robot(name, MeshSource()).links.values():
        bodies = link_bodies(link)
        assert bool(bodies) == bool(link.shapes)
        if bodies:
            assert lacks(bodies, surface(link)) <= 1e-9


@pytest.mark.parametrize(
    "shape",
    ['<sphere radius="0.2"/>', '<cylinder radius="0.1" length="0.5"/>', '<box size="1 0.1 0.2"/>'],
)
def test_bodies_contain_primitives_and_are_hardly_larger(shape: str) -> None:
    text = arm(
        ('<box size="0.1 0.1 0.3"/>', shape), ("<geometry>", "<origin rpy='1 2 3'/><geometry>")
    )
    link = robot_from_archive(packed({"a.urdf": text})).links["a"]
    (body,) = link_bodies(link)
    size = {"s": 4 / 3 * np.pi * 0.2**3, "c": np.pi * 0.01 * 0.5, "b": 0.02}[shape[1]]

    assert lacks((body,), surface(link)) <= 1e-9
    assert capsule_volume(body.ends, body.radius) < 2.5 * size
    if len(body.points) == 1:
        assert body.rounding == pytest.approx(0.2)
    else:
        hull = scipy.spatial.ConvexHull(body.points)
        # by Steiner's formula a rounding adds about this
        assert hull.volume + 1.1 * hull.area * body.rounding < 1.04 * size


@pytest.mark.parametrize("shape", ["sphere", "cylinder", "box"])
def test_bodies_are_as_large_as_their_shapes_however_small(shape: str) -> None:
    reach = []
    for size in (0.3, 1e-4, 1e-6):
        sizes = {"sphere": f'radius="{size}"', "box": f'size="{size} {size} {2 * size}"'}
        written = sizes.get(shape, f'radius="{size}" length="{2 * size}"')
        text = arm(('<box size="0.1 0.1 0.3"/>', f"<{shape} {written}/>"))
        bodies = link_bodies(robot_from_archive(packed({"a.urdf": text})).links["a"])
        corners = np.concatenate([one.points for one in bodies])
        reach.append((np.ptp(corners, axis=0) + 2 * max(one.rounding for one in bodies)) / size)
    np.testing.assert_allclose(reach[1:], [reach[0]] * 2, rtol=0.03)


FITS: tuple[tuple[Fit, int, float], ...] = (
    ("quick", 6, 1.5),
    ("finer", 12, 1.3),
    ("close", 24, 1.1),
)
"""How many pieces there may be of each fit, and how much larger than what is bent."""


def bent(*boxes: tuple[float, ...]) -> trimesh.Trimesh:
    """Boxes, by their extents and centres, as one closed surface."""
    parts = []
    for box in boxes:
        one = trimesh.creation.box(box[:3])
        one.apply_translation(box[3:])
        parts.append(one)
    union = trimesh.boolean.union(parts, engine="manifold")
    assert isinstance(union, trimesh.Trimesh)
    return union


def test_what_is_bent_is_cut_into_pieces_that_fill_it() -> None:
    solid = bent((1, 0.1, 0.1, 0, 0, 0), (0.1, 0.1, 1, 0.45, 0, 0.45), (0.1, 0.5, 0.1, 0, 0.2, 0))
    content = solid.export(file_type="stl")
    assert isinstance(content, bytes)
    text = arm(('<box size="0.1 0.1 0.3"/>', '<mesh filename="a.stl"/>'))
    files: dict[str, str | bytes] = {"a.urdf": text, "a.stl": content}
    link = robot_from_archive(packed(files)).links["a"]
    points = np.concatenate([surface(link), trimesh.sample.volume_mesh(solid, 5000)])
    for fit, most, larger in FITS:
        bodies = link_bodies(link, fit)
        assert lacks(bodies, points) <= 1e-9
        volumes = [scipy.spatial.ConvexHull(body.points).volume for body in bodies]
        assert sum(volumes) < larger * solid.volume
        assert len(bodies) <= most
    assert 1.5 * solid.volume < 0.4 * solid.convex_hull.volume


def test_many_balls_are_kept_as_given() -> None:
    balls = [(0.05 * k, 0.1, 0.02 * k, 0.03 + 0.001 * k) for k in range(10)]
    shapes = "".join(
        f'<collision><origin xyz="{x} {y} {z}"/><geometry><sphere radius="{r}"/></geometry>'
        "</collision>"
        for x, y, z, r in balls
    )
    text = arm(('<collision><geometry><box size="0.1 0.1 0.3"/></geometry></collision>', shapes))
    bodies = link_bodies(robot_from_archive(packed({"a.urdf": text})).links["a"])
    found = [(*body.points[0].tolist(), body.rounding) for body in bodies]
    assert found == [pytest.approx(ball) for ball in balls]
    assert all(len(body.points) == 1 for body in bodies)
