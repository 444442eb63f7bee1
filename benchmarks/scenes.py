"""Random scenes by the thousand: does every plan keep its word?

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
    """Plan one scene and look for broken promises."""
    try:
        made = plan(random_scene(seed))
        made.to_dict()
    except Exception:
        return {"seed": seed, "fault": "exception", "detail": traceback.format_exc(limit=3)}
    return {"seed": seed, "fault": _fault(made), **_outcome(made)}


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


def _fault(made: Plan) -> str:
    """The first promise that the plan breaks; empty when it keeps all."""
    asked = made.scene.spline.clearance
    for found in (made.path, made.taut):
        if found is not None and len(found.points) > 1:
            share = np.linspace(0, 1, DENSE // len(found.points))[:, None, None]
            dense = found.points[:-1] + share * np.diff(found.points, axis=0)
            distance, _ = ObstacleSet(made.scene.obstacles).nearest(dense.reshape(-1, 3))
            if distance.min() < asked - 1e-8:
                return "refuted"
    for fit in (made.bspline, made.quadratic):
        if fit is not None and fit.holds:
            dense = fit.curve(np.linspace(*fit.curve.interval, DENSE))
            distance, _ = ObstacleSet(made.scene.obstacles).nearest(dense)
            if distance.min() < fit.clearance.distance - 1e-9:
                return "refuted"
    values = [getattr(found, made.scene.search.weight) for found in made.searches]
    if values and max(values) - min(values) > 1e-9 * max(values):
        return "no tie"
    if made.error is not None and made.error.kind == "no_path" and made.graph is not None:
        joined = networkx.has_path(made.graph.to_networkx(), made.graph.start, made.graph.goal)
        return "refused" if joined else ""
    return ""


def _outcome(made: Plan) -> dict[str, Any]:
    curves = {"bspline": made.bspline, "quadratic": made.quadratic}
    return {
        "error": None if made.error is None else made.error.kind,
        "mode": made.scene.quadratic.mode,
        "ms": made.total_ms,
        **{name: None if curve is None else curve.holds for name, curve in curves.items()},
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
