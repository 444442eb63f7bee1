from __future__ import annotations

from typing import Any, Literal

import numpy as np
import pytest

from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.obstacles.primitives import Box
from abi.obstacles.triangle_mesh.repair import clean
from abi.planner import exclusion_cache
from abi.planner.exclusion_cache import ExclusionCache
from abi.scene.scene import MeshSettings, Workspace
from abi.tet_mesh.exclusion import FreeMesh, exclude, exclusion
from abi.tet_mesh.tet_mesh import TetMesh, tetrahedralise
from tests.abi.meshes import sphere

MARGIN = 0.05


def mesh_of(pitch: float, lattice: Literal["bcc", "kuhn", "delaunay"]) -> TetMesh:
    return tetrahedralise(Workspace(max=(3, 3, 3)), MeshSettings(lattice=lattice, pitch=pitch))


def boxes(rng: np.random.Generator, count: int) -> list[Obstacle]:
    places = rng.uniform(0.5, 2.5, (count, 3)).tolist()
    return [Box(size=(0.8, 0.7, 0.6), position=(x, y, z)) for x, y, z in places]


def same(a: FreeMesh, b: FreeMesh) -> bool:
    free = ~a.excluded
    return (
        a.mesh is b.mesh
        and a.nodes == b.nodes
        and np.array_equal(a.excluded, b.excluded)
        and np.array_equal(a.open_directions[free], b.open_directions[free])
        and np.array_equal(a.weights, b.weights)
    )


@pytest.mark.parametrize("lattice", ["bcc", "kuhn", "delaunay"])
@pytest.mark.parametrize("seed", range(6))
def test_what_is_remembered_is_what_would_be_found_anew(lattice: Any, seed: int) -> None:
    rng = np.random.default_rng(seed)
    cache, meshes = ExclusionCache(), [mesh_of(0.5, lattice), mesh_of(0.7, lattice)]
    solids = boxes(rng, 3)
    for step in range(9):
        k = int(rng.integers(3))
        solids[k] = solids[k].model_copy(update={"position": tuple(rng.uniform(0.5, 2.5, 3))})
        if step == 4:
            solids.append(MeshShape.of(clean(*sphere(2, 0.4)), position=(1.5, 1.5, 1.5)))
        if step == 6:
            solids.append(solids[0])
        if step == 7:
            del solids[1]
        # another mesh and another margin, and back
        mesh, margin = meshes[step == 3], MARGIN + 0.1 * (step == 5)
        obstacles = ObstacleSet(tuple(solids))
        assert same(cache(mesh, obstacles, margin), exclude(mesh, obstacles, margin))


def test_only_what_moved_is_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    looked: list[Obstacle] = []

    def noted(mesh: TetMesh, obstacle: Obstacle, margin: float) -> Any:
        looked.append(obstacle)
        return exclusion(mesh, obstacle, margin)

    monkeypatch.setattr(exclusion_cache, "exclusion", noted)
    cache, mesh = ExclusionCache(), mesh_of(0.5, "bcc")
    solids = boxes(np.random.default_rng(0), 4)
    cache(mesh, ObstacleSet(tuple(solids)), MARGIN)
    assert looked == solids
    looked.clear()
    solids[2] = solids[2].model_copy(update={"position": (1.0, 1.1, 1.2)})
    cache(mesh, ObstacleSet(tuple(solids)), MARGIN)
    assert looked == solids[2:3]
