"""Random scenes in which the arm counts: solids of any shape, bases beside and under them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from abi.arm_planning.branch.elbow_branch import ElbowBranch
from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arm_planning.paper_arm_model import paper_arm
from abi.arm_planning.world.arm_worlds import paper_arm_world
from abi.arrays import FloatArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.scene.scene import Scene
from tests.random_scenes import mesh_source

_SHAPES = ("box", "sphere", "cylinder", "capsule")
_PLACES = ([3.0, -3.0, 0.0], [3.0, 3.0, -6.5], [-2.5, -1.5, 0.0], [8.0, 2.0, -1.0])
_TRIES = 400


def arm_scene(seed: int, pitch: float = 0.54, boxes: bool = False, meshes: bool = False) -> Scene:
    """1 to 8 obstacles, and ends at which the arm is clear on one branch at least.

    Args:
        seed: the number of the scene.
        pitch: of the mesh, [unit]; 0.54 gives 2,300 nodes.
        boxes: whether all obstacles are boxes and the base is the paper's.
        meshes: whether triangle meshes are among them: closed, turned inside out, and not closed.
    """
    random = np.random.default_rng(seed)
    for _ in range(_TRIES):
        base = _PLACES[0] if boxes else _PLACES[int(random.integers(len(_PLACES)))]
        shapes = ("box",) if boxes else (*_SHAPES, "mesh") if meshes else _SHAPES
        scene = Scene.from_dict(
            {
                "version": 1,
                "obstacles": [
                    _obstacle(random, str(random.choice(shapes)))
                    for _ in range(int(random.integers(1, 9)))
                ],
                "mesh": {"lattice": "bcc", "pitch": pitch},
                "spline": {"clearance": 0.2},
                "arm": {"base": base, "elbow": "auto"},
            },
            mesh_source(),
        )
        for _ in range(20):
            ends = random.uniform(0, 6, (2, 3))
            if np.linalg.norm(ends[1] - ends[0]) > 3 and free_branches(scene, ends):
                return scene.replace(start=ends[0].tolist(), goal=ends[1].tolist())
    raise AssertionError(f"scene {seed} has no free ends")


def free_branches(scene: Scene, ends: FloatArray) -> Sequence[str]:
    """Branches on which tool and arm are clear at both ends (2, 3)."""
    obstacles = ObstacleSet(scene.obstacles)
    if obstacles.signed_distance(ends).min() < scene.spline.clearance + 0.02:
        return []
    arm = paper_arm(scene.arm)
    collision_world = paper_arm_world(arm, obstacles, scene.workspace.min[2])
    branches = []
    for elbow in scene.arm.branches:
        branch = ElbowBranch(arm, elbow, collision_world, (0.0, 0.0), 0.0, 0.02)
        if all(branch.polyline_refutation(end[None]) is None for end in ends):
            branches.append(elbow)
    return branches


def dense_clearance(arm: PaperArm, motion: ArmMotion, obstacles: ObstacleSet) -> float:
    """Least distance of the capsules to an obstacle, at samples along them, measured singly."""
    ends = arm.place(motion.positions)
    shares = np.linspace(0, 1, 15)[:, None, None, None]
    points = (ends[:, :, 0] + shares * (ends[:, :, 1] - ends[:, :, 0])).reshape(-1, 3)
    radii = np.array([capsule.radius for capsule in arm.capsules])
    away = obstacles.nearest(points)[0].reshape(15, len(ends), -1) - radii
    return float(away.min())


def _obstacle(random: np.random.Generator, shape: str) -> dict[str, Any]:
    pose = {
        "position": random.uniform(0.4, 5.6, 3).tolist(),
        "wxyz": [1, 0, 0, 0] if random.random() < 0.5 else random.normal(size=4).tolist(),
    }
    if shape == "box":
        return {"shape": shape, "size": random.uniform(0.5, 2.4, 3).tolist(), **pose}
    if shape == "mesh":
        file = str(random.choice(sorted(mesh_source().files)))
        return {"shape": shape, "file": file, "scale": float(random.uniform(0.4, 1.2)), **pose}
    size = {"radius": float(random.uniform(0.2, 1.0))}
    if shape != "sphere":
        size["height"] = float(random.uniform(0.4, 2.4))
    return {"shape": shape, **size, **pose}
