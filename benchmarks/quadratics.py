"""How often one quadratic is enough: least squares, the nearest clear one, and pieces.

Run ``python -m benchmarks.quadratics [SCENES]``.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

from abi.curves.fit_quadratic import Mode, fit
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.planner import plan
from abi.scene.scene import Scene

MODES: tuple[Mode, ...] = ("least_squares", "clear", "pieces")


def scattered(rng: np.random.Generator, most: int = 4) -> Scene:
    """One to ``most`` obstacles of all shapes between start and goal."""
    obstacles: list[dict[str, Any]] = []
    for _ in range(rng.integers(1, most + 1)):
        shape = str(rng.choice(["box", "sphere", "cylinder", "capsule"]))
        a, b, c = rng.uniform(0.6, 2.6, 3).tolist()
        sizes: dict[str, dict[str, Any]] = {
            "box": {"size": [a, b, c]},
            "sphere": {"radius": a / 2},
            "cylinder": {"radius": a / 2, "height": b},
            "capsule": {"radius": a / 3, "height": b},
        }
        pose = {"position": rng.uniform(1.2, 4.8, 3).tolist(), "wxyz": rng.normal(size=4).tolist()}
        obstacles.append({"shape": shape, **sizes[shape], **pose})
    return _scene(rng, obstacles)


def slalom(rng: np.random.Generator) -> Scene:
    """Two to four walls across the workspace and far beyond, open on alternate sides."""
    count = int(rng.integers(2, 5))
    obstacles = []
    for k in range(count):
        end = float(rng.uniform(2.2, 4.2))
        y = end - 20 if k % 2 else end + 20
        x = 1.2 + 3.6 * (k + 0.5) / count + float(rng.uniform(-0.2, 0.2))
        obstacles.append({"shape": "box", "size": [0.2, 40, 40], "position": [x, y, 3]})
    return _scene(rng, obstacles)


def run(name: str, make: Callable[[np.random.Generator], Scene], scenes: int, seed: int) -> None:
    """Print the shares over random scenes that have a B-spline, and the times."""
    rng = np.random.default_rng(seed)
    holds, pieces = Counter[Mode](), Counter[int]()
    ms: dict[Mode, list[float]] = {mode: [] for mode in MODES}
    moved: list[float] = []
    splines = planned = 0
    while planned < scenes:
        made = plan(make(rng))
        if made.bspline is None or made.bspline_arc is None:
            continue
        planned += 1
        splines += made.bspline.holds
        asked = (made.bspline_arc, ObstacleSet(made.scene.obstacles), made.bspline.asked)
        for mode in MODES:
            begin = time.perf_counter()
            found = fit(made.bspline, *asked, mode)
            ms[mode].append(1e3 * (time.perf_counter() - begin))
            holds[mode] += found.holds
        pieces[len(found.curve.pieces) if found.holds else 0] += 1
        if holds["least_squares"] + len(moved) < planned:
            moved.append(ms["clear"][-1])
    print(f"{planned} random {name} scenes with a path (seed {seed})")
    print(f"B-spline clear       {splines / planned:8.2%}")
    for mode in MODES:
        parts = np.percentile(ms[mode], [50, 95, 100])
        times = "median {:.1f}, 95 % {:.1f}, most {:.0f} ms".format(*parts)
        print(f"{mode:14} clear {holds[mode] / planned:8.2%}   {times}")
    print("pieces needed       ", dict(sorted(pieces.items())), "(0: none found)")
    print(f"clear, where it had to search: median {np.median(moved or [0]):.1f} ms")


def _scene(rng: np.random.Generator, obstacles: list[dict[str, Any]]) -> Scene:
    return Scene.from_dict(
        {
            "version": 1,
            "start": rng.uniform(0, [1, 6, 6]).tolist(),
            "goal": rng.uniform([5, 0, 0], 6).tolist(),
            "obstacles": obstacles,
            "mesh": {"pitch": 0.6},
            "spline": {"clearance": 0.1},
        }
    )


if __name__ == "__main__":
    size = int(sys.argv[1]) if len(sys.argv) > 1 else 300
    run("scattered (1 to 4 obstacles)", scattered, size, 0)
    run("slalom", slalom, max(size // 6, 1), 0)
