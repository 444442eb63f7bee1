"""Configurations decided many at once: as one by one, for all arms and obstacles of all shapes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

from abi.arm_planning.branch.chain_branch import ChainBranch
from abi.arm_planning.exclusion.node_configuration_kernels import (
    NO_BOXES,
    bound_configurations,
    touching_configurations,
)
from abi.arm_planning.exclusion.node_configurations import NodeConfigurations
from abi.arm_planning.world.arm_worlds import chain_world
from abi.compiled import Kernel
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.obstacles.primitives import Box, Capsule, Cylinder, Sphere
from abi.obstacles.triangle_mesh.repair import clean
from abi.robot.urdf_arm import UrdfArm
from abi.scene.settings import MeshSettings, Workspace
from abi.tet_mesh.tet_mesh import tetrahedralise
from tests.abi import meshes
from tests.abi.arm_planning.test_chain_certificate import ARMS, some_arm


def some_stances(arm: UrdfArm, random: np.random.Generator, wide: float) -> NodeConfigurations:
    """Configurations that change at random over a mesh; at a tenth of its nodes there is none."""
    mesh = tetrahedralise(Workspace(min=(0, 0, 0), max=(1, 1, 1)), MeshSettings(pitch=0.15))
    low, high = np.clip(arm.limits / arm.scales[:, None], -np.pi, np.pi).T
    at = mesh.points @ random.normal(size=(3, len(low)))
    shares = np.abs((wide * at + random.random(len(low))) % 2 - 1)
    positions = (low + shares * (high - low)) * arm.scales
    reached = random.random(len(positions)) < 0.9
    return NodeConfigurations(
        arm, mesh, mesh.points[0], positions[0], positions[0], positions, reached
    )


def obstacles_near(configurations: NodeConfigurations, random: np.random.Generator) -> ObstacleSet:
    """Obstacles of all shapes at places of the arm, some small and some as large as the arm."""
    arm = configurations.arm
    ends = arm.place(configurations.positions[configurations.reached]).reshape(-1, 3)
    shapes: list[Obstacle] = []
    for k in range(12):
        a = arm.reach * float(random.choice([0.02, 0.2, 0.8]))
        at = tuple((ends[random.integers(len(ends))] + a * random.normal(size=3) / 4).tolist())
        turn = tuple(random.normal(size=4).tolist())
        vertices, faces = (meshes.knot(96), meshes.soup(20), meshes.sphere(1))[k % 3]
        mesh = clean(vertices * (a / float(np.ptp(vertices))), faces)
        shapes.append(
            (
                Box(size=(a, 0.7 * a, 0.4 * a), position=at, wxyz=turn),
                Sphere(radius=a / 2, position=at),
                Cylinder(radius=a / 3, height=a, position=at, wxyz=turn),
                Capsule(radius=a / 5, height=a, position=at, wxyz=turn),
                MeshShape.of(mesh, position=at, wxyz=turn),
                Box(size=(30 * arm.reach, a / 9, a / 9), position=at, wxyz=turn),
            )[k % 6]
        )
    return ObstacleSet(tuple(shapes))


@contextmanager
def _taken_for_python(kernel: Kernel[..., Any]) -> Iterator[None]:
    """Have a compiled kernel do quickly what is left to it while it is not."""
    run = kernel._run
    kernel._run = lambda *arguments: run(*arguments)
    try:
        yield
    finally:
        kernel._run = run


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("wide", [0.0, 0.3, 3.0])
def test_stances_are_decided_as_one_by_one(name: str, wide: float) -> None:
    for kernel in (touching_configurations, bound_configurations):
        kernel.compile()
    arm, random = some_arm(name), np.random.default_rng(int(10 * wide))
    configurations = some_stances(arm, random, wide)
    obstacles, mesh = obstacles_near(configurations, random), configurations.mesh
    collision_world = chain_world(arm, obstacles, 0.0)
    branch = ChainBranch(
        arm, "", collision_world, configurations, 0.01 * arm.reach, 0.002 * arm.reach
    )
    table, coordinates, bodies = arm.chain.table, configurations.coordinates, arm.bodies
    some = 0
    for number in range(len(obstacles)):
        asked = configurations.reached & (random.random(len(configurations.reached)) < 0.8)
        expected = np.zeros(len(asked), dtype=np.bool_)
        alone = collision_world.only(collision_world.numbers == number).beyond(
            branch.clearance + branch.slack
        )
        touching_configurations(
            *(table, bodies, coordinates, NO_BOXES, (alone, -1), -1.0, asked, expected)
        )
        found = branch.touching(mesh.points, number, asked)
        np.testing.assert_array_equal(found, expected, strict=True)
        with _taken_for_python(touching_configurations):
            mostly_by_numpy = branch.touching(mesh.points, number, asked)
        np.testing.assert_array_equal(mostly_by_numpy, expected, strict=True)
        some += 0 < expected.sum() < asked.sum()
    assert some > 1 or wide == 0
    with _taken_for_python(touching_configurations):
        mostly_by_numpy = branch.reached(mesh.points)
    np.testing.assert_array_equal(mostly_by_numpy, branch.reached(mesh.points), strict=True)


def test_boxes_hold_the_capsules_of_all_their_stances() -> None:
    bound_configurations.compile()
    arm, random = some_arm("ur5e"), np.random.default_rng(0)
    configurations = some_stances(arm, random, 0.5)
    tree, packed = configurations.tree
    inner, boxes = len(tree.leaves) - 2, packed.reshape(-1, len(arm.capsules), 2, 3)
    ends = arm.place(configurations.positions)
    for branch in range(len(boxes)):
        first = last = branch
        while first < inner:
            first, last = 2 * first + 1, 2 * last + 2
        held = tree.order[tree.leaves[first - inner] : tree.leaves[last - inner + 1]]
        held = held[configurations.reached[held]]
        low, high = ends[held].min(axis=(0, 2)), ends[held].max(axis=(0, 2))
        np.testing.assert_allclose(boxes[branch, :, 0], low, atol=1e-12)
        np.testing.assert_allclose(boxes[branch, :, 1], high, atol=1e-12)
