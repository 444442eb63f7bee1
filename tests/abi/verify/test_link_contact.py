"""Links touch for the verifier where they touch for the planner, which shares no code with it."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from abi.arrays import FloatArray
from abi.robot.bodies import solid_contact
from abi.robot.bodies.link_solids import link_solids
from abi.robot.urdf.link import Link, LinkShape
from abi.verify.exact.mesh import ExactMesh
from abi.verify.exact.solids import vector
from abi.verify.link_contact import holds, link_triangles, solid_triangles, touch
from abi.verify.plumb_line import is_beneath

MESHES = (
    trimesh.creation.annulus(0.05, 0.12, 0.1),
    trimesh.creation.icosphere(subdivisions=1, radius=0.1),
    trimesh.creation.torus(0.12, 0.03, major_sections=12, minor_sections=8),
)


Kind = Literal["box", "sphere", "cylinder"]


def shape_of(kind: Kind, size: tuple[float, float, float], pose: FloatArray) -> LinkShape:
    none = np.zeros((0, 3))
    return LinkShape(kind, size, pose, none, none.astype(np.int32), none.astype(np.uint8))


def mesh_of(mesh: trimesh.Trimesh, pose: FloatArray) -> LinkShape:
    faces = np.asarray(mesh.faces, dtype=np.int32)
    none = np.zeros((0, 3), dtype=np.uint8)
    return LinkShape("mesh", (1.0, 1.0, 1.0), pose, np.array(mesh.vertices), faces, none)


def link_of(*shapes: LinkShape) -> Link:
    return Link("l", shapes, 0.0, np.zeros(3), np.zeros((3, 3)))


def random_shape(random: np.random.Generator) -> LinkShape:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(random_state=random).as_matrix()
    pose[:3, 3] = 0.1 * random.normal(size=3)
    kind = random.choice(["box", "sphere", "cylinder", "mesh"])
    if kind == "mesh":
        return mesh_of(MESHES[random.integers(len(MESHES))], pose)
    a, b, c = random.uniform(0.03, 0.3, 3).tolist()
    if kind == "box":
        return shape_of("box", (a, b, c), pose)
    if kind == "sphere":
        return shape_of("sphere", (a / 2, 0.0, 0.0), pose)
    return shape_of("cylinder", (a / 2, b, 0.0), pose)


def test_planner_and_verifier_find_the_same_links_in_contact() -> None:
    random = np.random.default_rng(5)
    solid_contact.compile_kernels()
    touching = 0
    for _ in range(120):
        first, second = (
            link_of(*(random_shape(random) for _ in range(random.integers(1, 3)))) for _ in "ab"
        )
        turn = Rotation.random(random_state=random).as_matrix()
        origin = 0.15 * random.normal(size=3)
        solids = link_solids(first, 1.0), link_solids(second, 1.0)
        expected = solid_contact.touch(*solids, turn, origin)
        placed = link_triangles(second, 1.0).placed(turn, origin)
        assert touch(link_triangles(first, 1.0), placed) == expected
        assert touch(placed, link_triangles(first, 1.0)) == expected
        touching += expected
    assert 20 < touching < 100


@pytest.mark.parametrize("scale", [1.0, 1000.0])
@pytest.mark.parametrize(
    ("gap", "near", "expected"),
    [
        (0.0, 1e-6, True),
        (1e-4, 1e-6, False),
        (0.0, -1e-9, False),
        (-0.1, -1e-9, True),
        (-0.2, -1e-9, True),
    ],
)
def test_faces_that_lie_on_each_other_touch(
    scale: float, gap: float, near: float, expected: bool
) -> None:
    """Where depth is asked for, solids in each other have it, though all their sides are flush."""
    box = link_of(shape_of("box", (0.2, 0.2, 0.2), np.eye(4)))
    lying = link_triangles(box, scale).placed(np.eye(3), np.array([0, 0, scale * (0.2 + gap)]))
    assert touch(link_triangles(box, scale), lying, near) == expected
    if near < 0:  # as where they are to be in each other
        both, way = link_solids(box, scale), np.array([0.0, 0.0, scale * (0.2 + gap)])
        assert solid_contact.touch(both, both, np.eye(3), way) == expected
        deep = solid_contact.depth(both, both, np.eye(3), way)
        assert deep == pytest.approx(scale * min(-gap, 0.1) if expected else 0.0, abs=1e-9)


def test_what_is_inside_touches_also_in_a_cavity_but_not_in_an_open_shell() -> None:
    ball = link_of(shape_of("sphere", (0.02, 0.0, 0.0), np.eye(4)))
    outer = trimesh.creation.box((1.0, 1.0, 1.0))
    inner = trimesh.creation.box((0.5, 0.5, 0.5))
    inner.invert()
    opened = trimesh.Trimesh(outer.vertices, outer.faces[2:])
    corners = np.concatenate([outer.vertices, inner.vertices])
    hollow = trimesh.Trimesh(corners, np.concatenate([outer.faces, inner.faces + 8]))
    for mesh, expected in ((outer, True), (hollow, True), (opened, False)):
        found = touch(
            link_triangles(link_of(mesh_of(mesh, np.eye(4))), 1.0), link_triangles(ball, 1.0)
        )
        assert found == expected


@pytest.mark.parametrize("closed", [False, True])
def test_only_a_closed_obstacle_has_an_inside(closed: bool) -> None:
    """However small the hole of another is."""
    dome = trimesh.creation.icosphere(subdivisions=5, radius=3.0)
    faces = np.asarray(dome.faces, dtype=np.int32)[0 if closed else 1 :]
    place = vector((0.0, 0.0, 0.0)), (1.0, 0.0, 0.0, 0.0)
    obstacle = ExactMesh(np.array(dome.vertices), faces, closed, 1.0, *place)
    link = link_triangles(link_of(shape_of("box", (0.1, 0.1, 0.1), np.eye(4))), 1.0)
    assert holds(solid_triangles(obstacle), link) == closed


def test_what_one_layer_winds_around_is_inside_though_another_takes_it_away() -> None:
    """A larger box inside out that has a corner in common with the smaller one."""
    box, around = (trimesh.creation.box(bounds=[[0, 0, 0], [size] * 3]) for size in (1, 2))
    vertices = np.concatenate([box.vertices, around.vertices])
    faces = np.concatenate([box.faces, around.faces[:, ::-1] + 8]).astype(np.int32)
    place = vector((-0.5, -0.5, -0.5)), (1.0, 0.0, 0.0, 0.0)
    obstacle = ExactMesh(vertices, faces, True, 1.0, *place, layers=(12, 12))
    link = link_triangles(link_of(shape_of("box", (0.1, 0.1, 0.1), np.eye(4))), 1.0)
    assert holds(solid_triangles(obstacle), link)


@pytest.mark.parametrize("x", [0.0, 1.0])
def test_a_face_in_a_plane_along_the_plumb_line_is_not_beneath_the_base(x: float) -> None:
    """It is where the line runs along the obstacle's side and meets its top."""
    box = trimesh.creation.box(bounds=[[x, 0, -1], [x + 1, 1, 0]])
    place = vector((0.0, 0.0, 0.0)), (1.0, 0.0, 0.0, 0.0)
    obstacle = ExactMesh(np.array(box.vertices), box.faces.astype(np.int32), True, 1.0, *place)
    assert is_beneath(obstacle, np.zeros(3), place[1], 1.0) == (x == 0)
