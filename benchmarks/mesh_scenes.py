"""Campaign over random scenes of triangle meshes, against distances by another library.

    python -m benchmarks.mesh_scenes --scenes 3000 --masks 200

Each scene has one to four meshes, closed and open, in any pose. Paths and certified curves are
sampled densely, and VTK says how far the samples are from the triangles; of the first scenes all
nodes and edges are compared, too (:mod:`benchmarks.mesh_masks`). What is counted: exceptions, wrong
masks, and paths and certified curves that a sample refutes. All must be 0. ``--first`` goes on
where an earlier portion ended.
"""

from __future__ import annotations

import argparse
import time
import traceback
from collections import Counter
from typing import Any

import numpy as np

from abi import compiling
from abi.arrays import FloatArray
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.triangle_mesh.repair import clean
from abi.planner.plan import Plan
from abi.planner.planner import plan
from abi.scene.scene import Scene
from benchmarks.mesh_masks import mask_fault
from tests.abi import mesh_oracles, meshes

_DENSE = 600
_RIGHT = {"planned", "no plan"}
_SHAPES = {
    "ball": meshes.sphere(2, 0.8),
    "blob": meshes.bumpy(3),
    "knot": meshes.knot(800),
    "rooms": meshes.room(2),
    "loose": meshes.soup(40),
    "half": (meshes.bumpy(2)[0], meshes.bumpy(2)[1][:160]),
}


def check(seed: int, mask: bool = False) -> str:
    """The outcome of one scene: ``refuted``, ``exception``, a wrong mask, or what was planned.

    Args:
        seed: number of the scene.
        mask: whether to compare all nodes and edges.
    """
    try:
        result = plan(random_scene(seed))
        result.to_dict()
    except Exception:
        traceback.print_exc(limit=4)
        return "exception"
    if _refuted(result):
        return "refuted"
    fault = mask_fault(result.scene) if mask else ""
    if fault:
        return f"wrong mask: {fault}"
    return "no plan" if result.path is None else "planned"


def random_scene(seed: int) -> Scene:
    """A scene from its number: one to four meshes in a workspace of 6 × 6 × 6."""
    random = np.random.default_rng(seed)
    obstacles = []
    for _ in range(random.integers(1, 5)):
        name = str(random.choice(list(_SHAPES)))
        fields: dict[str, Any] = {
            "position": tuple(random.uniform(1.5, 4.5, 3).tolist()),
            "wxyz": tuple(random.normal(size=4).tolist()),
            "scale": float(random.uniform(0.3, 1.2)),
        }
        shape = MeshShape.of(_SURFACES[name], f"{name}.stl", **fields)
        obstacles.append(shape.in_unit("m"))
    data = {
        "version": 1,
        "start": random.uniform(0, 1, 3).tolist(),
        "goal": random.uniform(5, 6, 3).tolist(),
        "mesh": {
            "lattice": str(random.choice(["bcc", "kuhn", "delaunay"])),
            "pitch": float(random.uniform(0.35, 0.9)),
            "seed": seed,
        },
        "spline": {"clearance": float(random.choice([0.0, 0.05, 0.2]))},
        "quadratic": {"mode": str(random.choice(["least_squares", "clear", "pieces"]))},
    }
    return Scene.from_dict(data).replace(obstacles=tuple(obstacles))


_SURFACES = {name: clean(*mesh) for name, mesh in _SHAPES.items()}


def _refuted(result: Plan) -> bool:
    """Check whether a sample of a path, or of a certified curve, is nearer than it may be."""
    asked = result.scene.spline.clearance
    for path in (result.path, result.taut):
        if path is not None and len(path.points) > 1:
            share = np.linspace(0, 1, max(_DENSE // len(path.points), 2))[:, None, None]
            samples = path.points[:-1] + share * np.diff(path.points, axis=0)
            if _nearest(result, samples.reshape(-1, 3)) < asked - 1e-8:
                return True
    for fit in (result.bspline, result.quadratic):
        if fit is not None and fit.clearance.certified:
            samples = fit.curve(np.linspace(*fit.curve.interval, _DENSE))
            if _nearest(result, samples) < fit.clearance.distance - 1e-9:
                return True
    return False


def _nearest(result: Plan, points: FloatArray) -> float:
    """Least signed distance of points (n, 3) to the meshes; a point inside one counts as -1."""
    least = np.inf
    for mesh in result.scene.obstacles:
        assert isinstance(mesh, MeshShape)
        triangles = mesh.triangles()
        faces = np.arange(3 * len(triangles), dtype=np.int32).reshape(-1, 3)
        away = mesh_oracles.distances((triangles.reshape(-1, 3), faces), points)
        least = min(least, float(away.min()))
        low, high = mesh.bounds()
        within = points[((points > low) & (points < high)).all(axis=1)][:: max(_DENSE // 20, 1)]
        # a curve that touches nothing is inside as a whole, and a few samples tell
        if mesh.closed and len(within):
            numbers = mesh_oracles.winding_numbers(triangles, within)
            least = -1.0 if (np.abs(numbers) > 0.5).any() else least
    return least


def main() -> None:
    """Run the campaign and print how many scenes had which outcome."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--scenes", type=int, default=3_000)
    parser.add_argument("--first", type=int, default=0, help="number of the first scene")
    parser.add_argument("--masks", type=int, default=200, help="scenes with all nodes and edges")
    options = parser.parse_args()
    compiling.compile()
    begin = time.perf_counter()
    outcomes: Counter[str] = Counter()
    for seed in range(options.first, options.first + options.scenes):
        outcome = check(seed, mask=seed < options.masks)
        outcomes[outcome] += 1
        if outcome not in _RIGHT:
            print(f"scene {seed}: {outcome}", flush=True)
    print(dict(outcomes), f"{time.perf_counter() - begin:.0f} s")
    raise SystemExit(not set(outcomes) <= _RIGHT)


if __name__ == "__main__":
    main()
