"""What the paper says of mesh and search, stages 1 to 3, beside what we find."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy

from abi.errors import StageError
from abi.obstacles.obstacle_set import ObstacleSet
from abi.paper import printed
from abi.paper.comparison import Comparison
from abi.planner.plan import Plan
from abi.planner.planner import plan
from abi.scene.scene import Scene
from abi.search import graph
from abi.search.search import a_star
from abi.tet_mesh import adjacency as net
from abi.tet_mesh import tet_mesh as mesh
from abi.tet_mesh.exclusion import exclude

_NAMES = {"dijkstra": "Dijkstra", "bellman_ford": "Bellman-Ford", "a_star": "A*"}
_SCENES = 100


def of_mesh(scene: Scene) -> Iterator[Comparison]:
    """Which nodes and edges to exclude, and what a finer mesh is good for."""
    where = "stage 1, mesh"
    through, tested = zip(
        *((_enters_by_nodes(one), _enters(one)) for one in _random_scenes(scene)), strict=True
    )
    yield Comparison(
        where,
        "excluding the nodes in the obstacles",
        "is enough",
        f"{sum(through)} of {_SCENES} random scenes have a path through an obstacle; with edges "
        f"tested, too, {sum(tested)}",
        "does not hold",
    )
    factors = [_detour(scene, pitch) for pitch in (1.0, 0.5, 0.25)]
    yield Comparison(
        where,
        "reducing the pitch",
        "increases the accuracy",
        "a path without obstacles is "
        + ", ".join(f"{100 * (factor - 1):.1f} %" for factor in factors)
        + " too long at pitch 1, ½, ¼ (Kuhn)",
        "does not hold",
    )


def of_table_one(by_length: Plan, by_hops: Plan) -> Iterator[Comparison]:
    """Table I, beside searches of one graph by length and by hops."""
    where = "Table I"
    lengths = {result.algorithm: result.length for result in by_length.searches}
    hops = {result.algorithm: result for result in by_hops.searches}
    for name, length in printed.LENGTHS.items():
        yield Comparison(
            where,
            f"{_NAMES[name]}, length of the path",
            f"{length:.3f}",
            f"{lengths[name]:.3f} by length, {hops[name].length:.3f} by hops",
            "depends on the mesh",
        )
    yield Comparison(
        where,
        "vertices of the paths",
        f"{printed.VERTICES}, all three",
        ", ".join(str(result.hops + 1) for result in hops.values()) + " by hops",
        "depends on the mesh",
    )
    spread = max(lengths.values()) - min(lengths.values())
    yield Comparison(
        where,
        "the three lengths on one graph",
        "differ by up to 0.400",
        f"differ by {spread:.0e}: by length all three are exact" if spread else "are the same",
        "does not hold",
    )


def _random_scenes(scene: Scene) -> Iterator[Scene]:
    """Scenes with one to four boxes, some of them thin, which leave start and goal free."""
    rng = np.random.default_rng(0)
    made = 0
    while made < _SCENES:
        boxes = [
            {
                "shape": "box",
                "size": rng.uniform(0.3, 3, 3).tolist(),
                "position": rng.uniform(1, 5, 3).tolist(),
                "wxyz": rng.normal(size=4).tolist(),
            }
            for _ in range(rng.integers(1, 5))
        ]
        one = scene.replace(obstacles=boxes, spline={"clearance": 0.0})
        ends = np.array([one.start, one.goal])
        if min(body.signed_distance(ends).min() for body in one.obstacles) > 0:
            made += 1
            yield one


def _enters(scene: Scene) -> bool:
    """Whether our path is through an obstacle."""
    ends = scene.start, scene.goal
    whole = mesh.tetrahedralise(scene.workspace, scene.mesh)
    obstacles = ObstacleSet(scene.obstacles)
    try:
        free = exclude(whole, obstacles, 0.0)
        path = a_star(graph.build(free, obstacles, 0.0, *ends, 0.0), "length")
    except StageError:
        return False
    return obstacles.polyline_clearance(path.points) < 0


def _enters_by_nodes(scene: Scene) -> bool:
    """Whether the shortest path is through an obstacle where only nodes in it are excluded."""
    whole = mesh.tetrahedralise(scene.workspace, scene.mesh)
    inside = np.zeros(len(whole.points), dtype=bool)
    for body in scene.obstacles:
        inside |= body.signed_distance(whole.points) < 0
    kept = ~inside[whole.edges].any(axis=1)
    indptr, indices, lengths = net.rows(whole.edges[kept], whole.lengths[kept], len(whole.points))
    rows = scipy.sparse.csr_array((lengths, indices, indptr), shape=(len(whole.points),) * 2)
    first, last = (
        int(((whole.points - end) ** 2).sum(axis=1).argmin()) for end in (scene.start, scene.goal)
    )
    _, before = scipy.sparse.csgraph.dijkstra(rows, indices=first, return_predecessors=True)
    way = [last]
    while way[-1] != first:
        if before[way[-1]] < 0:
            return False
        way.append(int(before[way[-1]]))
    return ObstacleSet(scene.obstacles).polyline_clearance(whole.points[way]) < 0


def _detour(scene: Scene, pitch: float) -> float:
    """A* without obstacles from one lower corner to the opposite upper one, over the straight line:
    from the corner from which Kuhn's diagonals lead away."""
    made = plan(
        scene.replace(
            obstacles=[],
            start=[6.0, 0.0, 0.0],
            goal=[0.0, 6.0, 6.0],
            mesh={"lattice": "kuhn", "pitch": pitch},
        )
    )
    assert made.path is not None
    return made.path.length / made.lower_bound
