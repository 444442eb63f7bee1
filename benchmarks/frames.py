"""Cost of a drag: our frame beside that of graph libraries, by stage and by size.

    python -m benchmarks.frames --nodes 200 2000 20000 200000 1000000

An obstacle moves a little from frame to frame. A frame is all that a user pays for: the mask
(nodes and edges that the obstacles exclude) and a search. Ours is the planner's exclusion,
``build_graph`` and one of the searches. Libraries store their edges, and search with what they do
best. Their frame is a compiled mask over these edges, the weights or rows that the library
takes, and its search. That mask (``benchmarks.stored_mesh``) is compared with ours, edge by edge.

The re-plan is a tab's work in a drag: every stage, with A* alone; the other two searches follow in
the next pause. The chain is its part after the path: clearances, certificates, curves, timing and
the arm.

All methods see the same frames, and every length is compared on every frame. They run in turn, a
few frames at a stretch, in one process, for a drag is one method frame after frame. Times are
medians of the process's own time, ratios are taken of these.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from pathlib import Path

import numpy as np

from abi import compiling
from abi.arm_planning.models import model_of
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.exclusion_cache import ExclusionCache
from abi.planner.planner import Planner
from abi.scene.scene import Scene
from abi.search.build_graph import build_graph
from abi.search.search import SEARCHES
from abi.search.taut.taut_path import taut
from abi.tet_mesh.tet_mesh import TetMesh, tetrahedralise
from benchmarks import graph_libraries
from benchmarks.graph_libraries import Library
from benchmarks.report import Row, table
from benchmarks.stored_mesh import StoredMesh
from tests.random_scenes import box_scene

SIZES = (200, 2_000, 20_000, 200_000, 1_000_000)
CLEARANCE = 0.2

_CHAIN = ("path_clearance", "bspline", "quadratic", "timing", "arm")
"""From the path to the arm's motion, certificates included."""

_SEED = 32  # of the scene with 8 boxes
_SWING = 0.4  # how far the obstacle moves to each side, [unit]
_FRAMES = ((3_000, 10, 12), (30_000, 5, 6), (300_000, 3, 4), (20_000_000, 2, 3))
"""By number of nodes: how often each method has its turn, and frames a turn."""

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
    # of the tool alone: where the arm must avoid, the path is another (benchmarks.arm)
    scenes = _frames_of(_SCENES[name](_pitch(size)).replace(arm={"avoid": False}))
    first = next(scenes)
    mesh = tetrahedralise(first.workspace, first.mesh)
    nodes = len(mesh.points)
    stored = StoredMesh(mesh)
    libraries = graph_libraries.installed(stored)
    turns, stretch = next(frames for most, *frames in _FRAMES if nodes <= most)
    model_of(first.arm, first.unit)  # a planner counts its making, slow at first, in every plan
    planner, exclude = Planner(), ExclusionCache()
    times: Times = defaultdict(list)
    for turn in range(turns + 1):
        taken = _turn(mesh, list(islice(scenes, stretch)), exclude, planner, stored, libraries)
        if turn > 0:  # the first fills caches
            for method, ms in taken.items():
                times[method] += ms
    medians = {method: statistics.median(values) for method, values in times.items()}
    library_frames = [ms for method, ms in medians.items() if method.startswith("frame, ")]
    rows = []
    for method, median in medians.items():
        row: Row = {"scene": name, "nodes": nodes, "method": method, "ms": median}
        if method.removeprefix("frame ") in SEARCHES and method not in SEARCHES:
            row["faster"] = min(library_frames) / median
            if "frame, networkx" in medians:
                row["than_networkx"] = medians["frame, networkx"] / median
        rows.append(row)
    return rows


def _turn(
    mesh: TetMesh,
    scenes: list[Scene],
    exclude: ExclusionCache,
    planner: Planner,
    stored: StoredMesh,
    libraries: dict[str, Library],
) -> Times:
    """Milliseconds of each method on each of some frames; all lengths are the same."""
    margin = CLEARANCE + scenes[0].workspace.slack
    times: Times = defaultdict(list)
    graphs, lengths = [], []
    for scene in scenes:
        with _Clock(times, "mask"):
            free = exclude(mesh, ObstacleSet(scene.obstacles), margin)
            problem = build_graph(
                free, ObstacleSet(scene.obstacles), margin, scene.start, scene.goal, CLEARANCE
            )
        results = {}
        for name, search in SEARCHES.items():
            with _Clock(times, name):
                results[name] = search(problem, "length")
            times[f"frame {name}"].append(times["mask"][-1] + times[name][-1])
        graphs.append(problem)
        lengths.append([result.length for result in results.values()])
    for scene, problem in zip(scenes, graphs, strict=True):
        with _Clock(times, "library mask"):
            rows = stored.open_rows(scene.obstacles, margin)
        assert len(rows[1]) == 2 * problem.edge_count
    assert all(map(np.array_equal, rows[:2], (problem.indptr, problem.indices)))
    for name, library in libraries.items():
        for scene, problem, same in zip(scenes, graphs, lengths, strict=True):
            with _Clock(times, f"frame, {name}"):
                length = library(problem, scene.obstacles, margin)
            same.append(length)
    for same in lengths:
        assert max(same) - min(same) <= 1e-9 * same[0], same
    with _Clock(times, "taut"):
        taut(problem, ObstacleSet(scene.obstacles), margin, results["a_star"])
    for scene, same in zip(scenes, lengths, strict=True):
        with _Clock(times, "re-plan"):
            plan = planner(scene, chosen_only=True)
        assert plan.path is not None
        assert abs(plan.path.length - same[0]) <= 1e-9 * same[0]
        times["chain"].append(sum(plan.ms[stage] for stage in _CHAIN))
    return times


class _Clock:
    """Timer of a block's process time, [ms]."""

    def __init__(self, times: Times, name: str) -> None:
        self._times = times[name]

    def __enter__(self) -> None:
        self._begin = time.process_time_ns()

    def __exit__(self, *_: object) -> None:
        self._times.append(1e-6 * (time.process_time_ns() - self._begin))


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
    """Pitch for about so many nodes in a workspace of 6 × 6 × 6, [unit]."""
    cells = min(range(1, 200), key=lambda n: abs((n + 1) ** 3 + n**3 - nodes))
    return 6 / cells * math.sqrt(3) / 2


def _frames_of(scene: Scene) -> Iterator[Scene]:
    """Copies of the scene with its first obstacle moving to and fro."""
    obstacle = scene.obstacles[0]
    k = 0
    while True:
        x, y, z = obstacle.position
        moved = obstacle.model_copy(
            update={"position": (x + _SWING * math.sin(0.37 * k + 0.1), y, z)}
        )
        yield scene.model_copy(update={"obstacles": (moved, *scene.obstacles[1:])})
        k += 1


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
