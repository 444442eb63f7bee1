"""What a drag costs: our frame beside that of graph libraries, by stage and by size.

    python -m benchmarks.frames --nodes 200 2000 20000 200000 1000000

An obstacle moves a little from frame to frame. A frame is all that a user pays for: the mask
(nodes and edges that the obstacles take) and a search. Ours is the planner's exclusion,
``graph.build`` and one of the searches. Libraries store their edges, and search with what they do
best. Their frame is a compiled mask over these edges, the weights or rows that the library
takes, and its search. That mask tests every node and every edge exactly as ours does, leaves an
edge alone as soon as both its ends lie on one side of the obstacle's bounds, and looks again only
at what obstacles that stand still leave. It is compared with ours, edge by edge.

The re-plan is all that a drag asks of the tab: every stage, with A* alone; the other two searches
follow when the hand rests. The chain is what of it comes after the path: clearances, certificates,
curves, timing and the arm.

All methods see the same frames, and every length is compared on every frame. They run in turn, a
few frames at a stretch, in one process, for a drag is one method frame after frame. Times are
medians of the process's own time, ratios are taken of these.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import math
import statistics
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from operator import is_not
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba.extending import register_jitable
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from abi import compiling
from abi.arrays import BoolArray, ByteArray, FloatArray, IntArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.packing import pack
from abi.obstacles.primitive_kernels import (
    Axes,
    Core,
    axes_of,
    core_of,
    in_body,
    segment_within,
    signed_distance,
)
from abi.obstacles.primitives import MeshShape, Obstacle, Obstacles
from abi.planner.exclusion_cache import ExclusionCache
from abi.planner.planner import SLACK, Planner
from abi.scene.scene import Scene
from abi.search import graph
from abi.search.graph import Graph
from abi.search.search import SEARCHES
from abi.taut.taut_path import taut
from abi.tet_mesh import adjacency as net
from abi.tet_mesh import tet_mesh as mesh
from benchmarks.report import table
from tests.random_scenes import box_scene

SIZES = (200, 2_000, 20_000, 200_000, 1_000_000)
CLEARANCE = 0.2

_CHAIN = ("path_clearance", "bspline", "quadratic", "timing", "arm")
"""From the path to the arm's motion, certificates included."""

_SEED = 32  # of the scene with 8 boxes
_SWING = 0.4  # how far the obstacle moves to each side, [unit]
_FRAMES = ((3_000, 10, 12), (30_000, 5, 6), (300_000, 3, 4), (20_000_000, 2, 3))
"""By number of nodes: how often each method has its turn, and frames a turn."""
_MOST_NETWORKX = 30_000

_GONE = 64

Row = dict[str, Any]
Library = Callable[[Graph, Obstacles, float], float]
Rows = tuple[IntArray, IntArray, FloatArray]
Times = dict[str, list[float]]


def measure(sizes: Sequence[int] = SIZES) -> list[Row]:
    """Time all methods in both scenes at about so many nodes.

    Returns:
        Rows with ``scene``, ``nodes``, ``method``, ``ms`` and, for our frames, ``faster``: the best
        library's frame over ours, and ``than_networkx``. Methods named "frame" are whole frames,
        and "library mask" is what libraries pay of it for the mask and the open rows.
    """
    compiling.compile()
    return [row for size in sizes for name in _SCENES for row in _measure(name, size)]


def _measure(name: str, size: int) -> list[Row]:
    scenes = _frames_of(_SCENES[name](_pitch(size)))
    first = next(scenes)
    whole = mesh.tetrahedralise(first.workspace, first.mesh)
    nodes = len(whole.points)
    stored = _Stored(whole)
    libraries = _libraries(stored)
    turns, stretch = next(frames for most, *frames in _FRAMES if nodes <= most)
    planner, exclude = Planner(), ExclusionCache()
    times: Times = defaultdict(list)
    for turn in range(turns + 1):
        found = _turn(whole, list(islice(scenes, stretch)), exclude, planner, stored, libraries)
        if turn > 0:  # the first fills caches
            for method, ms in found.items():
                times[method] += ms
    medians = {method: statistics.median(values) for method, values in times.items()}
    others = [ms for method, ms in medians.items() if method.startswith("frame, ")]
    rows = []
    for method, median in medians.items():
        row: Row = {"scene": name, "nodes": nodes, "method": method, "ms": median}
        if method.removeprefix("frame ") in SEARCHES and method not in SEARCHES:
            row["faster"] = min(others) / median
            if "frame, networkx" in medians:
                row["than_networkx"] = medians["frame, networkx"] / median
        rows.append(row)
    return rows


def _turn(
    whole: mesh.TetMesh,
    scenes: list[Scene],
    exclude: ExclusionCache,
    planner: Planner,
    stored: _Stored,
    libraries: dict[str, Library],
) -> Times:
    """Milliseconds of each method on each of some frames; all lengths are the same."""
    margin = CLEARANCE + SLACK * max(scenes[0].workspace.size)
    times: Times = defaultdict(list)
    graphs, lengths = [], []
    for scene in scenes:
        with _Clock(times, "mask"):
            free = exclude(whole, ObstacleSet(scene.obstacles), margin)
            made = graph.build(
                free, ObstacleSet(scene.obstacles), margin, scene.start, scene.goal, CLEARANCE
            )
        found = {}
        for name, search in SEARCHES.items():
            with _Clock(times, name):
                found[name] = search(made, "length")
            times[f"frame {name}"].append(times["mask"][-1] + times[name][-1])
        graphs.append(made)
        lengths.append([result.length for result in found.values()])
    for scene, made in zip(scenes, graphs, strict=True):
        with _Clock(times, "library mask"):
            rows = stored.open_rows(scene.obstacles, margin)
        assert len(rows[1]) == 2 * made.edge_count
    assert all(map(np.array_equal, rows[:2], (made.indptr, made.indices)))
    for name, library in libraries.items():
        for scene, made, same in zip(scenes, graphs, lengths, strict=True):
            with _Clock(times, f"frame, {name}"):
                length = library(made, scene.obstacles, margin)
            same.append(length)
    for same in lengths:
        assert max(same) - min(same) <= 1e-9 * same[0], same
    with _Clock(times, "taut"):
        taut(made, ObstacleSet(scene.obstacles), margin, found["a_star"])
    for scene, same in zip(scenes, lengths, strict=True):
        with _Clock(times, "re-plan"):
            plan = planner(scene, chosen_only=True)
        assert plan.path is not None
        assert abs(plan.path.length - same[0]) <= 1e-9 * same[0]
        times["chain"].append(sum(plan.ms[stage] for stage in _CHAIN))
    return times


class _Clock:
    """Notes the process time that a block took, [ms]."""

    def __init__(self, into: Times, name: str) -> None:
        self._into = into[name]

    def __enter__(self) -> None:
        self._begin = time.process_time_ns()

    def __exit__(self, *_: object) -> None:
        self._into.append(1e-6 * (time.process_time_ns() - self._begin))


def _cube(pitch: float) -> Scene:
    return Scene.from_dict(
        {
            "version": 1,
            "obstacles": [{"shape": "box", "size": [3, 3, 3], "position": [3, 3, 3]}],
            "mesh": {"lattice": "bcc", "pitch": pitch, "max_nodes": 2_000_000},
            "spline": {"clearance": CLEARANCE},
        }
    )


def _boxes(pitch: float) -> Scene:
    return box_scene(_SEED, 1.0).replace(mesh={"pitch": pitch, "max_nodes": 2_000_000})


_SCENES: dict[str, Callable[[float], Scene]] = {"cube": _cube, "8 boxes": _boxes}


def _pitch(nodes: int) -> float:
    """The pitch that gives about so many nodes in a workspace of 6 × 6 × 6."""
    cells = min(range(1, 200), key=lambda n: abs((n + 1) ** 3 + n**3 - nodes))
    return 6 / cells * math.sqrt(3) / 2


def _frames_of(scene: Scene) -> Iterator[Scene]:
    """The scene with its first obstacle on its way to and fro."""
    body = scene.obstacles[0]
    k = 0
    while True:
        x, y, z = body.position
        moved = body.model_copy(update={"position": (x + _SWING * math.sin(0.37 * k + 0.1), y, z)})
        yield scene.model_copy(update={"obstacles": (moved, *scene.obstacles[1:])})
        k += 1


def _libraries(stored: _Stored) -> dict[str, Library]:
    """Those that are installed, each as a function from the frame to the path's length."""
    found: dict[str, Library] = {"scipy": _Scipy(stored).length}
    if importlib.util.find_spec("networkit"):
        found["networkit"] = _Networkit(stored).length
    if importlib.util.find_spec("igraph"):
        found["igraph"] = _Igraph(stored).length
    if len(stored.whole.points) <= _MOST_NETWORKX:
        found["networkx"] = _Networkx(stored).length
    return found


class _Stored:
    """A mesh by its stored edges, as compressed rows, and which are open among obstacles."""

    def __init__(self, whole: mesh.TetMesh) -> None:
        self.whole = whole
        self.places = [np.ascontiguousarray(column) for column in whole.points.T]
        self.indptr, self.heads, self.lengths = net.rows(
            whole.edges, whole.lengths, len(whole.points)
        )
        self.tails = np.repeat(np.arange(len(whole.points)), np.diff(self.indptr))
        self._sides = np.empty(len(whole.points), np.uint8)
        self._left: Rows = (self.indptr, self.heads, self.lengths)
        self._shut = np.zeros(len(self.heads), np.bool_)
        self._into: Rows = (self.indptr.copy(), self.heads.copy(), self.lengths.copy())
        self._before: Obstacles = ()
        self._still: Obstacles = ()

    def open_rows(self, obstacles: Obstacles, margin: float) -> Rows:
        """Open edges as rows: indptr (n + 1,), heads and lengths; they last until the next call.

        Obstacles that were there the last time have stood still; what they leave is kept.
        """
        moved, rows = self._parted(obstacles, margin)
        for one in moved:
            rows = self._without(rows, one, margin, self._into)
        return rows

    def shut(self, obstacles: Obstacles, margin: float) -> BoolArray:
        """Which edges of all rows are shut (2e,); what stood still is kept, as above."""
        moved, _ = self._parted(obstacles, margin)
        shut = self._shut.copy()
        for one in moved:
            self._mark(one, margin, shut)
        return shut

    def _parted(self, obstacles: Obstacles, margin: float) -> tuple[Obstacles, Rows]:
        """The obstacles that moved since the last time, and the rows that the others leave."""
        before = set(map(id, self._before))
        still = tuple(one for one in obstacles if id(one) in before)
        if len(still) != len(self._still) or any(map(is_not, still, self._still)):
            self._left = self.indptr, self.heads, self.lengths
            self._shut = np.zeros(len(self.heads), np.bool_)
            into = (self.indptr.copy(), self.heads.copy(), self.lengths.copy())
            for one in still:
                self._left = self._without(self._left, one, margin, into)
                self._mark(one, margin, self._shut)
            self._still = still
        self._before = obstacles
        return tuple(one for one in obstacles if id(one) not in before), self._left

    def _without(self, rows: Rows, one: Obstacle, margin: float, into: Rows) -> Rows:
        assert not isinstance(one, MeshShape)
        row = pack((one,))
        opened: Any = _open
        count = opened(*rows, *self.places, row, margin, self._sides, *into)
        return into[0], into[1][:count], into[2][:count]

    def _mark(self, one: Obstacle, margin: float, shut: BoolArray) -> None:
        assert not isinstance(one, MeshShape)
        row = pack((one,))
        marked: Any = _mark
        marked(self.indptr, self.heads, *self.places, row, margin, self._sides, shut)


class _Scipy:
    """scipy keeps one matrix, whose rows are exchanged."""

    def __init__(self, stored: _Stored) -> None:
        self._stored = stored
        rows = (stored.lengths.copy(), stored.heads.copy(), stored.indptr.copy())
        self._matrix = csr_array(rows, shape=(len(stored.indptr) - 1,) * 2)

    def length(self, made: Graph, obstacles: Obstacles, margin: float) -> float:
        """Dijkstra's algorithm over the rows."""
        matrix = self._matrix
        matrix.indptr, matrix.indices, matrix.data = self._stored.open_rows(obstacles, margin)
        cost, before = dijkstra(matrix, indices=made.start, return_predecessors=True)
        _way(before, made)
        return float(cost[made.goal])


class _Networkit:
    """networkit is given a new graph."""

    def __init__(self, stored: _Stored) -> None:
        self._stored = stored
        self._away: FloatArray | None = None

    def length(self, made: Graph, obstacles: Obstacles, margin: float) -> float:
        """A* with the straight line."""
        import networkit

        networkit.setNumberOfThreads(1)
        indptr, heads, weights = self._stored.open_rows(obstacles, margin)
        ids = np.arange(len(indptr) - 1, dtype=np.uint64)
        tails, ends = np.repeat(ids, np.diff(indptr)), ids[heads]
        once = tails < ends
        net = networkit.GraphFromCoo(
            (weights[once], (tails[once], ends[once])),
            n=len(indptr) - 1,
            weighted=True,
            directed=False,
        )
        if self._away is None:
            self._away = np.linalg.norm(made.points - made.points[made.goal], axis=1)
        search = networkit.distance.AStar(net, self._away, made.start, made.goal)
        search.run()
        search.getPath()
        return float(search.getDistance())


class _Igraph:
    """igraph keeps the whole mesh, and edges that are shut weigh infinitely much."""

    def __init__(self, stored: _Stored) -> None:
        import igraph

        self._stored = stored
        self._once = np.flatnonzero(stored.tails < stored.heads)
        self._lengths = stored.lengths[self._once]
        ends = np.stack([stored.tails, stored.heads], axis=1)[self._once]
        self._net = igraph.Graph(len(stored.indptr) - 1, ends.tolist())

    def length(self, made: Graph, obstacles: Obstacles, margin: float) -> float:
        """Dijkstra's algorithm, from start to goal."""
        shut = self._stored.shut(obstacles, margin)[self._once]
        way = self._net.get_shortest_path(
            made.start,
            made.goal,
            weights=np.where(shut, np.inf, self._lengths).tolist(),
            output="vpath",
        )
        return float(np.linalg.norm(np.diff(made.points[way], axis=0), axis=1).sum())


class _Networkx:
    """networkx keeps the whole mesh, and asks of each edge whether it is shut."""

    def __init__(self, stored: _Stored) -> None:
        import networkx

        self._stored = stored
        self._net = networkx.Graph()
        columns = (stored.tails, stored.heads, stored.lengths)
        for k, (a, b, length) in enumerate(zip(*(c.tolist() for c in columns), strict=True)):
            if a < b:
                self._net.add_edge(a, b, length=length, place=k)
        self._places = stored.whole.points.tolist()

    def length(self, made: Graph, obstacles: Obstacles, margin: float) -> float:
        """A* with the straight line."""
        import networkx

        shut = self._stored.shut(obstacles, margin).tobytes()
        goal = self._places[made.goal]
        way = networkx.astar_path(
            self._net,
            made.start,
            made.goal,
            heuristic=lambda node, _: math.dist(self._places[node], goal),
            weight=lambda a, b, edge: None if shut[edge["place"]] else edge["length"],
        )
        return float(np.linalg.norm(np.diff(made.points[way], axis=0), axis=1).sum())


@register_jitable
def _side(
    axes: Axes, core: Core, solid: FloatArray, margin: float, x: float, y: float, z: float
) -> int:
    """Where a node is: ``_GONE``, or bits for the sides of the bounds beyond which it lies."""
    side = (
        (1 if x <= solid[17] - margin else 0)
        | (2 if x >= solid[20] + margin else 0)
        | (4 if y <= solid[18] - margin else 0)
        | (8 if y >= solid[21] + margin else 0)
        | (16 if z <= solid[19] - margin else 0)
        | (32 if z >= solid[22] + margin else 0)
    )
    if side == 0:
        p = in_body(axes, (x - solid[0], y - solid[1], z - solid[2]))
        side = _GONE if signed_distance(core, p) < margin else 0
    return side


@register_jitable
def _comes_near(
    axes: Axes,
    core: Core,
    solid: FloatArray,
    margin: float,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
) -> bool:
    """Whether an edge between two free nodes comes nearer to a solid than the margin."""
    p = in_body(axes, (ax - solid[0], ay - solid[1], az - solid[2]))
    return segment_within(core, margin, p, in_body(axes, (bx - ax, by - ay, bz - az)))


@numba.njit(cache=True, error_model="numpy")
def _open(
    indptr: IntArray,
    heads: IntArray,
    lengths: FloatArray,
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    solid: FloatArray,
    margin: float,
    sides: ByteArray,
    new_indptr: IntArray,
    new_heads: IntArray,
    new_lengths: FloatArray,
) -> int:
    """Rows without the edges that a solid shuts; how many are left. May write over the rows."""
    axes, core = axes_of(solid, 0), core_of(solid, 0)
    for node in range(len(x)):
        sides[node] = _side(axes, core, solid, margin, x[node], y[node], z[node])
    count, k = 0, indptr[0]
    for tail in range(len(x)):
        end = indptr[tail + 1]
        new_indptr[tail] = count
        side = sides[tail]
        while k < end:
            head = heads[k]
            other = sides[head]
            new_heads[count] = head
            new_lengths[count] = lengths[k]
            k += 1
            if side == _GONE or other == _GONE:
                continue
            if side & other == 0:
                # from the same end both times, for rounding
                a, b = min(tail, head), max(tail, head)
                if _comes_near(axes, core, solid, margin, x[a], y[a], z[a], x[b], y[b], z[b]):
                    continue
            count += 1
    new_indptr[len(x)] = count
    return count


@numba.njit(cache=True, error_model="numpy")
def _mark(
    indptr: IntArray,
    heads: IntArray,
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    solid: FloatArray,
    margin: float,
    sides: ByteArray,
    shut: BoolArray,
) -> None:
    """Mark the edges of rows that a solid shuts (2e,)."""
    axes, core = axes_of(solid, 0), core_of(solid, 0)
    for node in range(len(x)):
        sides[node] = _side(axes, core, solid, margin, x[node], y[node], z[node])
    for tail in range(len(x)):
        side = sides[tail]
        for k in range(indptr[tail], indptr[tail + 1]):
            other = sides[heads[k]]
            if side == _GONE or other == _GONE:
                shut[k] = True
            elif side & other == 0:
                a, b = min(tail, heads[k]), max(tail, heads[k])
                shut[k] |= _comes_near(
                    axes, core, solid, margin, x[a], y[a], z[a], x[b], y[b], z[b]
                )


def _way(before: IntArray, made: Graph) -> list[int]:
    way = [made.goal]
    while way[-1] != made.start:
        way.append(int(before[way[-1]]))
    return way


def main() -> None:
    """Print the table, and write it as JSON where asked."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--nodes", type=int, nargs="+", default=SIZES)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    rows = measure(options.nodes)
    print(table(rows))
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
