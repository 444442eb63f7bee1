"""Graphs of small meshes for tests of the searches."""

from __future__ import annotations

from typing import Any

import numpy as np

from abi.obstacles.obstacle_set import Obstacles, ObstacleSet
from abi.obstacles.primitives import Box, Sphere
from abi.scene.lattices import LATTICES, Lattice
from abi.scene.settings import MeshSettings, Workspace
from abi.search.build_graph import build_graph
from abi.search.graph import Graph
from abi.tet_mesh.exclusion import exclude
from abi.tet_mesh.tet_mesh import tetrahedralise
from tests.random_geometry import random_obstacles


def lattice_of(seed: int) -> Lattice:
    """Each lattice in turn."""
    return list(LATTICES)[seed % len(LATTICES)]


def random_graph(seed: int) -> Graph:
    """A mesh of up to 300 nodes with obstacles, start and goal anywhere or in the corners."""
    rng = np.random.default_rng(seed)
    obstacles = random_obstacles(rng, int(rng.integers(0, 6)), 4.0, 2.4)
    workspace = Workspace(max=(4, 3.3, 4.7))
    settings = MeshSettings(lattice=lattice_of(seed), pitch=rng.uniform(0.7, 1.5), seed=seed)
    points = rng.uniform(0, 1, (200, 3)) * workspace.size
    points = points[ObstacleSet(obstacles).nearest(points)[0] > 0.05]
    corners = ((0, 0, 0), workspace.max)
    free_corners = ObstacleSet(obstacles).nearest(np.array(corners, dtype=float))[0].min() > 0.05
    start, goal = corners if free_corners and seed % 2 else map(tuple, points[:2].tolist())
    return graph_of(workspace, settings, obstacles, start, goal)


def graph_of(
    workspace: Workspace, settings: MeshSettings, obstacles: Obstacles, start: Any, goal: Any
) -> Graph:
    free = exclude(tetrahedralise(workspace, settings), ObstacleSet(obstacles), 0.05)
    return build_graph(free, ObstacleSet(obstacles), 0.05, start, goal, 0.02)


def walled() -> Graph:
    """Start and goal on the two sides of a plate without a hole; some nodes excluded."""
    obstacles = (
        Box(position=(2, 2, 2.1), size=(9, 9, 0.01)),
        Sphere(position=(1.0, 1.0, 1.0), radius=0.8),
    )
    workspace, settings = Workspace(max=(4, 4, 4)), MeshSettings(pitch=0.7)
    return graph_of(workspace, settings, obstacles, (3, 3, 0.2), (1, 1, 3.8))
