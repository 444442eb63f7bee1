"""Memory of the exclusion of each obstacle from a mesh, for obstacles that move one at a time."""

from __future__ import annotations

from operator import is_

from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.tet_mesh.exclusion import Exclusion, FreeMesh, apply, exclusion
from abi.tet_mesh.tet_mesh import TetMesh


class ExclusionCache:
    """:func:`abi.tet_mesh.exclusion.exclude` with a memory of the last call.

    It remembers the exclusion of each obstacle, and the mesh free of those that did not move.
    """

    def __init__(self) -> None:
        self._mesh: TetMesh | None = None
        self._exclusions: dict[tuple[Obstacle, float], Exclusion] = {}
        self._unmoved: list[Exclusion] = []
        self._free: FreeMesh | None = None  # of those that did not move

    def __call__(self, mesh: TetMesh, obstacles: ObstacleSet, margin: float) -> FreeMesh:
        """Exclude the nodes and edges that are nearer to an obstacle than ``margin``, [unit]."""
        if mesh is not self._mesh:
            self._mesh, self._exclusions, self._free = mesh, {}, None
        exclusions: dict[tuple[Obstacle, float], Exclusion] = {}
        unmoved, moved = [], []
        for obstacle in obstacles:
            key = (obstacle, margin)
            if key in self._exclusions:
                unmoved.append(exclusions.setdefault(key, self._exclusions[key]))
            else:
                moved.append(exclusions.setdefault(key, exclusion(mesh, obstacle, margin)))
        same = len(unmoved) == len(self._unmoved) and all(map(is_, unmoved, self._unmoved))
        if self._free is None or not same:
            self._free = apply(FreeMesh.of(mesh), unmoved)
        self._exclusions, self._unmoved = exclusions, unmoved
        return apply(self._free, moved)
