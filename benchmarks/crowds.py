"""Cost of many obstacles: first plan and drag, from ten to two thousand.

    python -m benchmarks.crowds --counts 10 200 2000 --meshes 0.33

The workspace is filled to the same part whatever their number. A solid and a mesh are dragged:
those nearest to its middle. Each plan's path and proven curve are compared with all obstacles one
by one, and where FCL is installed it is asked at each move how near they come to the path. Times
are those of the process.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from abi import compiling
from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.scene.scene import Scene
from benchmarks import report
from benchmarks.crowd_library import FclCrowd
from benchmarks.shape_libraries import installed
from tests.random_scenes import crowd

COUNTS = (10, 50, 200, 400, 1_000, 2_000)
NODES = 20_000
_STEPS = 24
_SAMPLES = 2_000
_ROUNDING = 1e-7

_AGREES = 1e-4
"""Difference from distances by FCL, which rounds more than we do, [unit]."""


def measure(counts: Sequence[int], meshes: float = 0.0) -> list[report.Row]:
    """Plan crowds and drag one obstacle of each; a row for each number.

    Args:
        counts: numbers of obstacles.
        meshes: part of the obstacles that are triangle meshes.

    Raises:
        AssertionError: a path or a proven curve comes nearer to an obstacle than it says.
    """
    compiling.compile()
    rows: list[report.Row] = []
    for count in counts:
        scene = crowd(count, 0, NODES, meshes)
        planner = Planner()
        planner(scene.replace(obstacles=scene.obstacles[:1]))
        begin = time.process_time()
        plan = planner(scene)
        first = 1e3 * (time.process_time() - begin)
        _check(plan)
        row: report.Row = {
            "obstacles": count,
            "meshes": len(ObstacleSet(scene.obstacles).meshes),
            "first_ms": first,
        }
        row |= _dragged(planner, scene, convex=True)
        row["ratio"] = row["drag_ms"] / rows[0]["drag_ms"] if rows else 1.0
        if row["meshes"]:
            of_mesh = _dragged(planner, scene, convex=False)
            row |= {f"mesh_{name}": of_mesh[name] for name in ("drag_ms", "drag_p95_ms")}
        rows.append(row)
    return rows


def _dragged(planner: Planner, scene: Scene, convex: bool) -> report.Row:
    """Drag the convex obstacle, or the mesh, that is nearest to the middle."""
    middle = (np.array(scene.workspace.min) + np.array(scene.workspace.max)) / 2
    obstacles = ObstacleSet(scene.obstacles)
    numbers = obstacles.primitive_numbers if convex else obstacles.mesh_numbers
    places = np.array([scene.obstacles[k].position for k in numbers])
    k = int(numbers[np.linalg.norm(places - middle, axis=1).argmin()])
    library = FclCrowd(scene.obstacles) if installed(("fcl",)) else None
    frames, taut, of_path, by_library = [], [], [], []
    for moved in _moved(scene, k):
        begin = time.process_time()
        plan = planner(moved, chosen_only=True)
        frames.append(1e3 * (time.process_time() - begin))
        taut.append(plan.ms["taut"])
        if library is not None and plan.taut is not None:
            begin = time.process_time()
            clearance = ObstacleSet(moved.obstacles).polyline_clearance(plan.taut.points)
            between = time.process_time()
            library.move(k, moved.obstacles[k])
            distance = library.distance(plan.taut.points)
            by_library.append(1e3 * (time.process_time() - between))
            of_path.append(1e3 * (between - begin))
            assert abs(distance - clearance) < _AGREES
    _check(plan)
    row: report.Row = {
        "drag_ms": float(np.median(frames)),
        "drag_p95_ms": float(np.quantile(frames, 0.95)),
        "taut_ms": float(np.median(taut)),
        "solved": plan.bspline is not None and plan.bspline.holds,
    }
    if of_path:
        row["path_ms"], row["fcl_path_ms"] = float(np.median(of_path)), float(np.median(by_library))
    return row


def _moved(scene: Scene, k: int) -> Iterator[Scene]:
    """The scene with an obstacle moved along a small circle."""
    place, obstacles = np.array(scene.obstacles[k].position), list(scene.obstacles)
    for angle in np.linspace(0, 2 * np.pi, _STEPS, endpoint=False):
        x, y, z = (place + 0.05 * np.array([np.cos(angle), np.sin(angle), 0.2])).tolist()
        obstacles[k] = scene.obstacles[k].model_copy(update={"position": (x, y, z)})
        yield scene.replace(obstacles=tuple(obstacles))


def _check(plan: Plan) -> None:
    """Compare path and B-spline with each obstacle by itself."""
    if plan.taut is None:
        return
    samples = _polyline_samples(plan.taut.points)
    assert _least(plan, samples) >= plan.taut.clearance - _ROUNDING
    if plan.bspline is not None and plan.bspline.clearance.certified:
        curve = plan.bspline.curve
        points = curve(np.linspace(curve.knots[0], curve.knots[-1], _SAMPLES))
        assert _least(plan, points) >= plan.bspline.clearance.distance - _ROUNDING


def _least(plan: Plan, points: FloatArray) -> float:
    return min(float(one.signed_distance(points).min()) for one in plan.scene.obstacles)


def _polyline_samples(points: FloatArray) -> FloatArray:
    shares = np.linspace(0, 1, _SAMPLES // len(points))[:, None, None]
    between: FloatArray = points[:-1] + shares * (points[1:] - points[:-1])
    return between.reshape(-1, 3)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--counts", type=int, nargs="+", default=COUNTS)
    parser.add_argument("--meshes", type=float, default=0.0, help="part that are triangle meshes")
    options: Any = parser.parse_args()
    print(report.table(measure(options.counts, options.meshes)))


if __name__ == "__main__":
    main()
