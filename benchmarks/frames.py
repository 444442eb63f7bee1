"""What a drag costs: our frame beside that of graph libraries, by stage and by size.

    python -m benchmarks.frames --nodes 200 2000 20000 200000 1000000

An obstacle moves a little from frame to frame. A frame is the mask (nodes and edges that the
obstacles take) and a search. Libraries get our mask, as rows that a compiled loop writes, and
search with what they do best; networkx, too slow to be rebuilt, asks the mask edge by edge. All
methods see the same frames in turn, in one process, and every length is compared on every frame.
Times are medians of the process's own time, ratios are taken of these.
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
from pathlib import Path
from typing import Any

import numba
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from abi import graph, mesh
from abi.arrays import BoolArray, FloatArray, IntArray
from abi.graph import Graph
from abi.kernels import warm
from abi.plan import SLACK, Planner
from abi.scene import Scene
from abi.search import SEARCHES, SearchResult
from abi.taut import taut
from benchmarks.quality import box_scene
from benchmarks.report import table

SIZES = (200, 2_000, 20_000, 200_000, 1_000_000)
CLEARANCE = 0.2

_CHAIN = ("path_clearance", "bspline", "quadratic", "timing", "arm")
"""From the path to the arm's motion, certificates and clearances included; by the clock."""

_SEED = 32  # of the scene with 8 boxes
_SWING = 0.4  # how far the obstacle moves to each side, [unit]
_FRAMES = ((3_000, 60), (30_000, 24), (300_000, 9), (20_000_000, 5))  # by number of nodes
_MOST_NETWORKX = 30_000

Row = dict[str, Any]
Library = Callable[[Graph], float]


def measure(sizes: Sequence[int] = SIZES) -> list[Row]:
    """Time all methods in both scenes at about so many nodes.

    Returns:
        Rows with ``scene``, ``nodes``, ``method``, ``ms`` and, for our frames, ``faster``: the best
        library's frame over ours, and ``than_networkx``. Methods named "frame" are whole frames.
    """
    warm()
    return [row for size in sizes for name in _SCENES for row in _measure(name, size)]


def _measure(name: str, size: int) -> list[Row]:
    scenes = _frames_of(_SCENES[name](_pitch(size)))
    first = next(scenes)
    whole = mesh.tetrahedralise(first.workspace, first.mesh)
    nodes = len(whole.points)
    libraries = _libraries(whole)
    frames = next(count for most, count in _FRAMES if nodes <= most)
    planner = Planner()
    times: dict[str, list[float]] = defaultdict(list)
    for k, scene in zip(range(frames + 2), scenes, strict=False):
        found = _frame(whole, scene, planner, libraries)
        if k >= 2:  # the first frames fill caches
            for method, ms in found.items():
                times[method].append(ms)
    medians = {method: statistics.median(values) for method, values in times.items()}
    others = [ms for method, ms in medians.items() if method.startswith("frame, ")]
    rows = []
    for method, ms in medians.items():
        row: Row = {"scene": name, "nodes": nodes, "method": method, "ms": ms}
        if method.removeprefix("frame ") in SEARCHES:
            row["faster"] = min(others) / ms
            if "frame, networkx" in medians:
                row["than_networkx"] = medians["frame, networkx"] / ms
        rows.append(row)
    return rows


def _frame(
    whole: mesh.TetMesh, scene: Scene, planner: Planner, libraries: dict[str, Library]
) -> dict[str, float]:
    """Milliseconds of each method on one frame; all lengths are the same."""
    margin = CLEARANCE + SLACK * max(scene.workspace.size)
    ms: dict[str, float] = {}
    with _Clock(ms, "mask"):
        free = mesh.exclude(whole, scene.obstacles, margin)
        made = graph.build(free, scene.obstacles, margin, scene.start, scene.goal, CLEARANCE)
    found: dict[str, SearchResult] = {}
    for name, search in SEARCHES.items():
        with _Clock(ms, name):
            found[name] = search(made, "length")
    with _Clock(ms, "taut"):
        taut(made, scene.obstacles, margin, found["a_star"])
    for name in SEARCHES:
        ms[f"frame {name}"] = ms["mask"] + ms[name]
    lengths = [result.length for result in found.values()]
    for name, library in libraries.items():
        with _Clock(ms, name):
            lengths.append(library(made))
        ms[f"frame, {name}"] = ms["mask"] + ms.pop(name)
    assert max(lengths) - min(lengths) <= 1e-9 * lengths[0], (scene, lengths)
    with _Clock(ms, "whole plan"):
        plan = planner(scene)
    assert plan.path is not None
    assert abs(plan.path.length - lengths[0]) <= 1e-9 * lengths[0]
    ms["chain"] = sum(plan.ms[stage] for stage in _CHAIN)
    return ms


class _Clock:
    """Writes the process time that a block took, [ms]."""

    def __init__(self, into: dict[str, float], name: str) -> None:
        self._into, self._name = into, name

    def __enter__(self) -> None:
        self._begin = time.process_time_ns()

    def __exit__(self, *_: object) -> None:
        self._into[self._name] = 1e-6 * (time.process_time_ns() - self._begin)


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


def _libraries(whole: mesh.TetMesh) -> dict[str, Library]:
    """Those that are installed, each as a function from the graph to the path's length."""
    rows = _Rows(whole)
    found: dict[str, Library] = {"scipy": rows.scipy}
    if importlib.util.find_spec("networkit"):
        found["networkit"] = rows.networkit
    if importlib.util.find_spec("igraph"):
        found["igraph"] = rows.igraph
    if len(whole.points) <= _MOST_NETWORKX:
        found["networkx"] = _Networkx(whole).length
    return found


class _Rows:
    """Libraries that search in compressed rows or lists of edges; the rows of the whole mesh."""

    def __init__(self, whole: mesh.TetMesh) -> None:
        self._whole = whole
        tail, head = whole.edges.T
        steps = np.concatenate([_directions(whole), _directions(whole, back=True)])
        tail, head = np.concatenate([tail, head]), np.concatenate([head, tail])
        order = np.lexsort((head, tail))
        self._heads, self._bits = head[order].astype(np.int32), steps[order].astype(np.int32)
        self._weights = np.concatenate([whole.lengths, whole.lengths])[order]
        self._indptr = np.zeros(len(whole.points) + 1, dtype=np.int32)
        np.cumsum(np.bincount(tail, minlength=len(whole.points)), out=self._indptr[1:])
        self._away: FloatArray | None = None
        self._igraph: Any = None

    def _open(self, made: Graph) -> tuple[IntArray, IntArray, FloatArray]:
        assert not len(made.own), "start and goal are nodes of the mesh"
        return _opened(
            self._indptr, self._heads, self._bits, self._weights, made.exits, made.excluded
        )

    def scipy(self, made: Graph) -> float:
        """Dijkstra's algorithm over the rows."""
        indptr, heads, weights = self._open(made)
        rows = csr_array((weights, heads, indptr), shape=(len(indptr) - 1,) * 2)
        cost, before = dijkstra(rows, indices=made.start, return_predecessors=True)
        _way(before, made)
        return float(cost[made.goal])

    def networkit(self, made: Graph) -> float:
        """A* with the straight line."""
        import networkit

        networkit.setNumberOfThreads(1)
        indptr, heads, weights = self._open(made)
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

    def igraph(self, made: Graph) -> float:
        """Dijkstra's algorithm, from start to goal."""
        import igraph

        if self._igraph is None:
            self._igraph = igraph.Graph(len(self._whole.points), self._whole.edges.tolist())
            tails = np.repeat(np.arange(len(self._indptr) - 1), np.diff(self._indptr))
            once = np.flatnonzero(tails < self._heads)
            mesh_order = np.lexsort((self._whole.edges[:, 1], self._whole.edges[:, 0]))
            self._once = np.empty(len(once), dtype=np.int64)
            self._once[mesh_order] = once
            self._tails = tails
        is_open = (made.exits[self._tails[self._once]] >> self._bits[self._once]) & 1 == 1
        is_open &= ~made.excluded[self._tails[self._once]]
        weights = np.where(is_open, self._weights[self._once], np.inf)
        way = self._igraph.get_shortest_path(
            made.start, made.goal, weights=weights.tolist(), output="vpath"
        )
        return float(np.linalg.norm(np.diff(made.points[way], axis=0), axis=1).sum())


class _Networkx:
    """networkx keeps the whole mesh, and its weights say which edges are shut."""

    def __init__(self, whole: mesh.TetMesh) -> None:
        import networkx

        self._net = networkx.Graph()
        back = _directions(whole, back=True)
        for (a, b), length, there, other in zip(
            whole.edges.tolist(), whole.lengths.tolist(), _directions(whole), back, strict=True
        ):
            self._net.add_edge(a, b, length=length, bits={a: int(there), b: int(other)})
        self._places = whole.points.tolist()

    def length(self, made: Graph) -> float:
        """A* with the straight line."""
        import networkx

        exits, excluded = made.exits.tolist(), made.excluded.tolist()
        goal = self._places[made.goal]
        way = networkx.astar_path(
            self._net,
            made.start,
            made.goal,
            heuristic=lambda node, _: math.dist(self._places[node], goal),
            weight=lambda a, b, edge: (
                None
                if excluded[a] or excluded[b] or not exits[a] >> edge["bits"][a] & 1
                else edge["length"]
            ),
        )
        return float(np.linalg.norm(np.diff(made.points[way], axis=0), axis=1).sum())


def _directions(whole: mesh.TetMesh, back: bool = False) -> IntArray:
    """Number of each edge of the mesh at its first end, or at its second (e,)."""
    from abi import lattice

    assert whole.stencil is not None
    ids = np.empty(len(whole.points), dtype=np.bool_)
    families = lattice.edges(whole.lattice, ids, whole.cells)
    return np.concatenate(
        [np.full(a.size, whole.stencil.ends(step)[back], np.int32) for a, _, step in families]
    )


@numba.njit(cache=True)
def _opened(
    indptr: IntArray,
    heads: IntArray,
    bits: IntArray,
    weights: FloatArray,
    exits: IntArray,
    excluded: BoolArray,
) -> tuple[IntArray, IntArray, FloatArray]:
    """The rows without the edges that are shut."""
    nodes = len(indptr) - 1
    starts = np.empty(nodes + 1, np.int32)
    found = np.empty(len(heads), np.int32)
    lengths = np.empty(len(heads), np.float64)
    count = 0
    for node in range(nodes):
        starts[node] = count
        if excluded[node]:
            continue
        for k in range(indptr[node], indptr[node + 1]):
            found[count] = heads[k]
            lengths[count] = weights[k]
            count += (exits[node] >> bits[k]) & 1
    starts[nodes] = count
    return starts, found[:count], lengths[:count]


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
