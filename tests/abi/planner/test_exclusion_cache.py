"""The memory of exclusions against excluding everything anew."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.planner.exclusion_cache import ExclusionCache
from abi.scene.settings import MeshSettings, Workspace
from abi.tet_mesh.exclusion import exclude
from abi.tet_mesh.tet_mesh import tetrahedralise
from tests.random_geometry import random_obstacle

MESHES = tuple(
    tetrahedralise(Workspace(), MeshSettings(lattice=name, pitch=0.9)) for name in ("bcc", "kuhn")
)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_whatever_changes_the_exclusion_is_that_of_all_obstacles(seed: int) -> None:
    random = np.random.default_rng(seed)
    cache, mesh, margin = ExclusionCache(), MESHES[0], 0.1
    obstacles: list[Obstacle] = [random_obstacle(random) for _ in range(4)]
    for _ in range(12):
        k = int(random.integers(len(obstacles)))
        match random.integers(7):
            case 0:  # moved
                place = tuple(random.uniform(0, 6, 3).tolist())
                obstacles[k] = obstacles[k].model_copy(update={"position": place})
            case 1:  # equal, but another object
                obstacles[k] = obstacles[k].model_copy()
            case 2:
                obstacles.append(obstacles[k])
            case 3 if len(obstacles) > 1:
                obstacles.pop(k)
            case 4:
                obstacles.reverse()
            case 5:
                margin = float(random.choice([0.0, 0.1]))
            case _:
                mesh = MESHES[random.integers(2)]
        found = cache(mesh, ObstacleSet(tuple(obstacles)), margin)
        expected = exclude(mesh, ObstacleSet(tuple(obstacles)), margin)
        assert found.nodes == expected.nodes
        assert np.array_equal(found.excluded, expected.excluded)
        free = ~expected.excluded
        assert np.array_equal(found.open_directions[free], expected.open_directions[free])
