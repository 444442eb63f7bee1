"""Share of scenes with a clear quadratic: least squares, the nearest clear one, and pieces.

Run ``python -m benchmarks.quadratics [SCENES]``.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Callable

import numpy as np

from abi.curves.fit_quadratic import Mode, fit
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.planner import plan
from abi.scene.scene import Scene
from tests.random_scenes import scattered, slalom

MODES: tuple[Mode, ...] = ("least_squares", "clear", "pieces")


def run(name: str, make: Callable[[np.random.Generator], Scene], scenes: int, seed: int) -> None:
    """Print shares and times over so many random scenes that have a B-spline."""
    rng = np.random.default_rng(seed)
    holds, pieces = Counter[Mode](), Counter[int]()
    ms: dict[Mode, list[float]] = {mode: [] for mode in MODES}
    search_ms: list[float] = []
    splines = planned = 0
    while planned < scenes:
        result = plan(make(rng))
        if result.bspline is None:
            continue
        planned += 1
        splines += result.bspline.holds
        arguments = ObstacleSet(result.scene.obstacles), result.bspline.required
        for mode in MODES:
            begin = time.perf_counter()
            fitted = fit(result.bspline, *arguments, mode)
            ms[mode].append(1e3 * (time.perf_counter() - begin))
            holds[mode] += fitted.holds
        pieces[len(fitted.curve.pieces) if fitted.holds else 0] += 1
        if holds["least_squares"] + len(search_ms) < planned:
            search_ms.append(ms["clear"][-1])
    print(f"{planned} random {name} scenes with a path (seed {seed})")
    print(f"B-spline clear       {splines / planned:8.2%}")
    for mode in MODES:
        parts = np.percentile(ms[mode], [50, 95, 100])
        times = "median {:.1f}, 95 % {:.1f}, most {:.0f} ms".format(*parts)
        print(f"{mode:14} clear {holds[mode] / planned:8.2%}   {times}")
    print("pieces needed       ", dict(sorted(pieces.items())), "(0: none found)")
    print(f"clear, where it had to search: median {np.median(search_ms or [0]):.1f} ms")


if __name__ == "__main__":
    size = int(sys.argv[1]) if len(sys.argv) > 1 else 300
    run("scattered (1 to 4 obstacles)", scattered, size, 0)
    run("slalom", slalom, max(size // 6, 1), 0)
