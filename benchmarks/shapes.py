"""Cost of triangle meshes: what a moved one excludes, beside libraries, and the whole re-plan.

    python -m benchmarks.shapes --triangles 500 20000 500000 --nodes 20000 200000

A ball, a knot, a block of rooms and loose triangles take the place of a box of the same extent, and
move a little from frame to frame. Libraries (:mod:`benchmarks.shape_libraries`) answer for the same
nodes and edges, a sample where these are many; their answers must be ours, but for what is nearer
to the margin than their own rounding. Times are of the process, medians; ratios are taken of these.
Without stage 6, and at the first use, they are by the clock.
"""

from __future__ import annotations

import argparse
import math
import statistics
import time
from collections.abc import Callable, Sequence

import numpy as np

from abi import compiling
from abi.arrays import BoolArray, FloatArray
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import Obstacle
from abi.obstacles.primitives import Box
from abi.obstacles.triangle_mesh.repair import clean
from abi.planner.planner import Planner
from abi.scene.scene import Scene
from abi.tet_mesh.exclusion import FreeMesh, apply, exclusion
from abi.tet_mesh.tet_mesh import TetMesh, tetrahedralise
from benchmarks import shape_libraries
from benchmarks.report import Row, table
from tests.abi import meshes
from tests.abi.meshes import Mesh

TRIANGLES = (500, 20_000, 100_000, 500_000)
NODES = (2_000, 20_000, 200_000)
ROOMS = (60_000, 290_000)
CLEARANCE = 0.1

_EXTENT = 2.5
_ROOM_EXTENT = 4.8
_ROOM_WALLS = (4, 8)
_FRAMES = 7
_GOALS = 21
_SAMPLE = 1_500
_ROUNDING = 1e-5  # FCL's, of a capsule's distance

Make = Callable[[int], Mesh]


def measure(sizes: Sequence[int] = NODES, triangles: Sequence[int] = TRIANGLES) -> list[Row]:
    """Rows of each shape, number of triangles and number of nodes.

    ``mask_ms`` is what a moved mesh costs in nodes and edges, ``mask_ratio`` that over the box's.
    ``libraries_ms`` is the quickest libraries' cost for the same, ``faster`` that over ours.
    ``replan_ms`` is a frame of a drag with one search, ``replan_ratio`` that over the box's,
    ``goal_ratio`` the same with the goal moved; those ``without_arm`` leave out stage 6.
    """
    compiling.compile()
    rows: list[Row] = []
    for nodes in sizes:
        box = _Case("box", Box(size=(_EXTENT,) * 3, position=(3.0, 3.0, 3.0)), nodes).row()
        rows.append(box)
        for name, make in _SHAPES.items():
            for count in triangles:
                rows.append(_measure(name, make(count), nodes, box))
    return rows


def measure_rooms(sizes: Sequence[int] = ROOMS) -> list[Row]:
    """Rows of blocks of rooms that fill most of the workspace, and of a box as large."""
    compiling.compile()
    rows: list[Row] = []
    for nodes in sizes:
        box = _Case("box", Box(size=(_ROOM_EXTENT,) * 3, position=(3.0, 3.0, 3.0)), nodes).row()
        rows.append(box)
        for walls in _ROOM_WALLS:
            rows.append(_measure("large rooms", meshes.room(walls), nodes, box, _ROOM_EXTENT))
    return rows


def _measure(name: str, shape: Mesh, nodes: int, box: Row, extent: float = _EXTENT) -> Row:
    vertices, faces = shape
    size = float(np.ptp(vertices, axis=0).max())
    begin = time.perf_counter()
    surface = clean(vertices * (extent / size), faces)
    read = 1e3 * (time.perf_counter() - begin)
    mesh = MeshShape.of(surface, position=(3.0, 3.0, 3.0))
    mesh.prepare()
    prepared = 1e3 * (time.perf_counter() - begin)
    case = _Case(name, mesh, nodes)
    row = case.row()
    row |= {
        "triangles": len(surface.faces),
        "read_ms": read,
        "first_ms": prepared + row["first_ms"],
    }
    for key in ("mask", "replan", "goal", "replan_without_arm", "goal_without_arm"):
        row[f"{key}_ratio"] = row[f"{key}_ms"] / box[f"{key}_ms"]
    if shape_libraries.can_compare():
        row["libraries_ms"] = _libraries(case.mesh, mesh, case.margin)
        row["faster"] = row["libraries_ms"] / row["mask_ms"]
    return row


class _Case:
    """An obstacle in a lattice."""

    def __init__(self, name: str, obstacle: Obstacle, nodes: int) -> None:
        data = {
            "version": 1,
            "start": [0.2, 0.2, 0.2],
            "goal": [5.8, 5.8, 5.8],
            "mesh": {"lattice": "bcc", "pitch": _pitch(nodes), "max_nodes": 2_000_000},
            "spline": {"clearance": CLEARANCE},
        }
        self.name, self.scene = name, Scene.from_dict(data).replace(obstacles=(obstacle,))
        self.mesh = tetrahedralise(self.scene.workspace, self.scene.mesh)
        self.margin = CLEARANCE + self.scene.workspace.slack

    def row(self) -> Row:
        """Costs of its mask and of the frames of a drag."""
        planner = Planner()
        begin = time.perf_counter()
        plan = planner(self.scene, chosen_only=True)
        first = 1e3 * (time.perf_counter() - begin) - plan.ms["arm"] - plan.ms["arm_aware"]
        masks, frames, without = [], [], []
        for k in range(_FRAMES):
            scene = self._moved(k)
            begin = time.process_time()
            exclusion(self.mesh, scene.obstacles[0], self.margin)
            masks.append(1e3 * (time.process_time() - begin))
            begin = time.process_time()
            plan = planner(scene, chosen_only=True)
            frames.append(1e3 * (time.process_time() - begin))
            without.append(sum(ms for stage, ms in plan.ms.items() if stage in _OF_A_FRAME))
        goals, goals_without = [], []
        for k in range(_GOALS):
            moved = scene.replace(goal=(5.8 - 0.35 / _GOALS * k, 5.7, 5.5))
            begin = time.process_time()
            plan = planner(moved, chosen_only=True)
            goals.append(1e3 * (time.process_time() - begin))
            goals_without.append(sum(plan.ms[stage] for stage in _OF_A_FRAME[1:]))
        costs = {"mask": masks, "replan": frames, "goal": goals, "replan_without_arm": without}
        costs["goal_without_arm"] = goals_without
        medians = {f"{key}_ms": statistics.median(ms) for key, ms in costs.items()}
        size = len(self.mesh.points)
        return {"scene": self.name, "nodes": size, **medians, "first_ms": first}

    def _moved(self, k: int) -> Scene:
        shift = 0.3 * math.sin(0.37 * k + 0.1)
        moved = self.scene.obstacles[0].model_copy(update={"position": (3 + shift, 3.0, 3.0)})
        return self.scene.model_copy(update={"obstacles": (moved,)})


_OF_A_FRAME = (
    *("mesh", "graph", "a_star", "path_clearance", "taut"),
    *("optimum", "bspline", "quadratic", "timing"),
)


def _libraries(made: TetMesh, mesh: MeshShape, margin: float) -> float:
    """Cost of the libraries for a mask, [ms], which is compared with ours."""
    nodes, excluded, ends, lost = questions(made, mesh, margin)
    random = np.random.default_rng(0)
    some = random.permutation(len(nodes))[:_SAMPLE]
    library = shape_libraries.NodeLibraries(mesh)
    begin = time.process_time()
    found = library.excluded(nodes[some], margin)
    of_nodes = 1e3 * (time.process_time() - begin) * len(nodes) / max(len(some), 1)
    sure = np.abs(mesh.signed_distance(nodes[some]) - margin) > _ROUNDING
    assert np.array_equal(found[sure], excluded[some][sure])

    some = random.permutation(len(ends))[:_SAMPLE]
    away = mesh.segment_distance(ends[some, 0], ends[some, 1])
    sure = np.abs(away - margin) > _ROUNDING
    of_edges = math.inf
    for edges in shape_libraries.edge_libraries(mesh):
        begin = time.process_time()
        crossed = edges.lost(ends[some, 0], ends[some, 1], margin)
        took = 1e3 * (time.process_time() - begin) * len(ends) / max(len(some), 1)
        of_edges = min(of_edges, took)
        assert np.array_equal(crossed[sure], lost[some][sure])
    return of_nodes + of_edges


def questions(
    made: TetMesh, mesh: MeshShape, margin: float
) -> tuple[FloatArray, BoolArray, FloatArray, BoolArray]:
    """Nodes near a mesh and whether they are excluded, edges between free ones and whether lost.

    Nodes (n, 3) are those in the box that the mesh reaches; of the edges (m, 2, 3) both ends are.
    """
    free = apply(FreeMesh.of(made), [exclusion(made, mesh, margin)])
    low, high = mesh.bounds()
    reach = margin + made.longest_edge
    inside = (made.points > low - reach) & (made.points < high + reach)
    near: BoolArray = np.asarray(inside.all(axis=1))
    between = near[made.edges].all(axis=1) & ~free.excluded[made.edges].any(axis=1)
    pairs = made.edges[between]
    stencil = made.stencil
    assert stencil is not None
    heads = stencil.heads(pairs[:, 0])
    direction = np.equal(heads, pairs[:, 1:]).argmax(axis=1)
    is_open = np.equal((free.open_directions[pairs[:, 0]] >> direction) & 1, 1)
    return made.points[near], free.excluded[near], made.points[pairs], np.logical_not(is_open)


def _ball(count: int) -> Mesh:
    return meshes.sphere(round(math.log(count / 20, 4)))


def _rooms(count: int) -> Mesh:
    return meshes.room(4 if count < 2_000 else 12)


def _soup(count: int) -> Mesh:
    return meshes.soup(count, size=min(0.5, 20 / math.sqrt(count)))


_SHAPES: dict[str, Make] = {
    "ball": _ball,
    "knot": meshes.knot,
    "rooms": _rooms,
    "loose": _soup,
}


def _pitch(nodes: int) -> float:
    """Pitch for about so many nodes in a workspace of 6 × 6 × 6, [unit]."""
    cells = min(range(1, 200), key=lambda n: abs((n + 1) ** 3 + n**3 - nodes))
    return 6 / cells * math.sqrt(3) / 2


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--nodes", type=int, nargs="+", default=NODES)
    parser.add_argument("--triangles", type=int, nargs="+", default=TRIANGLES)
    parser.add_argument("--rooms", type=int, nargs="*", default=ROOMS, help="nodes around rooms")
    options = parser.parse_args()
    print(table(measure(options.nodes, options.triangles)))
    print(table(measure_rooms(options.rooms)))


if __name__ == "__main__":
    main()
