"""Places decided many at once: as one by one, for meshes of any kind and both elbows."""

from __future__ import annotations

import numpy as np
import pytest

from abi.arm_planning.exclusion.paper_arm_node_tree_kernels import places_touching
from abi.arm_planning.paper_arm_model import PaperArmModel
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.primitives import Box
from abi.obstacles.triangle_mesh.repair import clean
from abi.scene.scene import Scene
from abi.tet_mesh.node_tree import tree_over
from abi.tet_mesh.tet_mesh import tetrahedralise
from tests.abi import meshes


def test_tree_holds_each_place_once_in_its_balls() -> None:
    points = np.random.default_rng(0).normal(size=(137, 3))
    tree = tree_over(points)
    assert np.array_equal(np.sort(tree.order), np.arange(137))
    assert np.array_equal(tree.points.reshape(-1, 3), points[tree.order])
    balls, inner = tree.balls.reshape(-1, 4), len(tree.leaves) - 2
    for branch in range(len(balls)):
        first = last = branch
        while first < inner:
            first, last = 2 * first + 1, 2 * last + 2
        held = points[tree.order[tree.leaves[first - inner] : tree.leaves[last - inner + 1]]]
        centre, radius = balls[branch, :3], balls[branch, 3]
        assert (np.linalg.norm(held - centre, axis=1) <= radius + 1e-12).all()


@pytest.mark.parametrize("number", range(3))
@pytest.mark.parametrize("elbow", ["up", "down"])
def test_places_are_decided_as_one_by_one(number: int, elbow: str) -> None:
    places_touching.compile()
    random = np.random.default_rng(number)
    vertices, faces = (meshes.knot(496), meshes.room(4), meshes.soup(60, size=0.5))[number]
    surface = clean(vertices * (2.0 / float(np.ptp(vertices, axis=0).max())), faces)
    x, y, z = random.uniform(1.5, 4.5, 3).tolist()
    shape = MeshShape.of(surface, position=(x, y, z), wxyz=(0.9, 0.1, 0.3, -0.2))
    data = {"version": 1, "start": [0.5, 0.5, 0.5], "goal": [5.5, 5.5, 5.5]}
    scene = Scene.from_dict(data | {"arm": {"elbow": elbow}})
    scene = scene.replace(obstacles=(Box(size=(0.5, 0.5, 0.5), position=(5.0, 1.0, 1.0)), shape))
    model = PaperArmModel(scene.arm, scene.unit)
    obstacles = ObstacleSet(scene.obstacles)
    collision_world = model.collision_world(obstacles, scene.workspace.min[2])
    made = tetrahedralise(scene.workspace, scene.mesh)
    for branch in model.branches(scene, collision_world, made, 0.01):
        asked = branch.reached(made.points) & (random.random(len(made.points)) < 0.9)
        expected = branch.touching(made.points, 1, asked)
        assert 0 < expected.sum() < asked.sum()
        assert np.array_equal(branch.touching(made.points, 1, asked, made.node_tree), expected)
