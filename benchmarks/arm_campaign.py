"""Campaign on the whole arm: random scenes of any shape, beside a fine lattice and OMPL.

Each scene has 1 to 8 obstacles, triangle meshes among them, its base beside the workspace or under
it, and ends at which tool and arm are clear on one branch at least. It is planned on 20,000 nodes.
A motion called clear is compared with dense samples of its capsules; every tenth certificate is
checked in exact numbers, as it is and damaged in three ways. Where no motion is found, and in every
fourth scene, a lattice of 100,000 places on both branches is searched for one. In every fourth
without triangle meshes OMPL's planners get 200 ms each in the arm's joint space, and the scene is
planned on 2,300 nodes, too.
"""

from __future__ import annotations

import copy
import importlib.util
import json
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.scene.scene import Scene
from abi.verify.verify import verify
from benchmarks.arm_lattice import Poses, lattice_motion
from benchmarks.report import Row
from tests.random_arms import arm_scene, dense_clearance

Record = dict[str, Any]

PITCH, COARSE_PITCH = 0.262, 0.54
"""For 20,000 and 2,300 nodes."""
BUDGET_MS = 200.0
"""Of each of OMPL's planners."""
_CHECK_EVERY, _COMPARE_EVERY = 10, 4
_ROUNDING = 1e-9
_FALSE = 1e-3
"""By which a damaged certificate claims too much, [unit]."""


def record(seed: int) -> Record:
    """Outcome of one scene, as plain data."""
    scene = arm_scene(seed, PITCH, meshes=True)
    plan, ms = _planned(scene)
    found: Record = {"seed": seed, "ms": ms, "length": _length(plan)}
    found["error"] = None if plan.error is None else plan.error.kind
    found["avoided"] = plan.tool_only is not None or found["error"] == "arm_not_clear"
    assert isinstance(plan.arm, PaperArm)
    is_clear = found["error"] is None
    if is_clear:
        assert plan.motion is not None
        assert plan.arm_clearance is not None
        dense = dense_clearance(plan.arm, plan.motion, ObstacleSet(scene.obstacles))
        found["refuted"] = bool(dense < plan.arm_clearance.distance - _ROUNDING)
        if seed % _CHECK_EVERY == 0:
            found |= _checked(plan, dense)
    compared = seed % _COMPARE_EVERY == 0
    if compared or not is_clear:
        found["lattice"] = lattice_motion(scene, plan.arm)
    if compared and not any(isinstance(shape, MeshShape) for shape in scene.obstacles):
        found |= _beside_ompl(scene, plan.arm)
    return found


def figures(records: Sequence[Record]) -> list[Row]:
    """The rows of a campaign: what was found and refuted, and lengths and times beside OMPL's."""
    clear = [one for one in records if one["error"] is None]
    checked = [one for one in clear if "verified" in one]
    with_lattice = [one for one in records if one.get("lattice") is not None]
    sampled = [one for one in with_lattice if one["seed"] % _COMPARE_EVERY == 0]
    none = [one for one in records if one["error"] is not None]
    row: Row = {
        "method": "whole arm, 20,000 nodes",
        "scenes": len(records),
        "tool's own plan not clear": sum(one["avoided"] for one in records),
        "none found": len(none),
        "of these the lattice finds": sum(one["error"] is not None for one in with_lattice),
        "lattice finds in every fourth": len(sampled),
        "of these we find": sum(one["error"] is None for one in sampled),
        "refuted": sum(one["refuted"] for one in clear),
        "checked exactly": len(checked),
        "refused": sum(not one["verified"] for one in checked),
        "damaged": sum(one["damaged"] for one in checked),
        "of these accepted": sum(one["accepted"] for one in checked),
        "ms": _percentile([one["ms"] for one in records], 50),
        "95 %": _percentile([one["ms"] for one in records], 95),
    }
    return [row, *_beside([one for one in records if one.get("ompl")])]


def _beside(records: Sequence[Record]) -> list[Row]:
    """Scenes solved, lengths over the shortest known, and times, of each method."""
    methods: dict[str, list[tuple[float | None, float, float]]] = {}
    for one in records:
        runs = {
            "whole arm, 20,000 nodes": (one["length"], one["ms"]),
            "whole arm, 2,300 nodes": tuple(one["coarse"]),
            **{name: tuple(run) for name, run in one["ompl"].items()},
        }
        lengths = [length for length, _ in runs.values() if length is not None]
        best = min(lengths, default=1.0)
        for name, (length, ms) in runs.items():
            methods.setdefault(name, []).append((length, ms, best))
    rows = []
    for name, found in methods.items():
        ratios = [length / best for length, _, best in found if length is not None]
        times = [ms for _, ms, _ in found]
        rows.append(
            {
                "method": name,
                "scenes": len(found),
                "solved": len(ratios),
                "length / best": _percentile(ratios, 50),
                "90 %": _percentile(ratios, 90),
                "ms": _percentile(times, 50),
                "95 %": _percentile(times, 95),
            }
        )
    return rows


def _percentile(values: Sequence[float], share: float) -> float | None:
    return float(np.percentile(values, share)) if values else None


def _planned(scene: Scene) -> tuple[Plan, float]:
    """A plan with one search, and its time without that of the mesh, [ms]."""
    planner = Planner(compile=False)
    # the mesh is there before an obstacle moves
    planner(scene.replace(obstacles=[], start=scene.start, goal=scene.goal), True)
    begin = time.perf_counter()
    plan = planner(scene, True)
    return plan, 1e3 * (time.perf_counter() - begin)


def _length(plan: Plan) -> float | None:
    """Length of the curve followed, [unit]; None without a motion that is proven clear."""
    arc = plan.bspline_arc if plan.followed == "bspline" else plan.quadratic_arc
    return None if plan.error is not None or arc is None else arc.length


def _checked(plan: Plan, dense: float) -> Record:
    """Check whether the certificate is accepted, and how many damaged ones."""
    data = json.loads(json.dumps(plan.to_dict()))
    meshes = plan.scene.meshes
    damaged = []
    claim = copy.deepcopy(data)
    if np.isfinite(dense):
        claim["arm"]["clearance"] = claim["arm"]["certificate"]["margin"] = dense + _FALSE
        damaged.append(claim)
    planes = data["arm"]["certificate"]["planes"]
    if planes:
        # all planes between a capsule and an obstacle: of a mesh there are more than it takes
        pair = _pair(planes[len(planes) // 2])
        fewer, turned = copy.deepcopy(data), copy.deepcopy(data)
        rest = [plane for plane in planes if _pair(plane) != pair]
        fewer["arm"]["certificate"]["planes"] = rest
        for plane in turned["arm"]["certificate"]["planes"]:
            if _pair(plane) == pair:
                plane["direction"] = [-number for number in plane["direction"]]
        damaged += [fewer, turned]
    return {
        "verified": _is_proven(data, meshes),
        "damaged": len(damaged),
        "accepted": sum(_is_proven(one, meshes) for one in damaged),
    }


def _pair(plane: Record) -> tuple[int, int | str]:
    return plane["capsule"], plane["obstacle"]


def _is_proven(data: Any, meshes: MeshSource) -> bool:
    return next(one for one in verify(data, meshes) if one.curve == "arm").proven


def _beside_ompl(scene: Scene, arm: PaperArm) -> Record:
    """Runs of OMPL's planners, where it is installed, and of a plan on a coarse mesh."""
    if importlib.util.find_spec("ompl") is None:
        return {}
    from benchmarks import arm_ompl

    poses = Poses(scene, arm)
    sides = np.array([1.0, -1.0])
    ends = []
    for end in (scene.start, scene.goal):
        points = np.array([end, end])
        joints, _ = poses.joints(points, sides)
        ends.append(joints[poses.free(points, sides)][:, :3])
    runs = {
        planner.name: arm_ompl.solve(planner, scene, arm, (ends[0], ends[1]), BUDGET_MS)
        for planner in arm_ompl.PLANNERS
    }
    coarse, ms = _planned(scene.replace(mesh={"pitch": COARSE_PITCH}))
    return {"ompl": runs, "coarse": (_length(coarse), ms)}
