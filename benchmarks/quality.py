"""Length of each stage's path over the optimum, beside OMPL's planners at equal time.

    python -m benchmarks.quality --scenes 30

Each scene has 8 axis-parallel boxes in a workspace of 6 × 6 × 6, start and goal in opposite
corners, a clearance of 0.2 and about 20,000 nodes. Lengths are divided by the best length known,
which is found with much effort (``benchmarks.best_known``) and is no proof. Our time is that of a
change of the obstacles, the mesh being there: the mask, the search and what comes after. OMPL's
planners get the time that ours took up to the spline in the same scene, and once more a longer one.
A path that does not keep the clearance by the exact test does not count as solved.

Then one cube, whose optimum has a closed form, for meshes of all sizes and both diagonals.

A planner for many dimensions does far more than move a point in three; the comparison holds for the
tool's point only.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import math
import time
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from abi import compiling
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.exclusion_cache import ExclusionCache
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.scene.scene import Scene
from abi.search.build_graph import build_graph
from abi.search.search import SEARCHES
from abi.search.taut.taut_path import taut
from abi.tet_mesh.tet_mesh import TetMesh, tetrahedralise
from abi_sweep.random_boxes import CLEARANCE
from benchmarks.best_known import best_known
from tests.random_scenes import box_scene

_TIMES = 5
CUBE_PITCHES = (1.3, 0.58, 0.247, 0.113, 0.0658)  # 189 to 1,005,039 nodes

# past an edge of the cube, which the clearance rounds: a helix between two tangents
_AWAY = math.hypot(4.5, 1.5)
_TURN = math.pi / 2 - 2 * (math.atan2(1.5, 4.5) - math.asin(CLEARANCE / _AWAY))
CUBE_OPTIMUM = math.hypot(2 * math.sqrt(_AWAY**2 - CLEARANCE**2) + CLEARANCE * _TURN, 6)

Runs = dict[str, list[tuple[float, float]]]  # by method: ratio (inf: not solved) and ms


def is_ompl_installed() -> bool:
    """Check whether OMPL is installed; prints a line where it is not."""
    installed = importlib.util.find_spec("ompl") is not None
    if not installed:
        print("OMPL is not installed (pip install ompl): its planners are left out.")
    return installed


def measure(
    seeds: range, pitch: float, budgets: Sequence[float], with_ompl: bool
) -> tuple[Runs, list[float]]:
    """Run all methods; their runs, and the lower bounds over the best known lengths.

    Args:
        seeds: of the scenes.
        pitch: of the mesh.
        budgets: of OMPL's planners besides the time that ours took, [s].
        with_ompl: whether they run at all.
    """
    compiling.compile()
    Planner()(_scene(seeds.start, 1.0))
    first = _scene(seeds.start, pitch)
    mesh = tetrahedralise(first.workspace, first.mesh)
    runs: Runs = defaultdict(list)
    bounds = []
    for seed in seeds:
        scene = _scene(seed, pitch)
        plan = Planner()(scene)
        ours = _stages(plan, _times(mesh, scene, plan))
        equal = 1e-3 * ours["B-spline"][1]
        others = _ompl(scene, equal, budgets) if with_ompl else {}
        lengths = [length for methods in (ours, others) for length, _ in methods.values()]
        best = min(best_known(scene), *lengths)
        for name, (length, ms) in {**ours, **others}.items():
            runs[name].append((length / best, ms))
        if plan.optimum is not None:
            bounds.append(plan.optimum.length / best)
    return runs, bounds


def _scene(seed: int, pitch: float) -> Scene:
    """A scene of the tool alone: where the arm must avoid, the path is another."""
    return box_scene(seed, pitch).replace(arm={"avoid": False})


def _times(mesh: TetMesh, scene: Scene, plan: Plan) -> dict[str, float]:
    """Milliseconds from the move of an obstacle to the end of each stage, medians of a few."""
    margin = CLEARANCE + scene.workspace.slack
    exclude = ExclusionCache()
    to_path, to_taut = [], []
    for _ in range(_TIMES):
        exclude(mesh, ObstacleSet(scene.obstacles[1:]), margin)
        begin = time.process_time_ns()
        free = exclude(mesh, ObstacleSet(scene.obstacles), margin)
        problem = build_graph(
            free, ObstacleSet(scene.obstacles), margin, scene.start, scene.goal, CLEARANCE
        )
        path = SEARCHES["a_star"](problem, "length")
        middle = time.process_time_ns()
        taut(problem, ObstacleSet(scene.obstacles), margin, path)
        to_path.append(1e-6 * (middle - begin))
        to_taut.append(1e-6 * (time.process_time_ns() - begin))
    a_star, tightened = float(np.median(to_path)), float(np.median(to_taut))
    spline = tightened + plan.ms["bspline"]
    quadratic = spline + plan.ms["quadratic"]
    return {"A*": a_star, "taut": tightened, "B-spline": spline, "quadratic": quadratic}


def _stages(plan: Plan, ms: dict[str, float]) -> dict[str, tuple[float, float]]:
    """Length and ms so far of each stage; inf where a curve does not keep the clearance."""
    stages = {}
    if plan.path is not None and plan.taut is not None:
        stages["A*"] = plan.path.length, ms["A*"]
        stages["taut"] = plan.taut.length, ms["taut"]
    for name, fit, arc in (
        ("B-spline", plan.bspline, plan.bspline_arc),
        ("quadratic", plan.quadratic, plan.quadratic_arc),
    ):
        holds = fit is not None and arc is not None and fit.holds
        stages[name] = arc.length if holds and arc is not None else np.inf, ms[name]
    return stages


def past_cube(pitches: Sequence[float] = CUBE_PITCHES) -> list[dict[str, Any]]:
    """The taut path past one cube over the optimum in closed form, by size and by diagonal."""
    rows = []
    for pitch in pitches:
        for start, goal in (([0, 0, 0], [6, 6, 6]), ([6, 0, 0], [0, 6, 6])):
            scene = Scene.from_dict(
                {
                    "version": 1,
                    "start": start,
                    "goal": goal,
                    "obstacles": [{"shape": "box", "size": [3, 3, 3], "position": [3, 3, 3]}],
                    "mesh": {"lattice": "bcc", "pitch": pitch, "max_nodes": 2_000_000},
                    "spline": {"clearance": CLEARANCE},
                    "arm": {"avoid": False},
                }
            )
            plan = Planner()(scene, chosen_only=True)
            assert plan.mesh is not None
            assert plan.taut is not None
            rows.append(
                {
                    "nodes": len(plan.mesh.points),
                    "start": start,
                    "ratio": plan.taut.length / CUBE_OPTIMUM,
                }
            )
    return rows


def _ompl(scene: Scene, equal: float, budgets: Sequence[float]) -> dict[str, tuple[float, float]]:
    from benchmarks.ompl_planners import PLANNERS, solve

    runs = {}
    labels = [(equal, "equal"), *((budget, f"{1e3 * budget:.0f} ms") for budget in budgets)]
    for seconds, label in labels:
        for planner in PLANNERS:
            path, took = solve(planner, scene, seconds)
            length = np.inf
            if path is not None:
                blocked = ObstacleSet(scene.obstacles).blocked(
                    path[:-1], path[1:], CLEARANCE - 1e-9
                )
                if not blocked.any():
                    length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
            runs[f"{planner.name}, {label}"] = length, 1e3 * took
    return runs


def summary(runs: Runs) -> list[dict[str, Any]]:
    """One row for each method; a scene that was not solved counts as infinitely long."""
    rows = []
    for name, pairs in runs.items():
        ratio, ms = np.array(pairs).T
        ordered = np.sort(ratio)
        rows.append(
            {
                "method": name,
                "solved": int(np.isfinite(ratio).sum()),
                "ms": float(np.median(ms)),
                "median": float(ordered[(len(ordered) - 1) // 2]),
                "p90": float(ordered[int(np.ceil(0.9 * len(ordered))) - 1]),
                "worst": float(ordered[-1]),
                "within_1_percent": float((ratio <= 1.01).mean()),
            }
        )
    return rows


def main() -> None:
    """Print the table, and write it as JSON where asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=30)
    parser.add_argument("--first", type=int, default=0, help="seed of the first scene")
    parser.add_argument("--pitch", type=float, default=0.25, help="0.25 gives 19,909 nodes")
    parser.add_argument(
        "--budgets",
        type=float,
        nargs="*",
        default=[0.2],
        help="further budgets of OMPL's planners, s",
    )
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.scenes)
    runs, bounds = measure(seeds, options.pitch, options.budgets, is_ompl_installed())
    rows = summary(runs)
    print(f"\nlength / best known, {options.scenes} scenes of 8 boxes, pitch {options.pitch}")
    print(f"{'method':32}{'solved':>7}{'ms':>9}{'median':>9}{'p90':>9}{'worst':>9}{'in 1 %':>8}")
    for row in rows:
        print(
            f"{row['method']:32}{row['solved']:7}{row['ms']:9.2f}{row['median']:9.4f}"
            f"{row['p90']:9.4f}{row['worst']:9.4f}{row['within_1_percent']:8.0%}"
        )
    print(f"proven lower bound / best known: median {np.median(bounds):.4f}")
    cubes = past_cube()
    print("\none cube, taut path / optimum in closed form")
    for row in cubes:
        print(f"{row['nodes']:9} nodes, from {row['start']}: {row['ratio']:.6f}")
    if options.json:
        report = {
            "scenes": options.scenes,
            "pitch": options.pitch,
            "rows": rows,
            "bound": float(np.median(bounds)),
            "cube": cubes,
        }
        options.json.write_text(json.dumps(report, indent=1).replace("Infinity", "null") + "\n")


if __name__ == "__main__":
    main()
