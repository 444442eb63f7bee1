"""The paper's statements on mesh and search, stages 1 to 3, beside our figures."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy

from abi.errors import StageError
from abi.explain.paper import printed
from abi.explain.paper.comparison import PaperComparison
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.plan import Plan
from abi.planner.planner import plan
from abi.scene.scene import Scene
from abi.search.build_graph import build_graph
from abi.search.search import search
from abi.tet_mesh import adjacency
from abi.tet_mesh.exclusion import exclude
from abi.tet_mesh.tet_mesh import tetrahedralise

_NAMES = {"dijkstra": "Dijkstra", "bellman_ford": "Bellman-Ford", "a_star": "A*"}
_SCENES = 100


def of_mesh(scene: Scene) -> Iterator[PaperComparison]:
    """Exclusion of nodes alone, and the accuracy of finer meshes."""
    section = "stage 1, mesh"
    by_nodes, by_edges = zip(
        *((_enters_by_nodes(random), _enters(random)) for random in _random_scenes(scene)),
        strict=True,
    )
    yield PaperComparison(
        section,
        "excluding the nodes in the obstacles",
        "is enough",
        f"{sum(by_nodes)} of {_SCENES} random scenes have a path through an obstacle; with edges "
        f"tested, too, {sum(by_edges)}",
        "does not hold",
    )
    factors = [_detour(scene, pitch) for pitch in (1.0, 0.5, 0.25)]
    yield PaperComparison(
        section,
        "reducing the pitch",
        "increases the accuracy",
        "a path without obstacles is "
        + ", ".join(f"{100 * (factor - 1):.1f} %" for factor in factors)
        + " too long at pitch 1, ½, ¼ (Kuhn)",
        "does not hold",
    )


def of_table_one(by_length: Plan, by_hops: Plan) -> Iterator[PaperComparison]:
    """Table I beside our searches of one graph, by length and by hops."""
    section = "Table I"
    lengths = {result.algorithm: result.length for result in by_length.searches}
    hops = {result.algorithm: result for result in by_hops.searches}
    for name, length in printed.LENGTHS.items():
        yield PaperComparison(
            section,
            f"{_NAMES[name]}, length of the path",
            f"{length:.3f}",
            f"{lengths[name]:.3f} by length, {hops[name].length:.3f} by edges",
            "depends on the mesh",
        )
    yield PaperComparison(
        section,
        "vertices of the paths",
        f"{printed.VERTICES}, all three",
        ", ".join(str(result.hops + 1) for result in hops.values()) + " by edges",
        "depends on the mesh",
    )
    spread = max(lengths.values()) - min(lengths.values())
    yield PaperComparison(
        section,
        "the three lengths on one graph",
        "differ by up to 0.400",
        f"differ by {spread:.0e}: by length all three are exact" if spread else "are the same",
        "does not hold",
    )


def _random_scenes(scene: Scene) -> Iterator[Scene]:
    """Scenes with one to four boxes, some of them thin, which leave start and goal free."""
    rng = np.random.default_rng(0)
    count = 0
    while count < _SCENES:
        boxes = [
            {
                "shape": "box",
                "size": rng.uniform(0.3, 3, 3).tolist(),
                "position": rng.uniform(1, 5, 3).tolist(),
                "wxyz": rng.normal(size=4).tolist(),
            }
            for _ in range(rng.integers(1, 5))
        ]
        random = scene.replace(obstacles=boxes, spline={"clearance": 0.0})
        ends = np.array([random.start, random.goal])
        if min(body.signed_distance(ends).min() for body in random.obstacles) > 0:
            count += 1
            yield random


def _enters(scene: Scene) -> bool:
    """Check whether the path enters an obstacle where nodes and edges are excluded."""
    ends = scene.start, scene.goal
    mesh = tetrahedralise(scene.workspace, scene.mesh)
    obstacles = ObstacleSet(scene.obstacles)
    try:
        free = exclude(mesh, obstacles, 0.0)
        path = search("a_star", build_graph(free, obstacles, 0.0, *ends, 0.0), "length")
    except StageError:
        return False
    return obstacles.polyline_clearance(path.points) < 0


def _enters_by_nodes(scene: Scene) -> bool:
    """Check whether the path enters an obstacle where only nodes inside are excluded."""
    mesh = tetrahedralise(scene.workspace, scene.mesh)
    inside = np.zeros(len(mesh.points), dtype=bool)
    for body in scene.obstacles:
        inside |= body.signed_distance(mesh.points) < 0
    kept = ~inside[mesh.edges].any(axis=1)
    indptr, indices, lengths = adjacency.rows(
        mesh.edges[kept], mesh.lengths[kept], len(mesh.points)
    )
    matrix = scipy.sparse.csr_array((lengths, indices, indptr), shape=(len(mesh.points),) * 2)
    first, last = (
        int(((mesh.points - end) ** 2).sum(axis=1).argmin()) for end in (scene.start, scene.goal)
    )
    _, parents = scipy.sparse.csgraph.dijkstra(matrix, indices=first, return_predecessors=True)
    path = [last]
    while path[-1] != first:
        if parents[path[-1]] < 0:
            return False
        path.append(int(parents[path[-1]]))
    return ObstacleSet(scene.obstacles).polyline_clearance(mesh.points[path]) < 0


def _detour(scene: Scene, pitch: float) -> float:
    """Length of the path by A* across the free workspace over that of the straight line.

    From the corner from which no diagonal of Kuhn's cubes leads to the goal.
    """
    result = plan(
        scene.replace(
            obstacles=[],
            start=[6.0, 0.0, 0.0],
            goal=[0.0, 6.0, 6.0],
            mesh={"lattice": "kuhn", "pitch": pitch},
        )
    )
    assert result.path is not None
    return result.path.length / result.straight_length
