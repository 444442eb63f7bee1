"""Rows of an arm's surroundings, made anew only of what moves."""

from __future__ import annotations

import numpy as np
import pytest

from abi.arm_planning.paper_arm_model import paper_arm
from abi.arm_planning.world.arm_worlds import paper_arm_world
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arm_planning.world.row_table import RowTable
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.obstacles.primitive_kernels import WIDTH
from abi.obstacles.primitive_tree_kernels import TREE
from abi.obstacles.primitives import Box, Sphere
from abi.obstacles.triangle_mesh.repair import clean
from abi.scene.arm_settings import ArmSettings
from tests.abi import meshes

_SURFACES = clean(*meshes.sphere(1, 0.4)), clean(*meshes.soup(40))


@pytest.mark.parametrize("seed", range(4))
def test_rows_that_stay_are_those_made_anew(seed: int) -> None:
    random, arm, table = (
        np.random.default_rng(seed),
        paper_arm(ArmSettings(), "cm"),
        RowTable(),
    )
    obstacles = [_obstacle(random) for _ in range(6)]
    handed_out: list[tuple[CollisionWorld, list[tuple[object, ...]]]] = []
    for _ in range(40):
        _change(obstacles, random)
        solids = ObstacleSet(tuple(obstacles))
        found, fresh = (
            paper_arm_world(arm, solids, -1.0, table),
            paper_arm_world(arm, solids, -1.0),
        )
        assert _content(found) == _content(fresh)
        assert found.in_use == fresh.in_use
        assert (found.size, found.floor) == (fresh.size, fresh.floor)
        assert found.asked.sum() == fresh.asked.sum()
        assert all(found.numbers[found.first_row(k)] == k for k in range(len(obstacles)))
        handed_out.append((found, _content(found)))
    assert all(_content(one) == content for one, content in handed_out)


def _change(obstacles: list[Obstacle], random: np.random.Generator) -> None:
    """Move, add, remove, exchange, or double an obstacle."""
    k = int(random.integers(len(obstacles)))
    match random.integers(8):
        case 0:
            obstacles.append(_obstacle(random))
        case 1 if len(obstacles) > 2:
            del obstacles[k]
        case 2:
            obstacles[0], obstacles[k] = obstacles[k], obstacles[0]
        case 3:
            obstacles[k] = obstacles[0]
        case _:
            x, y, z = random.uniform(-2, 2, 3).tolist()
            obstacles[k] = obstacles[k].model_copy(update={"position": (x, y, z)})


def _obstacle(random: np.random.Generator) -> Obstacle:
    x, y, z = random.uniform(-2, 2, 3).tolist()
    match random.integers(4):
        case 0:
            return Box(size=(0.3, 0.2, 0.4), position=(x, y, z))
        case 1:
            return Sphere(radius=0.2, position=(x, y, z))
        case number:
            return MeshShape.of(_SURFACES[number - 2], position=(x, y, z))


def _content(collision_world: CollisionWorld) -> list[tuple[object, ...]]:
    """Each outer row and all that is inside, with what is known of it, in their order."""
    last = len(collision_world.numbers) - 1
    return [_row(collision_world, int(s)) for s in collision_world.outer if s < last]


def _row(collision_world: CollisionWorld, s: int) -> tuple[object, ...]:
    first, end = collision_world.inside[2 * s : 2 * s + 2].tolist()
    return (
        *(
            int(collision_world.numbers[s]),
            int(collision_world.meshes[s]),
            tuple(collision_world.asked[:, s].tolist()),
        ),
        collision_world.rows[s * WIDTH : s * WIDTH + TREE].tobytes(),
        tuple(_row(collision_world, row) for row in range(first, end)),
    )
