"""Cache of what each obstacle excludes from a mesh, for obstacles that move one at a time."""

from __future__ import annotations

from operator import is_

from abi.obstacles.obstacle_set import Obstacle, ObstacleSet
from abi.tet_mesh.exclusion import Exclusion, FreeMesh, apply, exclusion
from abi.tet_mesh.tet_mesh import TetMesh


class ExclusionCache:
    """:func:`abi.tet_mesh.exclusion.exclude` with a memory of the last call.

    It remembers the exclusion of each obstacle, and the mesh without what the unmoved ones exclude.
    """

    def __init__(self) -> None:
        self._asked: tuple[TetMesh, float] | None = None
        self._known: list[tuple[Obstacle, Exclusion]] = []
        self._unmoved: list[Exclusion] = []
        self._free: FreeMesh | None = None  # of those that did not move

    def __call__(self, mesh: TetMesh, obstacles: ObstacleSet, margin: float) -> FreeMesh:
        """Exclude the nodes and edges that are nearer to an obstacle than ``margin``, [unit]."""
        if self._asked is None or mesh is not self._asked[0] or margin != self._asked[1]:
            self._asked, self._known, self._free = (mesh, margin), [], None
        # by identity first: of thousands, to compare by value takes longer than to plan
        same_object = {id(one): found for one, found in self._known}
        asked = {id(one) for one in obstacles}
        same_value = {one: found for one, found in self._known if id(one) not in asked}
        known, unmoved, moved = [], [], []
        for obstacle in obstacles:
            found = same_object.get(id(obstacle))
            if found is None and same_value:
                found = same_value.get(obstacle)
            if found is not None:
                unmoved.append(found)
            else:
                found = exclusion(mesh, obstacle, margin)
                moved.append(found)
            known.append((obstacle, found))
        same = len(unmoved) == len(self._unmoved) and all(map(is_, unmoved, self._unmoved))
        if self._free is None or not same:
            self._free = apply(FreeMesh.of(mesh), unmoved)
        self._known, self._unmoved = known, unmoved
        return apply(self._free, moved)
