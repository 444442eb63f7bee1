"""Campaign over random scenes: plans checked by dense sampling and by other means.

    python -m benchmarks.scenes --scenes 10000

Each scene has 1 to 20 obstacles of every shape, and a pitch, degree and clearance of its own. What
is counted: exceptions, paths and certified curves that dense sampling refutes, searches whose
lengths do not tie, and paths refused although the graph joins start and goal. All must be 0.
"""

from __future__ import annotations

import argparse
import collections
import json
import multiprocessing
import os
import time
import traceback
from typing import Any

import networkx
import numpy as np

from abi import compiling
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.plan import Plan
from abi.planner.planner import plan
from tests.random_scenes import random_scene

DENSE = 2000
FAULTS = ("exception", "refuted", "no tie", "refused")


def check(seed: int) -> dict[str, Any]:
    """Plan one scene and look for faults."""
    try:
        result = plan(random_scene(seed))
        result.to_dict()
    except Exception:
        return {"seed": seed, "fault": "exception", "detail": traceback.format_exc(limit=3)}
    return {"seed": seed, "fault": _fault(result), **_outcome(result)}


def main() -> None:
    """Run the campaign and print its figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0, help="number of the first scene")
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    begin = time.perf_counter()
    seeds = range(options.first, options.first + options.scenes)
    with multiprocessing.Pool(options.workers, initializer=compiling.compile) as pool:
        results = list(pool.imap_unordered(check, seeds, chunksize=20))
    figures = _figures(results, time.perf_counter() - begin)
    if options.json:
        print(json.dumps(figures, indent=1))
    else:
        for name, figure in figures.items():
            print(f"{name:36} {figure}")
    for result in results:
        if result["fault"]:
            print(result)
    raise SystemExit(any(result["fault"] for result in results))


def _fault(result: Plan) -> str:
    """The plan's first fault, of :data:`FAULTS`; empty without one."""
    required = result.scene.spline.clearance
    for path in (result.path, result.taut):
        if path is not None and len(path.points) > 1:
            share = np.linspace(0, 1, DENSE // len(path.points))[:, None, None]
            dense = path.points[:-1] + share * np.diff(path.points, axis=0)
            distance, _ = ObstacleSet(result.scene.obstacles).nearest(dense.reshape(-1, 3))
            if distance.min() < required - 1e-8:
                return "refuted"
    for fit in (result.bspline, result.quadratic):
        if fit is not None and fit.holds:
            dense = fit.curve(np.linspace(*fit.curve.interval, DENSE))
            distance, _ = ObstacleSet(result.scene.obstacles).nearest(dense)
            if distance.min() < fit.clearance.distance - 1e-9:
                return "refuted"
    values = [getattr(search, result.scene.search.weight) for search in result.searches]
    if values and max(values) - min(values) > 1e-9 * max(values):
        return "no tie"
    if result.error is not None and result.error.kind == "no_path" and result.graph is not None:
        connected = networkx.has_path(
            result.graph.to_networkx(), result.graph.start, result.graph.goal
        )
        return "refused" if connected else ""
    return ""


def _outcome(result: Plan) -> dict[str, Any]:
    fits = {"bspline": result.bspline, "quadratic": result.quadratic}
    return {
        "error": None if result.error is None else result.error.kind,
        "mode": result.scene.quadratic.mode,
        "ms": result.total_ms,
        **{name: None if fit is None else fit.holds for name, fit in fits.items()},
    }


def _figures(results: list[dict[str, Any]], seconds: float) -> dict[str, Any]:
    figures: dict[str, Any] = {"scenes": len(results)}
    figures |= {name: sum(result["fault"] == name for result in results) for name in FAULTS}
    figures |= collections.Counter(
        f"without a plan: {result['error']}" for result in results if result.get("error")
    )
    planned = [result for result in results if result.get("bspline") is not None]
    figures["with a path"] = len(planned)
    figures["B-spline proven clear"] = _share([result["bspline"] for result in planned])
    for mode in ("least_squares", "clear", "pieces"):
        chosen = [result["quadratic"] for result in planned if result["mode"] == mode]
        figures[f"quadratic proven clear, {mode}"] = _share(chosen)
    times = [result["ms"] for result in results if "ms" in result]
    figures["plan, median / 99 % [ms]"] = "{:.1f} / {:.1f}".format(*np.percentile(times, (50, 99)))
    figures["campaign [s]"] = round(seconds)
    return figures


def _share(held: list[Any]) -> str:
    return f"{sum(map(bool, held))} of {len(held)}"


if __name__ == "__main__":
    main()
