"""The whole arm: motions found and refuted in random scenes, and the frames of a drag.

    python -m benchmarks.arm 200

Each scene has 1 to 8 obstacles and ends at which tool and arm are clear on one elbow at least. A
motion called clear is compared with dense samples of its capsules, each distance measured singly;
every tenth certificate is checked again in exact numbers. The frames are those of an obstacle that
is dragged where the tool's own plan is not clear for the arm: with both elbows at 2,300 nodes, with
the elbow in use at 20,000.
"""

from __future__ import annotations

import json
import sys
import time
from collections import Counter

import numpy as np

from abi import compiling
from abi.arm.arm import Arm
from abi.obstacles.obstacle_set import ObstacleSet
from abi.planner.planner import Planner
from abi.scene.scene import Scene
from abi.verify.verify import verify
from benchmarks.report import Row, table
from tests.random_arms import arm_scene, dense_clearance

_CHECK_EVERY = 10
_ROUNDING = 1e-9
_DRAGS = ((0.54, "auto", 2_300), (0.262, "up", 20_000))
_STEPS = 12
_SWING = 0.3  # of an obstacle to each side, [unit]


def measure(scenes: int) -> list[Row]:
    """Rows of the campaign and of the drags.

    Args:
        scenes: how many random scenes; a tenth of them is dragged in.
    """
    compiling.compile()
    rows = [campaign(scenes)]
    rows += [drag(*setting, max(scenes // 10, 5)) for setting in _DRAGS]
    return rows


def campaign(scenes: int, first: int = 0) -> Row:
    """Shares of random scenes in which the arm touches, avoids, and is proven clear."""
    counts: Counter[str] = Counter()
    ms: list[float] = []
    for seed in range(first, first + scenes):
        scene = arm_scene(seed)
        begin = time.thread_time()
        plan = Planner(compile=False)(scene)
        ms.append(1e3 * (time.thread_time() - begin))
        if plan.error is not None and plan.error.kind != "arm_not_clear":
            counts["no path for the tool"] += 1
            continue
        counts["scenes"] += 1
        counts["tool's own plan not clear"] += plan.tool_only is not None or plan.error is not None
        if plan.error is not None:
            counts["none found"] += 1
            continue
        assert isinstance(plan.arm, Arm)
        assert plan.motion is not None
        assert plan.arm_clearance is not None
        dense = dense_clearance(plan.arm, plan.motion, ObstacleSet(scene.obstacles))
        counts["refuted"] += dense < plan.arm_clearance.distance - _ROUNDING
        if seed % _CHECK_EVERY == 0:
            found = verify(json.loads(json.dumps(plan.to_dict())))
            counts["checked exactly"] += 1
            counts["of these refused"] += not next(
                one for one in found if one.curve == "arm"
            ).proven
    names = ("scenes", "tool's own plan not clear", "none found", "refuted", "checked exactly")
    return {
        "method": "whole arm",
        **{name: counts[name] for name in (*names, "of these refused")},
        "ms": float(np.median(ms)),
        "95 %": float(np.percentile(ms, 95)),
    }


def drag(pitch: float, elbow: str, nodes: int, scenes: int) -> Row:
    """Times of frames in which one obstacle moves."""
    frames: list[float] = []
    avoided = dragged = seed = 0
    while dragged < scenes:
        scene = arm_scene(seed, pitch, boxes=True).replace(arm={"elbow": elbow})
        planner, seed = Planner(compile=False), seed + 1
        if planner(scene, True).tool_only is None:
            continue
        dragged += 1
        for step in range(_STEPS):
            moved = _moved(scene, _SWING * np.sin(2 * np.pi * step / _STEPS))
            begin = time.thread_time()
            plan = planner(moved, True)
            frames.append(1e3 * (time.thread_time() - begin))
            avoided += plan.tool_only is not None
    return {
        "method": f"drag, elbow {elbow}",
        "nodes": nodes,
        "frames": len(frames),
        "avoiding": avoided,
        "ms": float(np.median(frames)),
        "95 %": float(np.percentile(frames, 95)),
    }


def _moved(scene: Scene, by: float) -> Scene:
    """The scene with its first obstacle a little to the side."""
    obstacles = scene.to_dict()["obstacles"]
    x, y, z = obstacles[0]["position"]
    first = {**obstacles[0], "position": [x + by, y, z]}
    return scene.replace(obstacles=[first, *obstacles[1:]])


if __name__ == "__main__":
    print(table(measure(int(sys.argv[1]) if len(sys.argv) > 1 else 100)))
