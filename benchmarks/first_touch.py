"""Places of the box of the scene that the page opens on: a motion that is proven clear from each.

    python -m benchmarks.first_touch --places 1000

The box is put anywhere in the room where it leaves start and goal the clearance, as by a hand that
drags it: one planner goes through all places, and each plan counts as the page would draw it.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

import abi
from abi.arrays import FloatArray
from abi.explain.arm_faults import worst_limit
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.primitives import Box
from abi.planner.live_planner import LivePlanner
from abi.planner.plan import Plan
from abi.scene.scene import Scene, load_scene
from app.state.appearance import OPENING


def places(scene: Scene, count: int, seed: int) -> Iterator[FloatArray]:
    """Random places (3,) of the first obstacle, a box, off start and goal, [unit]."""
    chance = np.random.default_rng(seed)
    box = scene.obstacles[0]
    assert isinstance(box, Box)
    half = np.array(box.size) / 2
    low, high = scene.workspace.min + half, scene.workspace.max - half
    ends = np.array([scene.start, scene.goal], dtype=float)
    while count > 0:
        place = chance.uniform(low, high).round(3)
        moved = ObstacleSet((box.model_copy(update={"position": tuple(place.tolist())}),))
        gaps = moved.polyline_clearances(np.stack([ends, ends], axis=1))
        if gaps.min() > scene.spline.clearance:
            count -= 1
            yield place


def verdict(plan: Plan) -> str:
    """Why the page would show red for a plan; empty for one without a fault."""
    if plan.error is not None:
        return plan.error.message
    clear = plan.arm_clearance
    if clear is None or not clear.certified:
        return "the arm is not proven clear"
    if plan.bspline is None or not plan.bspline.holds:
        return "the B-spline is not proven clear"
    if plan.quadratic is None or not plan.quadratic.holds:
        return "the quadratic is not proven clear"
    return "" if worst_limit(plan) is None else "a joint passes a limit"


def measure(count: int, seed: int = 0) -> dict[str, Any]:
    """Plan at ``count`` places: ``proven``, the other ``verdicts`` counted, and times [ms]."""
    abi.compile()
    scene, planner = load_scene(OPENING), LivePlanner()
    planner(scene)
    verdicts, times = Counter[str](), []
    for place in places(scene, count, seed):
        box = scene.obstacles[0].model_dump(mode="json") | {"position": place.tolist()}
        moved = scene.replace(obstacles=[box])
        begin = time.perf_counter()
        plan = planner(moved)
        times.append(1e3 * (time.perf_counter() - begin))
        verdicts[verdict(plan)] += 1
    return {
        "places": count,
        "proven": verdicts.pop("", 0),
        "verdicts": dict(verdicts),
        "p50_ms": float(np.percentile(times, 50)),
        "p95_ms": float(np.percentile(times, 95)),
        "worst_ms": max(times),
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--places", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    print(json.dumps(measure(options.places, options.seed)), flush=True)


if __name__ == "__main__":
    main()
