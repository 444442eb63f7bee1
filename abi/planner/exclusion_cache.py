"""A memory of what each obstacle excludes of a mesh, for obstacles that move one at a time."""

from __future__ import annotations

from operator import is_not

from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.primitives import Obstacle
from abi.tet_mesh.exclusion import Exclusion, FreeMesh, apply, exclusion
from abi.tet_mesh.tet_mesh import TetMesh


class ExclusionCache:
    """:func:`abi.tet_mesh.exclusion.exclude` with a memory of the last call.

    Obstacles that did not move since need no second look, and what they leave of the mesh is there.
    """

    def __init__(self) -> None:
        self._mesh: TetMesh | None = None
        self._known: dict[tuple[Obstacle, float], Exclusion] = {}
        self._still: list[Exclusion] = []
        self._free_of_still: FreeMesh | None = None

    def __call__(self, mesh: TetMesh, obstacles: ObstacleSet, margin: float) -> FreeMesh:
        """Exclude the nodes and edges that are nearer to an obstacle than ``margin``, [unit]."""
        same = mesh is self._mesh
        known = self._known if same else {}
        used: dict[tuple[Obstacle, float], Exclusion] = {}
        still, moved = [], []
        for obstacle in obstacles:
            key = (obstacle, margin)
            if key in known:
                still.append(used.setdefault(key, known[key]))
            else:
                moved.append(used.setdefault(key, exclusion(mesh, obstacle, margin)))
        free = self._free_of_still if same else None
        if free is None or len(still) != len(self._still) or any(map(is_not, still, self._still)):
            free = apply(FreeMesh.of(mesh), still)
        self._mesh, self._known, self._still, self._free_of_still = mesh, used, still, free
        return apply(free, moved)
