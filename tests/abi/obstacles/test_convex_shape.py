"""A shape's own description is enough for every stage to measure, pass and draw it."""

from __future__ import annotations

import math
from typing import Literal, Self

import numpy as np
import pytest
import trimesh

from abi.arrays import FloatArray, IntArray
from abi.curves.clearance.certificate import Certificate, certify
from abi.export.solids import solids
from abi.obstacles.convex_shape import ConvexShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.packing import pack
from abi.obstacles.pose import Length, Vec3
from abi.obstacles.primitive_kernels import Core
from abi.obstacles.primitives import PRIMITIVES, Box
from abi.scene.settings import Workspace
from abi.search.taut.lower_bound import lower_bound
from abi.search.taut.obstacle_edges import obstacle_edges
from tests.abi.bezier import polyline
from tests.abi.shape_distances import segment_distance

ROOMY = Workspace(min=(-50.0, -50.0, -50.0), max=(50.0, 50.0, 50.0))


class RoundedBox(ConvexShape):
    """A shape that the package does not have: all points within a radius of a box."""

    shape: Literal["rounded_box"] = "rounded_box"
    size: tuple[Length, Length, Length]
    radius: Length

    @classmethod
    def of_length(cls, length: float, position: Vec3) -> Self:
        return cls(size=(length, length, length), radius=length / 10, position=position)

    def core(self) -> Core:
        x, y, z = self.size
        return Core(x / 2, y / 2, z / 2, self.radius, 0.0)

    def surface(self, sides: int) -> tuple[FloatArray, IntArray]:
        return Box(size=self.size).surface(sides)


def rounded_box_and_box(random: np.random.Generator) -> tuple[RoundedBox, Box, float]:
    """The two, of one size and pose, and the radius around the first."""
    position, size = random.uniform(-1, 1, 3).tolist(), random.uniform(0.4, 2, 3).tolist()
    wxyz = random.normal(size=4).tolist()
    radius = float(random.uniform(0.05, 0.5))
    pose = {"position": position, "wxyz": wxyz, "size": size}
    return (
        RoundedBox.model_validate({**pose, "radius": radius}),
        Box.model_validate(pose),
        radius,
    )


@pytest.mark.parametrize("seed", range(10))
def test_a_box_with_a_radius_is_a_box_with_more_clearance(seed: int) -> None:
    random = np.random.default_rng(seed)
    rounded, box, radius = rounded_box_and_box(random)
    p, q = random.uniform(-4, 4, (2, 200, 3))
    of_rounded, of_box = (ObstacleSet((one,)) for one in (rounded, box))  # type: ignore[arg-type]
    for points in (p, q):
        distance = box.signed_distance(points) - radius
        np.testing.assert_allclose(rounded.signed_distance(points), distance, atol=1e-12)
        np.testing.assert_allclose(of_rounded.nearest(points)[0], distance, atol=1e-12)
    least = segment_distance(box, p, q) - radius
    np.testing.assert_allclose(segment_distance(rounded, p, q), least, atol=1e-12)
    ahead: Vec3 = (1.0, 2.0, 3.0)
    edges = (
        obstacle_edges((rounded,), 0.1, ahead),  # type: ignore[arg-type]
        obstacle_edges((box,), 0.1 + radius, ahead),
    )
    np.testing.assert_allclose(*edges, atol=1e-6)
    for start, goal in zip(p[:40], q[:40], strict=True):
        ends: tuple[Vec3, Vec3] = (tuple(start.tolist()), tuple(goal.tolist()))
        found = lower_bound(*ends, of_rounded, 0.1, ROOMY)
        wanted = lower_bound(*ends, of_box, 0.1 + radius, ROOMY)
        assert math.isclose(found.length, wanted.length, rel_tol=1e-9)
        assert found.exact == wanted.exact


@pytest.mark.parametrize("seed", range(5))
def test_what_is_clear_of_a_box_with_a_radius_is_proven_to_be(seed: int) -> None:
    random = np.random.default_rng(100 + seed)
    rounded, _, _ = rounded_box_and_box(random)
    obstacles = ObstacleSet((rounded,))  # type: ignore[arg-type]
    for start, goal in random.uniform(-4, 4, (30, 2, 3)):
        distance = float(segment_distance(rounded, start[None], goal[None])[0])
        proof = certify(polyline(np.array([start, goal])), obstacles, 0.1)
        if abs(distance - 0.1) > 1e-6:
            assert isinstance(proof, Certificate) == (distance > 0.1)


@pytest.mark.parametrize("kind", PRIMITIVES)
def test_the_surface_of_a_shape_is_closed_and_lies_on_it(kind: str) -> None:
    shape = PRIMITIVES[kind].of_length(2.0, (0.0, 0.0, 0.0))
    volumes = []
    for sides in (16, 32, 64):
        vertices, faces = shape.surface(sides)
        np.testing.assert_allclose(shape.signed_distance(vertices), 0, atol=1e-12)
        mesh = trimesh.Trimesh(vertices, faces, process=False)
        assert mesh.is_watertight
        assert mesh.is_winding_consistent
        assert mesh.is_convex
        volumes.append(mesh.volume)
        np.testing.assert_allclose(mesh.bounds[1], shape.bounds()[1], rtol=0.03)
    samples = np.random.default_rng(0).uniform(-2, 2, (200_000, 3))
    share = (shape.signed_distance(samples) < 0).mean()
    assert volumes[-1] == pytest.approx(share * 64, rel=0.03)
    assert volumes == sorted(volumes)


@pytest.mark.parametrize("kind", PRIMITIVES)
def test_a_shape_is_the_union_of_its_parts(kind: str) -> None:
    random = np.random.default_rng(3)
    data = PRIMITIVES[kind].of_length(1.5, (0.3, -0.2, 0.5)).model_dump()
    shape = PRIMITIVES[kind].model_validate(data | {"wxyz": random.normal(size=4).tolist()})
    points = random.uniform(-2, 2, (5000, 3))
    of_parts = np.min([part.signed_distance(points) for part in shape.parts()], axis=0)
    assert ((of_parts < 0) == (shape.signed_distance(points) < 0)).all()


def test_a_shape_that_other_programs_do_not_know_is_a_mesh_to_them() -> None:
    shape = RoundedBox.of_length(1.0, (1.0, 2.0, 3.0))
    ((solid,),) = solids((shape,), "cm")  # type: ignore[arg-type]
    assert solid.kind == "mesh"
    np.testing.assert_allclose(solid.triangles, shape.triangles() / 100)
    assert len(pack((shape,)))  # type: ignore[arg-type]
