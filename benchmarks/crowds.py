"""Cost of many obstacles: first plan and drag, from ten to two thousand.

    python -m benchmarks.crowds --counts 10 200 2000

The workspace is filled to the same part whatever their number. What is dragged stands nearest to
its middle. Each plan's path and proven curve are compared with all obstacles one by one.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from abi import compiling
from abi.arrays import FloatArray
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.scene.scene import Scene
from benchmarks import report
from tests.random_scenes import crowd

COUNTS = (10, 50, 200, 400, 1_000, 2_000)
NODES = 20_000
_STEPS = 24
_SAMPLES = 2_000
_ROUNDING = 1e-7


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
        begin = time.perf_counter()
        plan = planner(scene)
        first = 1e3 * (time.perf_counter() - begin)
        _check(plan)
        frames, taut = [], []
        for moved in _drag(scene):
            begin = time.perf_counter()
            plan = planner(moved, chosen_only=True)
            frames.append(1e3 * (time.perf_counter() - begin))
            taut.append(plan.ms["taut"])
        _check(plan)
        row: report.Row = {"obstacles": count, "meshes": round(meshes * count), "first_ms": first}
        row |= {
            "drag_ms": float(np.median(frames)),
            "drag_p95_ms": float(np.quantile(frames, 0.95)),
        }
        row |= {
            "taut_ms": float(np.median(taut)),
            "solved": plan.bspline is not None and plan.bspline.holds,
        }
        row["ratio"] = row["drag_ms"] / rows[0]["drag_ms"] if rows else 1.0
        rows.append(row)
    return rows


def _drag(scene: Scene) -> list[Scene]:
    """The scene with the obstacle nearest to the middle moved along a small circle."""
    middle = (np.array(scene.workspace.min) + np.array(scene.workspace.max)) / 2
    places = np.array([one.position for one in scene.obstacles])
    k = int(np.linalg.norm(places - middle, axis=1).argmin())
    scenes, obstacles = [], list(scene.obstacles)
    for angle in np.linspace(0, 2 * np.pi, _STEPS, endpoint=False):
        x, y, z = places[k] + 0.05 * np.array([np.cos(angle), np.sin(angle), 0.2])
        moved = scene.obstacles[k].model_copy(update={"position": (x, y, z)})
        obstacles[k] = moved
        scenes.append(scene.replace(obstacles=tuple(obstacles)))
    return scenes


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
